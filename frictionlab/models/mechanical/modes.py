"""A model's energies, loads and contacts as a hybrid automaton, by Lagrange's equations.

Where contacts keep velocities at zero, as in stick, their forces follow from these constraints, for all
contacts at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import sympy

from frictionlab.automaton import Event, HybridAutomaton, Mode
from frictionlab.automaton.mode import Combination, ModesOnDemand, Regime
from frictionlab.models.serialisation import Structure, structure_of_component, structure_to_data
from frictionlab.models.symbols import automaton_of_structure, expand_products

from .contact_regimes import (
    CHATTER_TIME,
    ContactRegime,
    RegimeEnd,
    chatter_mode,
    impact_resets,
    period_events,
    stick_reset,
)
from .coupled_masses import HeldVelocities, held_velocities
from .equations_of_motion import LagrangeSystem, Pair, lagrange_system
from .mechanics import Friction, Stop

_expand = lru_cache(maxsize=4096)(expand_products)  # most are the same in many modes


def derive_automaton(model: Any) -> HybridAutomaton:
    """States and modes of a symbolic copy of a model, one mode for each combination of regimes.

    Several contacts have many combinations, of which a run visits few; then each mode is derived when it is
    first used.
    """
    found, numbers = lagrange_system(model), {}
    if len(found.mechanics.contacts) > 1:
        key = structure_of_component(model)
        modes: Any = ModesOnDemand(
            tuple(tuple(map(_conditions, regimes)) for regimes in found.regimes),
            lambda combination: mode_of(found, combination),
            found.allows,
            (modes_of_structure, (key,)),
            lambda: structure_to_data(key),
        )
    else:
        modes = tuple(mode_of(found, combination) for combination in found.names.combinations())
        limit = chatter_mode(found)
        if limit is not None:
            modes, numbers = (*modes, limit), {CHATTER_TIME: 0.0}
    return HybridAutomaton(found.states, modes, numbers, len(found.q))


def modes_of_structure(key: Structure) -> Any:
    """The modes of a structure, the same object throughout a process."""
    return automaton_of_structure(key).modes


def _conditions(regime: ContactRegime) -> Regime:
    """A regime's conditions that are known without solving for forces: v_r = 0 in stick, its sign in slip."""
    if regime.force is None:
        needs = [sign * c for c in regime.constraints for sign in (1, -1)]
    else:
        needs = [end.function for end in regime.ends(regime.force, None)]
    return Regime(regime.name, tuple(needs), regime.held is not None)


class ContactForces(NamedTuple):
    """Accelerations; the force of each contact; and force and limit of each that holds, by its index.

    A contact that holds for others of its direction has the sum of their forces and limits there.  Both are
    multiplied by a compliance where this depends on the state: where it is zero the force is infinite.
    """

    accelerations: list[Any]
    forces: list[Any]
    holding: dict[int, tuple[Any, Any]]


@dataclass(frozen=True, eq=False)
class HoldingForce:
    """A force that holds a velocity; where its compliance depends on the state this, and their product."""

    force: Any
    compliance: Any = sympy.S.One
    product: Any = None


def solve_contact_forces(found: LagrangeSystem, chosen: Sequence[ContactRegime]) -> ContactForces:
    """Accelerations and contact forces where each contact is in its regime of `chosen`."""
    names = [regime.name for regime in chosen]
    held = [i for i, one in enumerate(chosen) if one.force is None and found.leader(i, names) == i]
    accelerations, forces, holding = _hold(found, chosen, held)
    with_limits = {}
    for i, one in holding.items():
        direction, limit = found.direction_of(i), chosen[i].limit
        if direction is not None and limit is not None:
            limits = {j: chosen[j].limit for j in direction.contacts if names[j] == "stick"}
            shares, limit = direction.shares(i, one.force, limits)
            for j, share in shares.items():
                forces[j] = share
        with_limits[i] = one.force, limit
        if one.product is not None:
            with_limits[i] = one.product, None if limit is None else one.compliance * limit
    return ContactForces(accelerations, forces, with_limits)


Solution = tuple[list[Any], list[Any], dict[int, HoldingForce]]


