"""Lagrange's equations of a model's energies and loads: M q'' = r + sum of W F.

r comes from energies, dampers and loads, F are the forces of the contacts, W their directions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, wraps
from inspect import signature
from operator import getitem
from typing import TYPE_CHECKING, Any, NamedTuple

import sympy

from frictionlab.automaton import Reset
from frictionlab.automaton.modes_on_demand import Combination, ModeNames
from frictionlab.components.component import Component, StructureKey
from frictionlab.components.contact import Interface
from frictionlab.models.symbolic_laws import symbolic_copy, takes, wants_number
from frictionlab.models.symbols import dot, expand_products, gradient, symbol
from frictionlab.presentation import PHASE, TIME

from .common_directions import RUBBING, SLIP, CommonDirection, common_directions
from .contact_regimes import (
    APART,
    ContactRegime,
    impact_resets,
    in_contact,
    regimes_of_contact,
    regimes_of_state,
    stick_reset,
)
from .coupled_masses import CoupledMasses, coupled_masses
from .dynamic_laws import limits_of_states, values_of_contact
from .friction_in_plane import check_alone, names_in_plane, plane_regimes, plane_stop
from .meaning import check_linear, check_mechanics, mass_matrix
from .mechanics import AnyContact, Contact, Friction, Mechanics, Stop, mechanics_at

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

Row = tuple[Any, ...]
# Cofactors of more rows have too many terms: 24 in a determinant of 4.
MOST_ROWS_BY_COFACTORS = 3


def _inverse_by_cofactors(mass: Any) -> Any:
    """M^-1 = adj(M) / det(M), where no entry is simplified: sympy takes seconds over sines and cosines."""
    symbols = {entry: sympy.Symbol(f"M_{i}") for i, entry in enumerate(mass) if entry}
    bare = mass.applyfunc(lambda entry: symbols.get(entry, entry))
    return (bare.adjugate() / bare.det()).xreplace({one: entry for entry, one in symbols.items()})


def _remembered(method: Any) -> Any:
    """Cache the results of a method of one contact in its system."""

    @wraps(method)
    def remembering(self: LagrangeSystem, contact: AnyContact) -> Any:
        results = self.__dict__.setdefault(f"_{method.__name__}_of_contacts", {})
        if contact not in results:
            results[contact] = method(self, contact)
        return results[contact]

    return remembering


class Pair(NamedTuple):
    """Two coordinates, by their indices, between which a velocity q1' - q2' is held at `speed`."""

    first: int
    second: int
    speed: Any


@dataclass(frozen=True, eq=False)
class LagrangeSystem:
    """Lagrange's equations of a model: M q'' = loads - internal + sum of W F.

    Nothing is multiplied out: equal subexpressions (above all the penetration) stay equal, so that they are
    computed once.
    """

    mechanics: Mechanics
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    mass: Any
    internal: tuple[Any, ...]
    loads: tuple[Any, ...]
    further: tuple[Any, ...] = ()
    of_laws: tuple[tuple[Any, ...], ...] = ()
    time: tuple[Any, ...] = ()
    laws_of_expressions: tuple[Component, ...] = ()

    @cached_property
    def inverse(self) -> Any:
        """M^-1."""
        if self.coupled is not None:
            return sympy.Matrix(self.coupled.inverse) / self.coupled.scale
        if self.masses:
            return sympy.diag(*(1 / m for m in self.masses))
        turns = bool(self.mass.free_symbols & set(self.q)) and self.mass.rows <= MOST_ROWS_BY_COFACTORS
        return _inverse_by_cofactors(self.mass) if turns else self.mass.inv()

    @cached_property
    def coupled(self) -> CoupledMasses | None:
        """M^-1 in numbers, where M is not diagonal and is floats times one expression; else None.

        Exact masses, of integers and parameters, are left to sympy, so that terms cancel exactly.
        """
        coupled = None if self.masses else coupled_masses(self.mass)
        return coupled if self.mass.has(sympy.Float) else None

    @cached_property
    def masses(self) -> tuple[Any, ...]:
        """The diagonal of M; () where the kinetic energy couples coordinates."""
        return tuple(self.mass.diagonal()) if self.mass.is_diagonal() else ()

    @cached_property
    def regimes(self) -> tuple[tuple[ContactRegime, ...], ...]:
        """The regimes of each contact, in the order in which they are tried."""
        return tuple(
            plane_regimes(contact, self)
            if isinstance(contact, Friction) and contact.in_plane
            else regimes_of_contact(contact, self)
            for contact in self.mechanics.contacts
        )

    @cached_property
    def parts_of_states(self) -> dict[int, range]:
        """By contact the places in `parts` of its law's states, where these have regimes of their own: those
        of elastic-plastic laws with several states."""
        places, first = {}, len(self.regimes)
        for i, contact in enumerate(self.mechanics.contacts):
            limits = limits_of_states(contact) if isinstance(contact, Friction) else ()
            if len(limits) > 1:
                places[i] = range(first, first := first + len(limits))
        return places

    @cached_property
    def _one_way(self) -> frozenset[int]:
        """Contacts whose states cannot slip in both directions at once, as all have one rate, and limits that
        do not move."""
        contacts: Any = self.mechanics.contacts
        return frozenset(
            i
            for i in self.parts_of_states
            if len({*values_of_contact(contacts[i], self.of_laws[i], 1).rates}) == 1
            and not any(map(self.varies, limits_of_states(contacts[i])))
        )

    @cached_property
    def parts(self) -> tuple[tuple[ContactRegime, ...], ...]:
        """The regimes of all that a mode has one of: contacts, and then states of laws."""
        contacts: Any = self.mechanics.contacts
        of_states = (
            regimes_of_state(contacts[i], self, k)
            for i, places in self.parts_of_states.items()
            for k in range(len(places))
        )
        return (*self.regimes, *of_states)

    def chosen(self, combination: Combination) -> tuple[ContactRegime, ...]:
        """The regimes of the contacts in a combination, which has the index of one for each part.

        Contacts may hold a velocity on which v_r of another depends.  More of them than velocities cannot all
        hold, as only the sum of their forces would be known: then that of the other is at its limit.
        """
        if combination not in self._chosen:
            self._chosen[combination] = self._choose(combination)
        return self._chosen[combination]

    @cached_property
    def _chosen(self) -> dict[Combination, tuple[ContactRegime, ...]]:
        return {}

    def _choose(self, combination: Combination) -> tuple[ContactRegime, ...]:
        chosen = self._regimes_in(combination)
        held = [i for i in self._contacts_in_conflict if chosen[i].held]
        for i in self._contacts_in_conflict if held else ():
            resting = chosen[i].resting
            if resting is not None and self._depends(i, combination, held):
                chosen[i] = resting
        return tuple(chosen)

    def _regimes_in(self, combination: Combination) -> list[ContactRegime]:
        """The regimes of the contacts, each by itself."""
        chosen = [regimes[i] for regimes, i in zip(self.regimes, combination)]
        for i, parts in self.parts_of_states.items():
            if chosen[i].name not in APART:
                contact: Any = self.mechanics.contacts[i]
                chosen[i] = in_contact(contact, self, [self.parts[k][combination[k]] for k in parts])
        return chosen

    def _depends(self, i: int, combination: Combination, held: Sequence[int]) -> bool:
        """Whether v_r of contact `i` is zero where the velocities are that these contacts hold at zero."""
        contact = self.mechanics.contacts[i]
        velocities = [one.velocity for j in held for one in self.regimes[j][combination[j]].held]
        rows = [
            (*self.gradient(velocity, self.v), self.at_rest(velocity))
            for velocity in (contact.relative_velocity, *velocities)
        ]
        some = next(group for group in _coupled(rows) if rows[0] in group)
        some.remove(rows[0])
        return bool(some) and _rank((rows[0], *some)) == _rank(tuple(some))

    @cached_property
    def names(self) -> ModeNames:
        """Names of all modes, which are the combinations of regimes that :meth:`allows` accepts."""
        return ModeNames(tuple(tuple(one.name for one in each) for each in self.parts), self.allows)

    def allows(self, combination: Combination) -> bool:
        """Whether contacts of one direction agree, all else that is held at zero is independent, and states
        of laws are apart where their contacts are."""
        names: Sequence[str] = ()
        if not self._states_agree(combination):
            return False
        if self.directions:
            names = self.names_of_regimes(combination)
            if not all(direction.allows(names) for direction in self.directions):
                return False
        rows = [
            row
            for i in self._contacts_in_conflict
            if i < len(combination) and (not names or self.leader(i, names) == i)
            for row in self._held_rows[i][combination[i]]
        ]
        return len(rows) < 2 or all(_rank(tuple(some)) == len(some) for some in _coupled(rows))

    def _states_agree(self, combination: Combination) -> bool:
        """Whether states of laws are apart where their contacts are, and do not slip both ways at once."""
        for i, parts in self.parts_of_states.items():
            known = [self.parts[k][combination[k]].name for k in (i, *parts) if k < len(combination)]
            if len({one in APART for one in known}) > 1 or (i in self._one_way and {*SLIP} <= {*known}):
                return False
        return True

    def names_of_regimes(self, combination: Combination) -> tuple[str, ...]:
        """The name of each contact's regime, empty where the combination does not go so far."""
        return tuple(one.name for one in map(getitem, self.regimes, combination)) + ("",) * (
            len(self.regimes) - len(combination)
        )

    @cached_property
    def directions(self) -> tuple[CommonDirection, ...]:
        """Contacts that rub along one direction, in groups; those that share it with none left out."""
        sticking = [
            c if isinstance(c, Friction) and "stick" in c.modes and not (c.law.states or c.in_plane) else None
            for c in self.mechanics.contacts
        ]
        rows = [c and tuple(self.gradient(c.relative_velocity, self.v)) for c in sticking]
        speeds = [c and self.at_rest(c.relative_velocity) for c in sticking]
        return common_directions(rows, speeds, self.states)

    @cached_property
    def _direction_of(self) -> dict[int, CommonDirection]:
        return {i: direction for direction in self.directions for i in direction.contacts}

    def direction_of(self, i: int) -> CommonDirection | None:
        """The group of contacts that rub along the direction of contact `i`; None where it is alone."""
        return self._direction_of.get(i)

    def leader(self, i: int, names: Sequence[str]) -> int:
        """The contact that holds for contact `i`, and at which its events are looked for: mostly itself."""
        direction = self._direction_of.get(i)
        return direction.leader(i, names) if direction is not None and names[i] in RUBBING else i

    @cached_property
    def _contacts_in_conflict(self) -> tuple[int, ...]:
        """Indices of contacts whose held velocities share a coordinate with others', or contain none."""
        columns = [
            [{i for i, entry in enumerate(row) if entry != 0} for rows in regimes for row in rows]
            for regimes in self._held_rows
        ]
        used = [set().union(*some) for some in columns]
        counts = [sum(i in some for some in used) for i in range(len(self.v))]
        return tuple(
            i
            for i, some in enumerate(columns)
            if not all(some) or any(counts[j] > 1 for each in some for j in each)
        )

    @cached_property
    def _held_rows(self) -> tuple[tuple[tuple[Row, ...], ...], ...]:
        """Derivatives by the velocities of what each regime of each contact holds at zero."""
        return tuple(
            tuple(
                tuple(tuple(self.gradient(one.velocity, self.v)) for one in regime.held) for regime in regimes
            )
            for regimes in self.regimes
        )

    @property
    def rubbing(self) -> Friction:
        """The contact with friction of a system with a single contact."""
        (contact,) = self.mechanics.contacts
        assert isinstance(contact, Friction)
        return contact

    @cached_property
    def stiffness(self) -> Any:
        """K of a linear structure, (n, n)."""
        return sympy.Matrix([self.at_rest(row) for row in self.internal]).jacobian(self.q)

    @cached_property
    def dead_loads(self) -> tuple[Any, ...]:
        """Loads on a linear structure at zero coordinates, (n,)."""
        origin = dict.fromkeys(self.q, 0)
        rows = zip(self.loads, self.internal, strict=True)
        return tuple(load - self.at_rest(row).subs(origin) for load, row in rows)

    @property
    def phase(self) -> tuple[Any, ...]:
        """The phase of a periodic load as a state, where there is one."""
        return () if self.mechanics.frequency is None else (symbol(PHASE),)

    @property
    def clocks(self) -> tuple[Any, ...]:
        """The states that time moves: the phase of a periodic load, and the time itself where it is used."""
        return (*self.phase, *self.time)

    @property
    def other_rates(self) -> tuple[Any, ...]:
        """The rates of the clocks and of the further states."""
        phase = tuple(self.mechanics.frequency for _ in self.phase)
        time = tuple(sympy.S.One for _ in self.time)
        return (*phase, *time, *(self.mechanics.rates[str(one)] for one in self.further))

    @property
    def states(self) -> tuple[Any, ...]:
        """Coordinates, velocities, phase, time, further states, states of friction laws."""
        return (
            *self.q,
            *self.v,
            *self.clocks,
            *self.further,
            *(one for some in self.of_laws for one in some),
        )

    def stick_reset(self, contact: AnyContact) -> Reset:
        """The reset of the event at which a contact begins to stick."""
        if isinstance(contact, Friction) and contact.in_plane:
            return plane_stop(self, contact)
        return stick_reset(self, contact)

    def impact_resets(self, contact: AnyContact) -> tuple[Reset, Reset]:
        """The impact by the contact's law, and the one that closes a Zeno accumulation of impacts."""
        assert not isinstance(contact, Contact)
        return impact_resets(self, contact)

    def law_states(self, contact: AnyContact) -> tuple[Any, ...]:
        """The states of a contact's friction law."""
        return self.of_laws[self.mechanics.contacts.index(contact)]

    def flow(self, accelerations: Sequence[Any], of_laws: Sequence[Any] = ()) -> tuple[Any, ...]:
        """The rates of all states, by accelerations and by the rates of the friction laws' states."""
        return (*self.v, *accelerations, *self.other_rates, *of_laws)

    def rate(self, expression: Any) -> Any:
        """Time derivative of a function of all states but velocities and those of friction laws; of one of
        velocities too, the part of its time derivative that has no accelerations."""
        moving = (*self.q, *self.clocks, *self.further)
        return dot(self.gradient(expression, moving), (*self.v, *self.other_rates))

    @cached_property
    def accelerations_of_mode(self) -> tuple[Any, ...]:
        """Symbols in rates of friction laws, where a damper presses; a mode puts its accelerations there."""
        return tuple(sympy.Symbol(f"{one}'", real=True) for one in self.v)

    def rate_in_motion(self, expression: Any, accelerations: Sequence[Any]) -> Any:
        """Time derivative of a function of coordinates, velocities, clocks and further states."""
        return self.rate(expression) + dot(self.gradient(expression, self.v), accelerations)

    def explicit_rate(self, expression: Any) -> Any:
        """The part of a time derivative that is there with all coordinates and velocities at rest, of what
        does not depend on further states: that by the clocks."""
        return dot(self.gradient(expression, self.clocks), self.other_rates[: len(self.clocks)])

    def varies(self, expression: Any) -> bool:
        """Whether an expression depends on the state."""
        return bool(expression.free_symbols.intersection(self.states))

    def at_rest(self, expression: Any) -> Any:
        """The value at zero velocities; for a relative velocity it is the speed of the belt."""
        expression = sympy.sympify(expression, strict=True)
        there = expression.free_symbols
        return expression.subs({rate: 0 for rate in self.v if rate in there})

    def speed_at_origin(self, contact: Friction | Stop) -> Any:
        """The speed of the belt, v_r at rest, where coordinates, clocks and further states are zero."""
        origin = dict.fromkeys((*self.q, *self.clocks, *self.further), 0)
        return sympy.sympify(self.at_rest(contact.relative_velocity), strict=True).subs(origin)

    def sliding_sign(self, contact: Friction | Stop) -> Any:
        """The sign of slip in one direction, that of the belt's speed; at the origin where it varies."""
        return sympy.sign(self.speed_at_origin(contact))

    @_remembered
    def direction(self, contact: AnyContact) -> Any:
        """W (n, 1): the direction of a contact's friction force, or of the reaction of a stop; zero for a
        contact without friction.  In the plane (n, 2): one column for each component."""
        if isinstance(contact, Friction):
            columns = (sympy.Matrix(self.gradient(one, self.v)) for one in contact.velocities)
            return -sympy.ImmutableMatrix(sympy.Matrix.hstack(*columns))
        if isinstance(contact, Contact):
            return sympy.ImmutableMatrix.zeros(len(self.q), 1)
        return sympy.ImmutableMatrix(self.gradient(contact.distance, self.q))

    @_remembered
    def normal(self, contact: AnyContact) -> Any:
        """W_N (n, 1): the direction of the normal force of a contact that may be lost; zero for others.

        It is the gradient of the gap unless the contact gives another.
        """
        if isinstance(contact, Stop) or contact.penetration is None:
            return sympy.ImmutableMatrix.zeros(len(self.q), 1)
        if contact.normal is not None:
            return sympy.ImmutableMatrix(contact.normal)
        return -sympy.ImmutableMatrix(self.gradient(contact.penetration, self.q))

    def gradient(self, expression: Any, x: Sequence[Any]) -> list[Any]:
        """Derivatives of an expression by each of `x`."""
        return gradient(expression, x)

    def apply(self, direction: Any, force: Any, to: list[Any]) -> None:
        """Add a force along a direction (n, 1), or in a plane (n, 2), to the forces `to` (n,)."""
        for (i, k), w in direction.todok().items():
            to[i] += w * (force[k] if isinstance(force, tuple) else force)

    def accelerations(self, forces: Sequence[Any]) -> list[Any]:
        """M^-1 times forces (n,)."""
        if self.masses:
            return [1 / m * force for m, force in zip(self.masses, forces, strict=True)]
        if self.coupled is not None:
            return self.coupled.accelerations(forces, self.states)
        return list(self.inverse * sympy.Matrix(forces))

    def forces(self, contact: AnyContact, normal_force: Any) -> list[Any]:
        """Loads less the internal forces, plus those of a contact's normal force, for each coordinate."""
        rows = zip(self.loads, self.internal, self.normal(contact), strict=True)
        return [load - rest + w * normal_force for load, rest, w in rows]

    def pair(self, velocity: Any) -> Pair | None:
        """The two coordinates that move together where this velocity is zero; None where there are no two.

        M must be diagonal, and the velocity the difference of those of the coordinates, plus a constant.
        """
        rows = self.gradient(velocity, self.v)
        moving = {i: row for i, row in enumerate(rows) if row != 0}
        speed = self.at_rest(velocity)
        if not self.masses or sorted(moving.values(), key=str) != [-1, 1] or self.rate(speed) != 0:
            return None
        return Pair(rows.index(-1), rows.index(1), speed)


