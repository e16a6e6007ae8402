"""What a textbook model is made of: energies, loads and contacts, in arithmetic that needs no sympy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.impact import ImpactLaw

from .model import Model


@dataclass(frozen=True, eq=False)
class Friction:
    """A contact with dry friction; its modes are "stick", "slip+", "slip-" and, with a gap, "separation".

    The friction force F_T acts along the relative velocity v_r: F_T dv_r is minus its power on the bodies.

    Parameters
    ----------
    relative_velocity : Expr
        v_r, linear in the velocities, m/s.
    normal_force : Expr
        F_N, N.
    law : FrictionLaw
    gap : Expr or None
        Compression of the contact, m, where the bodies may separate: F_N vanishes with it and acts along
        minus its gradient, and there is no force while it is negative.  None for a contact that is never
        lost, under a normal force that does no work.
    """

    relative_velocity: Any
    normal_force: Any
    law: FrictionLaw
    gap: Any = None


@dataclass(frozen=True, eq=False)
class Stop:
    """A rigid stop; its modes are "flight" and "contact".

    Parameters
    ----------
    distance : Expr
        Distance from the stop, m, at least 0.
    law : ImpactLaw
        What happens where it comes to 0.
    """

    distance: Any
    law: ImpactLaw


@dataclass(frozen=True, eq=False)
class Mechanics:
    """Energies, loads and contacts.

    Parameters
    ----------
    kinetic, potential : Expr
        Energies T(q, v) and V(q), J.
    dissipation : Expr
        Rayleigh's dissipation function D(v), W: half the power that the dampers take.
    contacts : tuple of Friction or Stop
    loads : mapping of str to Expr
        Forces (N) along coordinates that come from no energy, such as ``F * cos(q.phase)``.
    frequency : Expr or None
        Angular frequency (rad/s) of what depends on time: the rate of the state ``q.phase``, which goes
        from 0 to 2 pi and begins anew.  None where nothing does.
    """

    kinetic: Any
    potential: Any = 0
    dissipation: Any = 0
    contacts: tuple[Friction | Stop, ...] = ()
    loads: Mapping[str, Any] = field(default_factory=dict)
    frequency: Any = None


@dataclass(frozen=True, init=False, repr=False)
class MechanicalModel(Model):
    """Base of the models that say what they are made of; modes, resets and equations follow from it."""

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Energies, loads and contacts, at coordinates ``q.<name>`` and velocities ``v.<name>``."""
        raise NotImplementedError(f"{type(self).__name__} must define mechanics(q, v)")

    def derive(self) -> HybridAutomaton:
        """By Lagrange's equations."""
        from .lagrange import derived

        return derived(self)

    def equations(self, mode: str) -> Any:
        """The equations of a mode as sympy equations, derived from the energies; LaTeX in a notebook.

        "slip" gives both directions of a single contact in one; "impact" what happens at a stop.

        Raises
        ------
        ValueError
            If the model has no such mode.
        """
        from .lagrange_equations import equations

        return equations(self, mode)


class SingleMass(MechanicalModel):
    """Base of the models of one mass on a spring."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacement x, from where the spring is slack."""
        return ("x",)
