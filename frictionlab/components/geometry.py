"""Geometries: the coordinates, the penetration of slider and belt, and where the contact forces act."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from frictionlab.validation import check_choice

from .component import Component

DIRECTIONS = ("vertical", "normal")


@dataclass(frozen=True, repr=False)
class Geometry(Component):
    """Base of the geometries.

    The contact forces enter the equations of motion as W_N F_N + W_T F_T.
    """

    coordinates: ClassVar[tuple[str, ...]]

    def penetration(self, *q: Any) -> Any:
        """Penetration (m) at the coordinates `q`: positive in contact, negative in flight."""
        raise NotImplementedError(f"{type(self).__name__} must define penetration(...)")

    def normal(self, *q: Any) -> tuple[Any, ...]:
        """W_N: where the normal force enters."""
        raise NotImplementedError(f"{type(self).__name__} must define normal(...)")

    def tangent(self, *q: Any) -> tuple[Any, ...]:
        """W_T: where the friction force enters, the factors of F_T in Eq. (1)."""
        return (1, 0, -1, 0, 0)[: len(q)]


@dataclass(frozen=True, repr=False)
class MovingLoad(Geometry):
    """The slider travels along a belt that may tilt by phi: the geometrical nonlinearity of Eqs. (1), (2).

    The penetration is y2 - (x1 - x2) phi - y1, and W_N = (0, 1, 0, -1, x1 - x2).  As in the paper the normal
    force acts vertically, so W_N is not the gradient of the gap, and the contact does work of its own
    at the rate -F_N phi (x1' - x2'), see `fl.energy_audit`.  Normal to the tilted belt it has the components
    F_N phi and -F_N phi along x1 and x2 as well: W_N = (phi, 1, -phi, -1, x1 - x2) is that gradient.

    Parameters
    ----------
    direction : {"vertical", "normal"}
        Of the normal force: vertical as in the paper's Eq. (1), or normal to the belt.
    """

    coordinates: ClassVar[tuple[str, ...]] = ("x1", "y1", "x2", "y2", "phi")
    direction: str = "vertical"

    def check(self) -> None:
        """The direction is one of two."""
        check_choice("direction", self.direction, DIRECTIONS, "'vertical' is that of Eq. (1)")

    def penetration(self, x1: Any, y1: Any, x2: Any, y2: Any, phi: Any) -> Any:
        """Penetration (m), the bracket of Eq. (2); lengths in m, `phi` in rad."""
        return y2 - (x1 - x2) * phi - y1

    def normal(self, x1: Any, y1: Any, x2: Any, y2: Any, phi: Any) -> tuple[Any, ...]:
        """W_N, the factors of F_N in Eq. (1); the last is a lever (m)."""
        along = {"vertical": 0, "normal": phi}[self.direction]
        return (along, 1, -along, -1, x1 - x2)


@dataclass(frozen=True, repr=False)
class FixedLoad(Geometry):
    """The belt does not rotate: Eqs. (1), (2) with phi = 0 and without its equation.

    The penetration is y2 - y1, and W_N = (0, 1, 0, -1).
    """

    coordinates: ClassVar[tuple[str, ...]] = ("x1", "y1", "x2", "y2")

    def penetration(self, x1: Any, y1: Any, x2: Any, y2: Any) -> Any:
        """Penetration (m)."""
        return y2 - y1

    def normal(self, x1: Any, y1: Any, x2: Any, y2: Any) -> tuple[Any, ...]:
        """W_N, the factors of F_N in Eq. (1)."""
        return (0, 1, 0, -1)