@lru_cache(maxsize=256)
def system_of(key: StructureKey) -> LagrangeSystem:
    """Lagrange's equations of a structure."""
    model = symbolic_copy(key)
    names = model.coordinates
    return system_at(model, *(tuple(symbol(name + prime) for name in names) for prime in ("", "'")))


def system_at(model: MechanicalModel, q: Sequence[Any], v: Sequence[Any]) -> LagrangeSystem:
    """Lagrange's equations of a symbolic copy of a model, in these symbols of coordinates and velocities."""
    names, further = model.coordinates, tuple(map(symbol, model.states))
    laws: list[Component] = []
    about, time = _stated(model, q, v, further, laws), time_of(model)
    time = tuple(one for one in time if isinstance(about, Mechanics) and about.depends_on(one))
    about = check_mechanics(about, model, q, v, laws)
    about = with_dampers(about, q, v, time)
    about = _in_regimes(about, model, (*q, *v, symbol(PHASE), *time, *further))
    about, momenta, mass = mass_matrix(about, model, v)
    loads = tuple(sympy.sympify(about.loads.get(name, 0), strict=True) for name in names)
    # In matrix form where the statics need K; the form determines the last bits of equilibria.
    linear = model.statics is not None
    if linear:
        check_linear(about, model, q, v)
    internal = _with_matrices(about, q, v) if linear else _internal(about, momenta, q, v, time)
    of_laws = tuple(tuple(map(symbol, some)) for some in about.law_states)
    check_alone(about, type(model).__name__, v)
    q, v = tuple(q), tuple(v)
    return LagrangeSystem(about, q, v, mass, internal, loads, further, of_laws, time, tuple(laws))