def _hold(found: LagrangeSystem, chosen: Sequence[ContactRegime], held: Sequence[int]) -> Solution:
    """Accelerations, the force of each contact, and again that of each of `held`, which hold."""
    contacts, forces = found.mechanics.contacts, [regime.force for regime in chosen]
    free = [load - rest for load, rest in zip(found.loads, found.internal, strict=True)]
    for contact, regime in zip(contacts, chosen, strict=True):
        found.apply(found.direction(contact), 0 if regime.force is None else regime.force, free)
        if regime.pressing != 0:
            found.apply(found.normal(contact), regime.pressing, free)
    if not held:
        return found.accelerations(free), forces, {}
    pair = found.pair(chosen[held[0]].held) if len(held) == 1 else None
    if pair is not None:
        accelerations, force = _as_one_body(found, pair, free)
        holding = [HoldingForce(force)]
    elif (velocities := _held_in_numbers(found, chosen, held)) is not None:
        accelerations, known = velocities.solve(free, found.states)
        holding = [HoldingForce(force) for force in known]
    else:
        accelerations, holding = _held_by_forces(found, chosen, held, sympy.Matrix(free))
    for i, one in zip(held, holding, strict=True):
        forces[i] = one.force
    return accelerations, forces, dict(zip(held, holding, strict=True))


def _held_in_numbers(
    found: LagrangeSystem, chosen: Sequence[ContactRegime], held: Sequence[int]
) -> HeldVelocities | None:
    """The velocities held at zero, where M^-1 is in numbers; None where only sympy can find the forces."""
    if found.coupled is None:
        return None
    rows = [found.gradient(chosen[i].held, found.v) for i in held]
    along = [list(found.direction(found.mechanics.contacts[i])) for i in held]
    return held_velocities(found.coupled, rows, along, [found.rate(chosen[i].held) for i in held])


def _as_one_body(found: LagrangeSystem, pair: Pair, r: Any) -> tuple[list[Any], Any]:
    """Accelerations of two bodies that stick to each other, as one expression, and the force between them."""
    one, two, mass = pair.first, pair.second, found.masses
    accelerations = [force / m for force, m in zip(r, mass, strict=True)]
    accelerations[one] = accelerations[two] = (r[one] + r[two]) / (mass[one] + mass[two])
    return accelerations, sticking_force(found, pair, r)


def sticking_force(found: LagrangeSystem, pair: Pair, r: Sequence[Any]) -> Any:
    """F_T from x1'' = x2'' with M x1'' = r1 + F_T and m x2'' = r2 - F_T, Eqs. (1) and (5)."""
    heavy, light = found.masses[pair.first], found.masses[pair.second]
    return (heavy * r[pair.second] - light * r[pair.first]) / (heavy + light)


def _held_by_forces(
    found: LagrangeSystem, chosen: Sequence[ContactRegime], held: Sequence[int], free: Any
) -> tuple[list[Any], list[HoldingForce]]:
    """Accelerations and holding forces where contacts hold any velocities at zero, solved by sympy."""
    inverse = found.inverse
    rows = sympy.Matrix([found.gradient(chosen[i].held, found.v) for i in held])
    reach = _sparse_product(rows, inverse)
    rates = [found.rate(chosen[i].held) for i in held]
    along = [-(rate + part) for rate, part in zip(rates, _sparse_product(reach, free), strict=True)]
    columns = sympy.Matrix.hstack(*(found.direction(found.mechanics.contacts[i]) for i in held))
    softness = _sparse_product(reach, columns)
    forces: list[Any] = [None] * len(held)
    holding: list[Any] = [None] * len(held)
    # Block by block: most are independent, as those of contacts of different bodies.
    for block in softness.connected_components():
        matrix, right = softness.extract(block, block), sympy.Matrix([along[i] for i in block])
        for i, force in zip(block, matrix.LUsolve(right), strict=True):
            forces[i], holding[i] = force, HoldingForce(_expand(force))
        if found.varies(matrix):
            against = (isinstance(found.mechanics.contacts[held[i]], Friction) for i in block)
            for i, one in zip(block, _products(matrix, right, (-1) ** sum(against)), strict=True):
                holding[i] = HoldingForce(holding[i].force, *one)
    # Expanded, terms that cancel vanish: a constrained velocity keeps its value to the last bit.
    pushed = free + _sparse_product(columns, sympy.Matrix(forces))
    accelerations = [_expand(a) for a in found.accelerations(list(pushed))]
    for i, rate in enumerate(rates):
        there = [k for k in range(rows.cols) if rows[i, k] != 0]
        if len(there) == 1:  # terms with floats may not cancel
            accelerations[there[0]] = _expand(-rate / rows[i, there[0]])
    return accelerations, holding


def _products(matrix: Any, right: Any, sign: int) -> Iterator[tuple[Any, Any]]:
    """By Cramer's rule the determinant of this sign, and its product with each unknown."""
    for i in range(matrix.rows):
        replaced = matrix.copy()
        replaced[:, i] = right
        yield _expand(sign * matrix.det()), _expand(sign * replaced.det())


