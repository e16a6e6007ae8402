"""What the models of one mass in the plane, pressed on a belt, share."""

from __future__ import annotations

from typing import Any

from frictionlab.components import functions

from .mechanics import Friction, MechanicalModel, Mechanics


class PlanarSlider(MechanicalModel):
    """Base of the models of one mass, x along the belt and y into it, that F presses on a contact.

    A subclass has the parameters m, c, F and v, a `friction` law, and gives :meth:`springs` and
    :meth:`normal_force`.
    """

    m: Any
    c: Any
    F: Any
    v: Any
    friction: Any

    @property
    def coordinates(self) -> tuple[str, ...]:
        """x along the belt, y into it."""
        return ("x", "y")

    def springs(self, q: Any) -> Any:
        """Energy of the springs that hold the mass, J."""
        raise NotImplementedError(f"{type(self).__name__} must define springs(q)")

    def normal_force(self, gap: Any) -> Any:
        """F_N at a compression of the contact, N."""
        raise NotImplementedError(f"{type(self).__name__} must define normal_force(gap)")

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact; the energy of the contact is the work of F_N, which is a contact force."""
        return Mechanics(
            kinetic=self.m * (v.x**2 + v.y**2) / 2,
            potential=self.springs(q) - self.F * q.y,
            dissipation=self.c * (v.x**2 + v.y**2) / 2,
            contacts=(Friction(self.v - v.x, self.normal_force, self.friction, gap=q.y),),
        )


def inclined(k: Any, angle: Any, q: Any) -> Any:
    """Energy of a spring at an angle with the belt, J."""
    return k * (functions.cos(angle) * q.x + functions.sin(angle) * q.y) ** 2 / 2