def time_of(model: MechanicalModel) -> tuple[Any, ...]:
    """The symbol of the time, unless the model gives the name to something else."""
    own = {*model.coordinates, *model.states, *model.structure_key.parameters}
    return () if TIME in own else (symbol(TIME),)


def _stated(
    model: MechanicalModel,
    q: Sequence[Any],
    v: Sequence[Any],
    further: Sequence[Any],
    laws: list[Component],
) -> Mechanics:
    """What `mechanics` returns; TypeError, with the cure, where it takes symbols for numbers."""
    try:
        return mechanics_at(model, q, v, symbol(PHASE), further, *time_of(model), laws=laws)
    except (TypeError, AttributeError) as error:
        names = "self, q, v, s" if model.states else "self, q, v"  # s: the further states
        if not takes(model.mechanics, (q, v, further) if model.states else (q, v)):
            raise TypeError(
                f"{type(model).__name__}.mechanics must take ({names}), got "
                f"{signature(type(model).mechanics)}: write def mechanics({names})"
            ) from error
        if not wants_number(error):
            raise
        raise TypeError(
            f"{type(model).__name__}.mechanics must be a formula of symbols, and fails with them ({error}): "
            "write fl.functions.cos and the like, none of numpy or math, and no if, min or max of "
            "coordinates; where a law changes write fl.functions.piecewise, minimum, maximum or interpolate; "
            "dry friction is a contact, fl.Friction"
        ) from error


