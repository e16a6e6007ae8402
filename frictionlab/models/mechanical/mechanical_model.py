"""`MechanicalModel`, the base of models that state energies and contacts; modes, resets and equations follow.

Also the bases that several models share: one mass on a spring, and one mass in the plane that is pressed on a
belt.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from frictionlab.automaton import HybridAutomaton
from frictionlab.components import functions
from frictionlab.components.contact import Interface, StickSlipSeparation
from frictionlab.models.composition import Nonlinearity, nonlinearities_of
from frictionlab.models.model import Model, model
from frictionlab.presentation import PHASE, TIME
from frictionlab.validation import abbreviate, check_names_among

from .contact_numbers import check_contacts, check_sliding, numbers_of_contacts
from .mechanics import Friction, Mechanics

if TYPE_CHECKING:
    from .equations_of_motion import LagrangeSystem


@model
class MechanicalModel(Model):
    """Base of the models that state their energies and contacts; modes, resets and equations follow.

    Besides its other components a model has an `interface`: the regimes of its contacts, by default all.
    `states` names further states, such as a current or a temperature, if it has any, and `cyclic` the
    coordinates that may turn for ever, such as a shaft's angle.

    Pictures and texts take a coordinate for an angle in rad if its name is phi, theta, psi, alpha, beta or
    gamma, also with an index such as phi1 or phi_M, and otherwise for a length in m.

    Examples
    --------
    A motor without friction, whose current builds up as that of a coil:

    >>> import frictionlab as fl
    >>> @fl.model
    ... class Motor(fl.MechanicalModel):
    ...     U: float = 12.0
    ...     K: float = 0.1
    ...     coordinates = ("theta",)
    ...     states = ("i",)
    ...
    ...     def mechanics(self, q, v, s):
    ...         loads = {"theta": self.K * s.i - 0.01 * v.theta}
    ...         rates = {"i": (self.U - 2.0 * s.i - self.K * v.theta) / 0.05}
    ...         return fl.Mechanics(0.02 * v.theta**2 / 2, loads=loads, rates=rates)
    >>> run = fl.simulate(Motor(), 200.0)  # to K U/(2 c + K^2)
    >>> round(float(run["theta'"][-1]), 9)
    40.0
    """

    states: ClassVar[tuple[str, ...]] = ()
    cyclic: ClassVar[tuple[str, ...]] = ()
    interface: Interface = StickSlipSeparation()

    @cached_property
    def nonlinearities(self) -> Mapping[str, Nonlinearity]:
        """The nonlinearities of the components; "nonsmooth" only if there are contacts, whose belts move."""
        nonlinearities, contacts = nonlinearities_of(self), numbers_of_contacts(self)
        if not contacts or any(one is not None and one.speed == 0 for one in contacts):
            nonlinearities.pop("nonsmooth", None)
        return MappingProxyType(nonlinearities)

    def without(self, *names: str) -> Self:
        """The model without some of its :attr:`nonlinearities`.

        Without "nonsmooth" contacts slide in the direction of their belts; those with dynamic friction laws
        keep both directions, as such a law has a force for each.

        Raises
        ------
        ValueError
            For any other name, where nothing can take a law's place, and where a belt is at rest.
        """
        if any(isinstance(name, str) and name == "nonsmooth" for name in names):
            check_sliding(self)
        return super().without(*names)

    def system(self) -> LagrangeSystem:
        """Lagrange's equations of its structure, in symbols."""
        from .equations_of_motion import system_of

        return system_of(self.structure_key)

    if TYPE_CHECKING:  # a model with further states has mechanics(q, v, s)
        mechanics: Any
    else:

        def mechanics(self, q: Any, v: Any) -> Mechanics:
            """Energies, loads and contacts, at coordinates ``q.<name>`` and velocities ``v.<name>``.

            A model with further states has ``mechanics(self, q, v, s)``, in which they are ``s.<name>``.
            """
            raise NotImplementedError(f"{type(self).__name__} must define mechanics(q, v)")

    def check(self) -> None:
        """Raise ValueError if names of further states are none, or taken, or a cyclic coordinate is none."""
        super().check()
        check_names_among("cyclic", self.cyclic, self.coordinates)
        for name in self.states:
            taken = {*self.coordinates, *(f"{q}'" for q in self.coordinates), *self.parameters, PHASE, TIME}
            if not isinstance(name, str) or name in taken or self.states.count(name) > 1:
                raise ValueError(
                    f"states of {type(self).__name__} must be names that no coordinate and no parameter has, "
                    f"got {abbreviate(name)}: rename it"
                )

    def _check_mechanics(self) -> None:
        # They need numpy, which a command's help does without.
        from .borders_of_pieces import check_borders
        from .limits import check_dampers
        from .masses import check_masses

        check_masses(self)
        check_dampers(self)
        check_contacts(self)
        check_borders(self)

    def derive(self) -> HybridAutomaton:
        """The automaton, derived by Lagrange's equations."""
        from .modes import derive_automaton

        return derive_automaton(self)

    def equations(self, mode: str) -> Any:
        """The equations of a mode as sympy equations, derived from the energies; LaTeX in a notebook.

        For a single contact "slip" gives both directions in one, and "impact" the impact on a stop or of a
        re-contact.

        Raises
        ------
        ValueError
            If the model has no such mode.
        """
        from frictionlab.models.lagrange_equations import lagrange_equations

        return lagrange_equations(self, mode)


class SingleMass(MechanicalModel):
    """Base of the models of one mass on a spring."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacement x, from where the spring is slack."""
        return ("x",)


class PlanarSlider(MechanicalModel):
    """Base of the models of one mass in the plane that a preload F presses on a belt.

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

    def normal_force(self, penetration: Any) -> Any:
        """F_N (N) at a penetration (m)."""
        raise NotImplementedError(f"{type(self).__name__} must define normal_force(penetration)")

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact, whose energy is not in the potential: F_N is a contact force."""
        return Mechanics(
            kinetic=self.m * (v.x**2 + v.y**2) / 2,
            potential=self.springs(q) - self.F * q.y,
            dissipation=self.c * (v.x**2 + v.y**2) / 2,
            contacts=(Friction(self.v - v.x, self.normal_force, self.friction, penetration=q.y),),
        )


def inclined_spring_energy(k: Any, angle: Any, q: Any) -> Any:
    """Energy of a spring at an angle with the belt, J."""
    return k * (functions.cos(angle) * q.x + functions.sin(angle) * q.y) ** 2 / 2
