"""`MechanicalModel`, the base of models that state energies and contacts; modes, resets and equations follow.

Also the base that several models share: one mass in the plane that is pressed on a belt.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from frictionlab.automaton import HybridAutomaton
from frictionlab.components import functions
from frictionlab.components.contact import Interface, StickSlipSeparation
from frictionlab.models.composition import Nonlinearity, nonlinearities_of, structural_fields
from frictionlab.models.model import Model, model
from frictionlab.presentation import PHASE, TIME
from frictionlab.validation import (
    abbreviate,
    check_names_among,
    check_number,
    check_text,
)

from .contact_numbers import check_contacts, check_sliding, numbers_of_contacts, turning_roles
from .mechanics import Friction, Mechanics

if TYPE_CHECKING:
    from .equations_of_motion import LagrangeSystem
    from .law_states_at_start import StatesOfLaws


@model
class MechanicalModel(Model):
    """Base of the models that state their energies and contacts; modes, resets and equations follow.

    Besides its other components a model has an `interface`: the regimes of its contacts, by default all.
    `states` names further states, such as a current or a temperature, if it has any, and `cyclic` the
    coordinates that may turn for ever, such as a shaft's angle.

    Pictures and texts take a coordinate for an angle in rad if its name is phi, theta, psi, alpha, beta or
    gamma, also with an index such as phi1 or phi_M, and otherwise for a length in m.  A contact with the
    relative velocity ``Omega - v.phi`` has a moment; ``Omega - 1.0 * v.phi`` has a lever of 1 m, and a force.

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

    @property
    def turning_roles(self) -> Mapping[str, bool]:
        """Roles of the laws of contacts whose bodies turn, and whether they serve no others."""
        outputs = self.rotational_outputs
        return turning_roles(self.structure_key, outputs) if outputs else {}

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

    def outputs_of_events(self, events: Any, states: Any) -> Mapping[str, Any]:
        """As in the base class: impulses, what M (v+ - v-) = sum of W p gives at each event."""
        from .impulses import impulses_by_name

        return impulses_by_name(self, events, states)

    def states_of_laws(self) -> StatesOfLaws:
        """What is known of states of friction laws where a run begins."""
        from .law_states_at_start import states_of_laws

        return states_of_laws(self.structure_key)

    def system(self) -> LagrangeSystem:
        """Lagrange's equations of its structure, in symbols."""
        from .equations_of_motion import system_of

        return system_of(self.structure_key)

    if TYPE_CHECKING:  # a model with further states has mechanics(q, v, s)
        mechanics: Any
    else:

        def mechanics(self, q: Any, v: Any) -> Mechanics:
            """Energies, loads and contacts, at coordinates ``q.<name>`` and velocities ``v.<name>``.

            Both are tuples, too, in the order of the coordinates: ``sum(u**2 for u in v)``.
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
        from .law_coefficients import check_law_coefficients
        from .limits import check_dampers
        from .masses import check_masses
        from .period_of_phase import check_period

        check_masses(self)
        check_period(self)
        check_dampers(self)
        check_law_coefficients(self)
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


def numbered(*letters: str, count: str, least: int = 1, most: int = 100) -> Any:
    """Coordinates with numbers, such as x1, x2, ..., as many as a field of the model says.

    Parameters
    ----------
    *letters : str
        Names without their numbers; "u", "w" is for u1, u2, ..., w1, w2, ...
    count : str
        Name of the field, which is annotated as an int.
    least, most : int
        What the field may be, from 1 on.

    Returns
    -------
    property
        For `coordinates` of a class.

    Raises
    ------
    ValueError
        If a name is no text, or a limit no integer; of a model, if `count` is no such field, or its value is
        none of these.

    Examples
    --------
    >>> import frictionlab as fl
    >>> @fl.model
    ... class Chain(fl.MechanicalModel):
    ...     k: float = 1.0
    ...     masses: int = 3
    ...     coordinates = fl.numbered("x", count="masses")
    ...
    ...     def mechanics(self, q, v):
    ...         springs = sum((b - a) ** 2 for a, b in zip((0, *q), (*q, 0)))
    ...         return fl.Mechanics(sum(u**2 for u in v) / 2, self.k * springs / 2)
    >>> Chain(masses=2).coordinates
    ('x1', 'x2')
    """

    cure = 'write coordinates = fl.numbered("x", count="masses")'
    for name, given in (*(("letters", letter) for letter in letters), ("count", count)):
        check_text(name, given, cure)
    check_number("most", most, integer=True, least=check_number("least", least, integer=True, least=1))

    def coordinates(model: Any) -> tuple[str, ...]:
        if count not in structural_fields(type(model)):
            raise ValueError(
                f"count must name an integer of the model, got {count!r}: write {count}: int = 3"
            )
        number = check_number(count, getattr(model, count), integer=True, least=least, most=most)
        return tuple(f"{letter}{i + 1}" for letter in letters for i in range(number))

    return property(coordinates)


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

    coordinates = ("x", "y")  # along the belt, and into it

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