class Regimes(NamedTuple):
    """The regimes of one contact, by their names, in place of an interface."""

    modes: tuple[str, ...]


def _in_regimes(about: Mechanics, model: MechanicalModel, states: Sequence[Any]) -> Mechanics:
    """The contacts, each with the names of its regimes as interface."""
    contacts = (replace(c, interface=_regimes(c, model.interface, states)) for c in about.contacts)
    return replace(about, contacts=tuple(contacts))


def _regimes(contact: AnyContact, allowed: Interface, states: Sequence[Any]) -> Any:
    return Regimes(_names(contact, allowed, states))


def _names(contact: AnyContact, allowed: Interface, states: Sequence[Any]) -> tuple[str, ...]:
    """Names of a contact's regimes: those of its own interface, without what the model's leaves out."""
    own = contact.interface or allowed
    names = own.modes
    if not allowed.sticks and own.sticks:
        names = dict.fromkeys("slip" if name in RUBBING else name for name in names)
    if isinstance(contact, Friction) and contact.law.states:
        names = names_with_states(contact, names)
    if contact.in_plane:
        names = names_in_plane(tuple(names))
    if isinstance(contact, Contact):
        names = tuple(dict.fromkeys("separation" if name == "separation" else "contact" for name in names))
    names = tuple(name for name in names if name != "separation" or allowed.separates)
    if isinstance(contact, Stop) or "separation" not in names:
        return names
    if contact.penetration is None:
        varies = sympy.sympify(contact.pressing, strict=True).free_symbols.intersection(states)
        return names if varies else tuple(name for name in names if name != "separation")
    return names if is_law(contact, states) else (*names, "relaxation")


