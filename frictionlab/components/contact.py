"""Contact laws, interfaces and geometries.

A contact law gives the normal force as a function of the penetration (linear, cubic, Hertz, polynomial).  An
interface says which regimes of contact a model has, as a tuple of mode names.  A geometry gives the
coordinates, the penetration of slider and belt, and where the contact forces act.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from frictionlab.components.component import Component, parameter
from frictionlab.validation import check_choice

DIRECTIONS = ("vertical", "normal")


@dataclass(frozen=True, repr=False)
class Interface(Component):
    """Base of the interfaces: `modes` are tried in this order, after those that an event names first."""

    modes: ClassVar[tuple[str, ...]]

    @property
    def sticks(self) -> bool:
        """Whether friction may reverse, so that it needs no fixed direction."""
        return "slip" not in self.modes

    @property
    def separates(self) -> bool:
        """Whether contacts may be lost."""
        return "separation" in self.modes


@dataclass(frozen=True, repr=False)
class StickSlipSeparation(Interface):
    """All the non-smooth behaviours of the paper: Eqs. (3), (4), (5), (8), (9)."""

    modes: ClassVar[tuple[str, ...]] = ("stick", "slip+", "slip-", "separation")


@dataclass(frozen=True, repr=False)
class StickSlip(Interface):
    """Stick and slip with bilateral contact: Eqs. (2), (3) hold as printed for F_N < 0 too.

    Friction then feeds energy in, as in the paper; a guide that rubs on its other side needs a contact there.
    """

    modes: ClassVar[tuple[str, ...]] = ("stick", "slip+", "slip-")


@dataclass(frozen=True, repr=False)
class SlidingSeparation(Interface):
    """Unilateral contact without stick: the friction force keeps the sign of the belt's speed.

    That of a dynamic law, whose states give it its sign, is as with :class:`StickSlipSeparation`.
    """

    modes: ClassVar[tuple[str, ...]] = ("slip", "separation")


@dataclass(frozen=True, repr=False)
class SlidingOnly(Interface):
    """One smooth regime: bilateral contact, the friction force keeps the sign of the belt's speed.

    That of a dynamic law, whose states give it its sign, is as with :class:`StickSlip`.
    """

    modes: ClassVar[tuple[str, ...]] = ("slip",)


def _linear_stiffness() -> Any:
    return parameter(
        5e3,
        unit="N/m",
        symbol="k_2",
        meaning="linear contact stiffness",
        minimum=0.0,
        range=(1e3, 1e5),
        log=True,
    )


@dataclass(frozen=True, repr=False)
class ContactLaw(Component):
    """Base of the contact laws: a subclass gives :meth:`force`."""

    def force(self, penetration: Any) -> Any:
        """Normal force (N) at a penetration (m), positive where the bodies press on each other."""
        raise NotImplementedError(f"{type(self).__name__} must define force(penetration)")


@dataclass(frozen=True, repr=False)
class CubicContact(ContactLaw):
    """Linear and cubic spring, Eq. (2): F_N = k2 delta + k_nl delta^3, with the penetration delta.

    Parameters
    ----------
    k2 : float
        Linear stiffness, N/m, at least 0.
    k_nl : float
        Cubic stiffness, N/m^3, at least 0.
    """

    k2: float = _linear_stiffness()
    k_nl: float = parameter(
        1e4,
        unit="N/m^3",
        symbol=r"k_{\mathrm{nl}}",
        meaning="cubic contact stiffness",
        minimum=0.0,
        range=(1e2, 1e8),
        log=True,
    )

    def force(self, penetration: Any) -> Any:
        """Normal force (N), Eq. (2)."""
        return self.k2 * penetration + self.k_nl * penetration**3


@dataclass(frozen=True, repr=False)
class LinearContact(ContactLaw):
    """Linear spring, Eq. (2) without its cubic term: F_N = k2 delta, with the penetration delta.

    Parameters
    ----------
    k2 : float
        Linear stiffness, N/m, at least 0.
    """

    k2: float = _linear_stiffness()

    def force(self, penetration: Any) -> Any:
        """Normal force (N)."""
        return self.k2 * penetration


@dataclass(frozen=True, repr=False)
class HertzContact(ContactLaw):
    """Two elastic bodies that touch in a point: F_N = k_h delta^(3/2), with the penetration delta.

    The bodies must be able to separate, as the law has no value for a negative penetration.

    Parameters
    ----------
    k_h : float
        Stiffness, N/m^1.5, at least 0; for two spheres 4/3 sqrt(R) E*, with the effective radius and modulus.

    References
    ----------
    K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, chapter 4.
    """

    k_h: float = parameter(
        2.5e4,
        unit="N/m^1.5",
        symbol=r"k_{\mathrm{H}}",
        meaning="Hertz contact stiffness",
        minimum=0.0,
        range=(1e3, 1e7),
        log=True,
    )

    def force(self, penetration: Any) -> Any:
        """Normal force (N)."""
        return self.k_h * penetration**1.5


def _polynomial_coefficient(n: int, default: float = 0.0) -> Any:
    return parameter(
        default,
        unit="N/m" if n == 1 else f"N/m^{n}",
        symbol=f"a_{n}",
        meaning=f"contact stiffness of order {n}",
        range=(0.0, 10.0 ** (n + 3)),
    )


@dataclass(frozen=True, repr=False)
class PolynomialContact(ContactLaw):
    """Spring with a polynomial of degree five: F_N = a1 delta + a2 delta^2 + ... + a5 delta^5.

    Parameters
    ----------
    a1, a2, a3, a4, a5 : float
        Coefficients, N/m^n.
    """

    a1: float = _polynomial_coefficient(1, 5e3)
    a2: float = _polynomial_coefficient(2)
    a3: float = _polynomial_coefficient(3)
    a4: float = _polynomial_coefficient(4)
    a5: float = _polynomial_coefficient(5)

    def force(self, penetration: Any) -> Any:
        """Normal force (N), by Horner's rule."""
        total = 0
        for a in (self.a5, self.a4, self.a3, self.a2, self.a1):
            total = (total + a) * penetration
        return total


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
    force acts vertically.  So W_N is not the gradient of the gap, and the contact does work beyond that of
    its spring, at the rate -F_N phi (x1' - x2'), see `fl.energy_audit`.  With ``direction="normal"`` the
    force acts normal to the tilted belt: it also has the components F_N phi and -F_N phi along x1 and x2, and
    W_N = (phi, 1, -phi, -1, x1 - x2) is the gradient of the gap.

    Parameters
    ----------
    direction : {"vertical", "normal"}
        Direction of the normal force: vertical as in the paper's Eq. (1), or normal to the belt.
    """

    coordinates: ClassVar[tuple[str, ...]] = ("x1", "y1", "x2", "y2", "phi")
    direction: str = "vertical"

    def check(self) -> None:
        """Refuse any other `direction`."""
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
    """The belt does not rotate: Eqs. (1), (2) with phi = 0 and without the equation of phi.

    The penetration is y2 - y1, and W_N = (0, 1, 0, -1).
    """

    coordinates: ClassVar[tuple[str, ...]] = ("x1", "y1", "x2", "y2")

    def penetration(self, x1: Any, y1: Any, x2: Any, y2: Any) -> Any:
        """Penetration (m)."""
        return y2 - y1

    def normal(self, x1: Any, y1: Any, x2: Any, y2: Any) -> tuple[Any, ...]:
        """W_N, the factors of F_N in Eq. (1)."""
        return (0, 1, 0, -1)