def _sparse_product(one: Any, other: Any) -> Any:
    """The product of two matrices with few entries that are not zero."""
    there: dict[int, list[tuple[int, Any]]] = {}
    for (i, k), entry in sorted(other.todok().items()):
        there.setdefault(i, []).append((k, entry))
    found: dict[tuple[int, int], Any] = {}
    for (i, j), factor in sorted(one.todok().items()):
        for k, entry in there.get(j, ()):
            found[i, k] = found.get((i, k), sympy.S.Zero) + factor * entry
    return sympy.Matrix(one.rows, other.cols, lambda i, k: found.get((int(i), int(k)), sympy.S.Zero))


def flow_of(found: LagrangeSystem, accelerations: Sequence[Any]) -> tuple[Any, ...]:
    """The rates of all states."""
    return (*found.v, *accelerations, *found.phase_rate)


def mode_of(found: LagrangeSystem, combination: Combination) -> Mode:
    """The mode of one regime for each contact."""
    chosen = found.chosen(combination)
    solved = solve_contact_forces(found, chosen)
    names = [regime.name for regime in chosen]
    name = found.names.name_of(combination)
    events = [
        _event(found, combination, i, end)
        for i, regime in enumerate(chosen)
        for end in regime.ends(*solved.holding.get(found.leader(i, names), (regime.force, regime.limit)))
        if not end.common or found.leader(i, names) == i
    ]
    events += period_events(found, name)
    constraints = tuple(c for regime in chosen for c in regime.constraints)
    outputs = _outputs(found, chosen, solved.forces)
    return Mode(name, flow_of(found, solved.accelerations), tuple(events), constraints, outputs)


def _event(found: LagrangeSystem, combination: Combination, i: int, end: RegimeEnd) -> Event:
    changed = (one for name in end.targets for one in _entered(found, combination, i, end, name))
    targets = tuple(dict.fromkeys(found.names.name_of(one) for one in changed if found.allows(one)))
    contact, label = found.mechanics.contacts[i], end.name + contact_suffix(found, i)
    if end.jump == "impact":
        return Event(label, end.function, targets, *impact_resets(found, contact))
    if end.jump == "project":
        return Event(label, end.function, targets, stick_reset(found, contact))
    return Event(label, end.function, targets)


def _entered(
    found: LagrangeSystem, combination: Combination, i: int, end: RegimeEnd, name: str
) -> Iterator[Combination]:
    """The combinations to try where the regime of contact `i` ends and that of this name follows."""
    chosen = found.chosen(combination)
    if chosen[i].held is not None:  # a contact that is at its limit while others hold may now hold instead
        resting = (j for j, one in enumerate(chosen) if one is found.regimes[j][combination[j]].resting)
        yield from (_changed(found, combination, {i: name, j: "stick"}) for j in resting)
    direction = found.direction_of(i) if end.common else None
    names = [regime.name for regime in chosen]
    for changes in ({i: name},) if direction is None else direction.together(i, names, name):
        yield _changed(found, combination, changes)


def _changed(found: LagrangeSystem, combination: Combination, names: Mapping[int, str]) -> Combination:
    """The combination with the regimes of these names, as far as the contacts have them."""
    changed = list(combination)
    for i, name in names.items():
        known = [regime.name for regime in found.regimes[i]]
        changed[i] = known.index(name) if name in known else combination[i]
    return tuple(changed)


def contact_suffix(found: LagrangeSystem, i: int) -> str:
    """Suffix of the outputs of a contact where there are several: _1, _2 ..."""
    return f"_{i + 1}" if len(found.mechanics.contacts) > 1 else ""


def _outputs(found: LagrangeSystem, chosen: Sequence[ContactRegime], forces: Sequence[Any]) -> dict[str, Any]:
    outputs = {}
    for i, (contact, regime, force) in enumerate(zip(found.mechanics.contacts, chosen, forces, strict=True)):
        outputs |= {
            name + contact_suffix(found, i): value for name, value in _contact_outputs(contact, regime, force)
        }
    return outputs


def _contact_outputs(contact: Friction | Stop, regime: ContactRegime, force: Any) -> Any:
    if isinstance(contact, Stop):
        return ("distance", contact.distance), ("reaction", force)
    shown = (
        ("normal_force", regime.pressing),
        ("friction_force", force),
        ("relative_velocity", contact.relative_velocity),
    )
    penetration = contact.penetration
    return shown if penetration is None else (("penetration", penetration), ("gap", -penetration), *shown)