def names_with_states(contact: Friction, names: Iterable[str]) -> tuple[str, ...]:
    """The regimes with a dynamic law, in which v_r has either sign also where slip keeps its direction.

    Such a law holds for both signs and turns its force by itself, so that it slips both ways; v_r passes
    through zero without stick.  An elastic-plastic law also needs its "stick", from which it comes to slip;
    with several states these have such regimes, and the contact is just closed.
    """
    elastic = limits_of_states(contact)
    if len(elastic) > 1:
        return tuple(dict.fromkeys("contact" if one in (*RUBBING, "slip") else one for one in names))
    found = dict.fromkeys(one for name in names for one in (RUBBING if name == "slip" else (name,)))
    return tuple(name for name in found if elastic or name != "stick")


def is_law(contact: Friction | Contact, states: Sequence[Any]) -> bool:
    """Whether F_N is a function of the penetration and of parameters only."""
    if callable(contact.normal_force):
        law = sympy.sympify(contact.normal_force(sympy.Dummy(real=True)), strict=True)
        if not law.free_symbols.intersection(states):
            return True
    force, depth = gradient(contact.pressing, states), gradient(contact.penetration, states)
    pivot = next((i for i, slope in enumerate(depth) if slope != 0), 0)
    return all(
        expand_products(f * depth[pivot] - force[pivot] * d) == 0 for f, d in zip(force, depth, strict=True)
    )


def with_dampers(about: Mechanics, q: Sequence[Any], v: Sequence[Any], time: Sequence[Any]) -> Mechanics:
    """The contacts, with the force of each one's damper in its normal force."""

    def damped(contact: AnyContact) -> AnyContact:
        if isinstance(contact, Stop) or (not callable(contact.damper) and contact.damper == 0):
            return contact
        rate = sum(gradient(contact.penetration, time), _rate(contact.penetration, about, q, v))
        return replace(contact, normal_force=contact.pressing + contact.damping * rate, damper=0)

    return replace(about, contacts=tuple(map(damped, about.contacts)))


def _internal(
    about: Mechanics, momenta: Sequence[Any], q: Sequence[Any], v: Sequence[Any], time: Sequence[Any]
) -> Any:
    """Forces of energies and dampers, for each coordinate: d/dt (dT/dv) less M v', less the slopes of T."""
    turning = [_rate(momentum, about, q, v) for momentum in momenta]
    for one in time:
        turning = [moved + gradient(momentum, [one])[0] for moved, momentum in zip(turning, momenta)]
    slopes = gradient(about.stored - about.kinetic, q)
    damping = gradient(about.dissipation, v)
    return tuple(map(sympy.factor_terms, map(sum, zip(turning, slopes, damping, strict=True))))


def _rate(expression: Any, about: Mechanics, q: Sequence[Any], v: Sequence[Any]) -> Any:
    """Time derivative of a momentum at constant velocities: by the coordinates, and by the phase."""
    moving, rates = (*q,), (*v,)
    if about.frequency is not None:
        moving, rates = (*q, symbol(PHASE)), (*v, about.frequency)
    return dot(gradient(expression, moving), rates)


def _with_matrices(about: Mechanics, q: Sequence[Any], v: Sequence[Any]) -> Any:
    """C q' + K q + dV/dq at q = 0, of quadratic energies."""
    slopes = gradient(about.stored, q)
    damping = _jacobian(gradient(about.dissipation, v), v)
    stiffness = _jacobian(slopes, q)
    constant = [slope.subs(dict.fromkeys(q, 0)) for slope in slopes]
    return tuple(dot(c, v) + dot(k, q) + f for c, k, f in zip(damping, stiffness, constant, strict=True))


def _jacobian(gradient: Sequence[Any], x: Sequence[Any]) -> tuple[tuple[Any, ...], ...]:
    # Second derivatives of one function are symmetric, so half of them suffice.
    upper = {(i, j): sympy.diff(gradient[i], x[j]) for j in range(len(x)) for i in range(j + 1)}
    return tuple(tuple(upper[min(i, j), max(i, j)] for j in range(len(x))) for i in range(len(x)))


def _coupled(rows: Sequence[Row]) -> list[list[Row]]:
    """The rows in groups: rows of different groups have no column in common that is not zero."""
    groups: list[tuple[set[int], list[Row]]] = []
    for row in rows:
        columns, some = {i for i, entry in enumerate(row) if entry != 0}, [row]
        separate = []
        for others, group in groups:
            if columns & others:
                columns, some = columns | others, [*group, *some]
            else:
                separate.append((others, group))
        groups = [*separate, (columns, some)]
    return [group for _, group in groups]


@lru_cache(maxsize=256)  # many combinations have the same rows
def _rank(rows: tuple[Row, ...]) -> int:
    return 1 if len(rows) == 1 and any(rows[0]) else sympy.Matrix(rows).rank()
