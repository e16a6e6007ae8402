"""A model's energies, loads and contacts as a hybrid automaton, by Lagrange's equations.

Where contacts keep velocities at zero, as in stick, their forces follow from these constraints, for all
contacts at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple

import sympy
from sympy.matrices import dotprodsimp

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.hybrid_automaton import module_of_pieces
from frictionlab.automaton.mode import Balance
from frictionlab.automaton.modes_on_demand import Combination, ModesOnDemand, Regime
from frictionlab.components.component import StructureKey
from frictionlab.models.automaton_of_model import automaton_of_structure
from frictionlab.models.serialisation import structure_to_data
from frictionlab.models.symbols import expand_products
from frictionlab.presentation import DISTANCE, REACTION

from .contact_regimes import (
    APART,
    CHATTER_TIME,
    ContactRegime,
    HeldVelocity,
    RegimeEnd,
    chatter_mode,
    crossing_reset,
    holding_reset,
    period_events,
    rubbing_outputs,
    unloading_reset,
    yielding_reset,
    zeros_in_contact,
)
from .coupled_masses import HeldVelocities, held_velocities
from .equations_of_motion import LagrangeSystem, Pair, system_of
from .mechanics import AnyContact, Friction, Stop

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

YIELDS = "yield", "hold"  # what ends a regime of a state of an elastic-plastic law
_expand = lru_cache(maxsize=4096)(expand_products)  # most are the same in many modes


def derive_automaton(model: MechanicalModel) -> HybridAutomaton:
    """States and modes of a symbolic copy of a model, one mode for each combination of regimes.

    Several contacts have many combinations, of which a run visits few; then each mode is derived when it is
    first used.
    """
    key, numbers = model.structure_key, {}
    system = system_of(key)
    if len(system.parts) > 1:
        modes: Any = ModesOnDemand(
            conditions_of_regimes(system),
            lambda combination: mode_of(system, combination),
            system.names,
            *_again(key),
        )
    else:
        modes = tuple(mode_of(system, combination) for combination in system.names.combinations())
        limit = chatter_mode(system)
        if limit is not None:
            modes, numbers = (*modes, limit), {CHATTER_TIME: 0.0}
    pieces = module_of_pieces()
    if pieces is not None and pieces.has_pieces(expressions := list(expressions_of(system))):
        modes = pieces.split_modes(modes, system.states, expressions, *_again(key))
    return HybridAutomaton(system.states, modes, numbers, len(system.q), model.cyclic)


def _again(key: StructureKey) -> tuple[Any, Any]:
    """How modes on demand are made again in another process, and the data for files of runs."""
    return (modes_of_structure, (key,)), lambda: structure_to_data(key)


def expressions_of(system: LagrangeSystem) -> Iterator[Any]:
    """All that modes are made of, in which functions in pieces are looked for."""
    yield from (*system.internal, *system.loads, *system.other_rates, *system.mass)
    for contact, regimes in zip(system.mechanics.contacts, system.regimes, strict=True):
        if isinstance(contact, Stop):
            yield contact.distance
        else:
            yield from (contact.penetration, contact.pressing)
            if isinstance(contact, Friction):
                yield from contact.velocities
        for regime in regimes:
            yield from (regime.force, regime.limit, *regime.constraints, *regime.rates)
            for end in regime.ends(sympy.S.Zero, sympy.S.Zero):
                yield end.function
                if end.jump == "impact":
                    yield from system.impact_resets(contact)[0].jump.values()


def modes_of_structure(key: StructureKey) -> Any:
    """The modes of a structure, the same object throughout a process."""
    return automaton_of_structure(key).modes


def conditions_of_regimes(system: LagrangeSystem) -> tuple[tuple[Regime, ...], ...]:
    """The conditions of the regimes of each part that are known without accelerations."""
    unknown = {*system.accelerations_of_mode}
    return tuple(tuple(conditions_of_regime(one, unknown) for one in regimes) for regimes in system.parts)


def conditions_of_regime(regime: ContactRegime, unknown: set[Any]) -> Regime:
    """A regime's conditions that are known without solving for forces: v_r = 0 in stick, its sign in slip."""
    if regime.force is None:
        needs = [sign * c for c in regime.constraints for sign in (1, -1)]
        needs += [] if regime.sliding is None else [regime.sliding]
    else:
        needs = [end.function for end in regime.ends(regime.force, None)]
    rates = tuple(
        sympy.sympify(one, strict=True).xreplace(dict.fromkeys(unknown, sympy.S.Zero)) for one in regime.rates
    )
    needs = [one for one in needs if unknown.isdisjoint(sympy.sympify(one, strict=True).free_symbols)]
    distances = len(regime.constraints) - len(regime.held)  # a rigid contact has one and its rate
    return Regime(regime.name, tuple(needs), len(regime.held) > distances, rates)


class ContactForces(NamedTuple):
    """Accelerations; the force of each contact; the friction of each rigid one; what the ends of each regime
    that holds depend on, by its index: force and limit; and the balance, where `hold` is not given.

    A contact that holds for others of its direction has the sum of their forces and limits there.  Both are
    multiplied by a compliance where this depends on the state: where it is zero the force is infinite.
    """

    accelerations: list[Any]
    forces: list[Any]
    friction: dict[int, Any]
    holding: dict[int, tuple[Any, Any]]
    balance: Balance | None


@dataclass(frozen=True, eq=False)
class HoldingForce:
    """A force that holds a velocity; where its compliance depends on the state this, and their product."""

    force: Any
    compliance: Any = sympy.S.One
    product: Any = None

    @property
    def scaled(self) -> Any:
        """The force, times the compliance where this depends on the state."""
        return self.force if self.product is None else self.product


def solve_contact_forces(
    system: LagrangeSystem, chosen: Sequence[ContactRegime], hold: Hold | None = None
) -> ContactForces:
    """Accelerations and contact forces where each contact is in its regime of `chosen`.

    `hold` finds the forces that hold; by default sympy and arithmetic with numbers of coupled masses do.
    """
    slipping_off = [i for i, one in enumerate(chosen) if one.by_holding is not None]
    would_hold: dict[int, tuple[Any, Any]] = {}
    if slipping_off:
        would_hold, chosen = _breaking_away(system, chosen, slipping_off, hold)
    names = [regime.name for regime in chosen]
    leading = [i for i, one in enumerate(chosen) if one.force is None and system.leader(i, names) == i]
    held = [(i, one) for i in leading for one in chosen[i].held]
    free, balance = (None, None) if hold else _free_forces(system, chosen, held)
    accelerations, forces, solved = hold(chosen, leading) if hold else _hold(system, chosen, held, free)
    friction, holding = {}, dict[int, tuple[Any, Any]](would_hold)
    for i, (one, *other) in solved.items():
        if system.mechanics.contacts[i].in_plane:
            forces[i] = (one.force, other[0].force)
            holding[i] = forces[i], chosen[i].limit
        elif chosen[i].share is not None:
            friction[i] = chosen[i].share * one.force
            holding[i] = one.scaled, None if one.product is None else one.compliance
        elif other:
            friction[i], holding[i] = other[0].force, (one.scaled, other[0].scaled)
        else:
            holding[i] = _with_limit(system, chosen, forces, i, one)
    return ContactForces(accelerations, forces, friction, holding, balance)


def _breaking_away(
    system: LagrangeSystem, chosen: Sequence[ContactRegime], which: Sequence[int], hold: Hold | None
) -> tuple[dict[int, tuple[Any, Any]], list[ContactRegime]]:
    """The forces that would hold the contacts `which` and their rates; and the regimes, those with the
    friction by them."""
    after, would_hold = list(chosen), dict[int, tuple[Any, Any]]()
    for i in which:
        after[i] = next(one for one in system.regimes[i] if one.name == "stick")
    stuck = solve_contact_forces(system, after, hold)
    forces = stuck.forces
    for i in which:
        by_holding = chosen[i].by_holding
        assert by_holding is not None
        rates = tuple(system.rate_in_motion(one, stuck.accelerations) for one in forces[i])
        would_hold[i] = forces[i], rates
        after[i] = replace(chosen[i], force=by_holding(forces[i], rates))
    return would_hold, after


def _with_limit(
    system: LagrangeSystem, chosen: Sequence[ContactRegime], forces: list[Any], i: int, one: HoldingForce
) -> tuple[Any, Any]:
    """Force and limit of a contact that holds, for all of its direction, whose shares go into `forces`."""
    direction, limit = system.direction_of(i), chosen[i].limit
    if direction is not None and limit is not None:
        limits = {j: chosen[j].limit for j in direction.contacts if chosen[j].name == "stick"}
        shares, limit = direction.shares(i, one.force, limits)
        for j, share in shares.items():
            forces[j] = share
    if one.product is None or limit is None:
        return one.scaled, limit
    return one.product, one.compliance * limit


Held = Sequence[tuple[int, HeldVelocity]]  # what is held at zero, each with the index of its contact
Solution = tuple[list[Any], list[Any], dict[int, list[HoldingForce]]]
Hold = Callable[[Sequence[ContactRegime], Sequence[int]], Solution]


def _free_forces(
    system: LagrangeSystem, chosen: Sequence[ContactRegime], held: Held
) -> tuple[list[Any], Balance]:
    """All forces but those that hold, for each coordinate; and the balance of all."""
    free = [load - rest for load, rest in zip(system.loads, system.internal, strict=True)]
    for contact, regime in zip(system.mechanics.contacts, chosen, strict=True):
        system.apply(system.direction(contact), 0 if regime.force is None else regime.force, free)
        if regime.pressing != 0:
            system.apply(system.normal(contact), regime.pressing, free)
    reactions = tuple(sympy.Symbol(f"reaction {k + 1}", real=True) for k in range(len(held)))
    total = list(free)
    for (_, one), reaction in zip(held, reactions, strict=True):
        system.apply(one.along, reaction, total)
    return free, Balance(tuple(total), reactions)


def _hold(system: LagrangeSystem, chosen: Sequence[ContactRegime], held: Held, free: Any) -> Solution:
    """Accelerations, the force of each contact, and by contact those that hold velocities at zero."""
    forces = [regime.force for regime in chosen]
    if not held:
        return system.accelerations(free), forces, {}
    pair = None
    if len(held) == 1 and chosen[held[0][0]].share is None:
        pair = system.pair(held[0][1].velocity)
    if pair is not None:
        accelerations, force = _as_one_body(system, pair, free)
        # The reaction of a stop acts along the gradient of what it holds, friction against it.
        solved = [HoldingForce(-held[0][1].sign * force)]
    elif (velocities := _held_in_numbers(system, held)) is not None:
        accelerations, known = velocities.solve(free, system.states)
        solved = [HoldingForce(force) for force in known]
    else:
        accelerations, solved = _held_by_forces(system, held, sympy.Matrix(free))
    holding: dict[int, list[HoldingForce]] = {i: [] for i, _ in held}
    for (i, _), one in zip(held, solved, strict=True):
        holding[i].append(one)
    for i, (first, *_) in holding.items():
        forces[i] = first.force
    return accelerations, forces, holding


def _held_in_numbers(system: LagrangeSystem, held: Held) -> HeldVelocities | None:
    """The velocities held at zero, where M^-1 is in numbers; None where only sympy can find the forces."""
    if system.coupled is None:
        return None
    rows = [system.gradient(one.velocity, system.v) for _, one in held]
    rates = [system.rate(one.velocity) for _, one in held]
    return held_velocities(system.coupled, rows, [list(one.along) for _, one in held], rates)


def _as_one_body(system: LagrangeSystem, pair: Pair, r: Any) -> tuple[list[Any], Any]:
    """Accelerations of two bodies that stick to each other, as one expression, and the force between them."""
    one, two, mass = pair.first, pair.second, system.masses
    accelerations = [force / m for force, m in zip(r, mass, strict=True)]
    accelerations[one] = accelerations[two] = (r[one] + r[two]) / (mass[one] + mass[two])
    return accelerations, sticking_force(system, pair, r)


def sticking_force(system: LagrangeSystem, pair: Pair, r: Sequence[Any]) -> Any:
    """F_T from x1'' = x2'' with M x1'' = r1 + F_T and m x2'' = r2 - F_T, Eqs. (1) and (5)."""
    heavy, light = system.masses[pair.first], system.masses[pair.second]
    return (heavy * r[pair.second] - light * r[pair.first]) / (heavy + light)


def _held_by_forces(system: LagrangeSystem, held: Held, free: Any) -> tuple[list[Any], list[HoldingForce]]:
    """Accelerations and holding forces where contacts hold any velocities at zero, solved by sympy."""
    inverse = system.inverse
    rows = sympy.Matrix([system.gradient(one.velocity, system.v) for _, one in held])
    reach = _sparse_product(rows, inverse)
    rates = [system.rate(one.velocity) for _, one in held]
    along = [-(rate + part) for rate, part in zip(rates, _sparse_product(reach, free), strict=True)]
    columns = sympy.Matrix.hstack(*(one.along for _, one in held))
    softness = _sparse_product(reach, columns)
    forces: list[Any] = [None] * len(held)
    holding: list[Any] = [None] * len(held)
    # Block by block: most are independent, as those of contacts of different bodies.
    for block in softness.connected_components():
        matrix, right = softness.extract(block, block), sympy.Matrix([along[i] for i in block])
        for i, force in zip(block, matrix.LUsolve(right), strict=True):
            forces[i], holding[i] = force, HoldingForce(_expand(force))
        if system.varies(matrix):
            sign = prod(held[i][1].sign for i in block)
            for i, one in zip(block, _products(matrix, right, sign), strict=True):
                holding[i] = HoldingForce(holding[i].force, *one)
    # Expanded, terms that cancel vanish: a constrained velocity keeps its value to the last bit.
    pushed = free + _sparse_product(columns, sympy.Matrix(forces))
    accelerations = [_expand(a) for a in system.accelerations(list(pushed))]
    for i, rate in enumerate(rates):
        there = [k for k in range(rows.cols) if rows[i, k] != 0]
        if len(there) == 1:  # terms with floats may not cancel
            accelerations[there[0]] = _expand(-rate / rows[i, there[0]])
    return accelerations, holding


def _products(matrix: Any, right: Any, sign: int) -> Iterator[tuple[Any, Any]]:
    """By Cramer's rule the determinant of this sign, and its product with each unknown."""
    compliance = _expand(sign * _determinant(matrix))
    for i in range(matrix.rows):
        replaced = matrix.copy()
        replaced[:, i] = right
        yield compliance, _expand(sign * _determinant(replaced))


def _determinant(matrix: Any) -> Any:
    """Without divisions, and without looking for common factors, which may take hours."""
    with dotprodsimp(False):
        return matrix.det(method="berkowitz")


def _sparse_product(one: Any, other: Any) -> Any:
    """The product of two matrices with few entries that are not zero."""
    there: dict[int, list[tuple[int, Any]]] = {}
    for (i, k), entry in sorted(other.todok().items()):
        there.setdefault(i, []).append((k, entry))
    product: dict[tuple[int, int], Any] = {}
    for (i, j), factor in sorted(one.todok().items()):
        for k, entry in there.get(j, ()):
            product[i, k] = product.get((i, k), sympy.S.Zero) + factor * entry
    return sympy.Matrix(one.rows, other.cols, lambda i, k: product.get((int(i), int(k)), sympy.S.Zero))


def mode_of(system: LagrangeSystem, combination: Combination, hold: Hold | None = None) -> Mode:
    """The mode of one regime for each part."""
    chosen = system.chosen(combination)
    solved = solve_contact_forces(system, chosen, hold)
    names = [regime.name for regime in chosen]
    name = system.names.name_of(combination)
    known = dict(zip(system.accelerations_of_mode, solved.accelerations, strict=True))
    events = [
        _event(system, combination, i, _in_motion(end, known))
        for i, regime in enumerate(chosen)
        for end in regime.ends(*solved.holding.get(system.leader(i, names), (regime.force, regime.limit)))
        if not end.common or system.leader(i, names) == i
    ]
    events += period_events(system, name)
    constraints = tuple(c for regime in chosen for c in regime.constraints)
    outputs = contact_outputs(system, chosen, solved)
    rates = [sympy.sympify(rate, strict=True).xreplace(known) for regime in chosen for rate in regime.rates]
    flow = system.flow(solved.accelerations, rates)
    return Mode(name, flow, tuple(events), constraints, outputs, balance=solved.balance)


def _in_motion(end: RegimeEnd, accelerations: Mapping[Any, Any]) -> RegimeEnd:
    """The end of a regime of slip at a limit that moves with the accelerations of the mode."""
    return end._replace(function=end.function.xreplace(accelerations)) if end.jump == "hold" else end


def _event(system: LagrangeSystem, combination: Combination, i: int, end: RegimeEnd) -> Event:
    changed = (one for name in end.targets for one in _entered(system, combination, i, end, name))
    targets = tuple(dict.fromkeys(system.names.name_of(one) for one in changed if system.names.allows(one)))
    contact, part, of = system.mechanics.contacts[i], _part_of(system, i, end), contact_suffix(system, i)
    label = end.name + (of if part == i else f"_{system.of_laws[i][end.state]}")
    if end.jump == "impact":
        return Event(label, end.function, targets, *system.impact_resets(contact))
    if end.jump == "project":
        return Event(label, end.function, targets, _projection(system, combination, i))
    if end.jump == "stop":  # where its function jumps to need not be asked: what follows depends on v_r alone
        alone = _projection(system, combination, i)
        return Event(label, end.function, targets, Reset(alone.jump, {**alone.vanishing, end.function: 0}))
    if end.jump == "cross" and isinstance(contact, Friction):
        return Event(label, end.function, targets, crossing_reset(contact))
    if end.jump == "yield" and isinstance(contact, Friction):
        return Event(label, end.function, targets, yielding_reset(system, contact, end))
    if end.jump == "hold" and isinstance(contact, Friction):
        left = system.parts[part][combination[part]].name
        return Event(label, end.function, targets, holding_reset(system, contact, end.state, left))
    if end.jump == "open" and isinstance(contact, Stop):
        return Event(label, end.function, targets, Reset(vanishing=zeros_in_contact(system, contact)))
    if end.jump == "unload" and isinstance(contact, Friction):
        return Event(label, end.function, targets, unloading_reset(system, contact))
    return Event(label, end.function, targets)


def _projection(system: LagrangeSystem, combination: Combination, i: int) -> Reset:
    """The reset to v_r = 0 of contact `i`, after which all other contacts hold what they held.

    It removes rounding errors only.  So it may leave such errors in what the others hold, and none is more.
    """
    alone = system.stick_reset(system.mechanics.contacts[i])
    zero = {**_zeros_of_mode(system, combination), **_zeros_that_follow(system, combination, i)}
    return Reset(alone.jump, {**zero, **alone.vanishing}) if zero else alone


def _zeros_that_follow(system: LagrangeSystem, combination: Combination, i: int) -> dict[Any, int]:
    """v_r of contacts that slip, which is zero where contact `i` sticks besides those that do.

    Where directions depend on the state it need not be: that of a crank's bearing is not zero at the dead
    centre, where the piston stops.
    """
    direction = system.direction_of(i)
    some = () if direction is None else direction.contacts
    together = [i, *(j for j in some if direction is not None and direction.at_one_speed(j, i))]
    stuck = _changed(system, combination, dict.fromkeys(together, "stick"))
    if not system.names.allows(stuck):
        return {}
    chosen = system.chosen(stuck)
    held = [one.velocity for regime in chosen for one in regime.held]
    if any(system.varies(slope) for one in held for slope in system.gradient(one, system.v)):
        return {}
    rest = [one for one, regimes, k in zip(chosen, system.regimes, stuck) if one is regimes[k].resting]
    return {sign * speed: 1 for one in rest for speed in one.constraints for sign in (1, -1)}


@lru_cache(maxsize=8)  # all events of a mode ask for it
def _zeros_of_mode(system: LagrangeSystem, combination: Combination) -> dict[Any, int]:
    """What contacts hold at zero, with the number of leading coefficients."""
    zero: dict[Any, int] = {}
    for contact, regime in zip(system.mechanics.contacts, system.chosen(combination), strict=True):
        zero |= dict.fromkeys(regime.constraints, 1)
        if isinstance(contact, Stop) and regime.constraints:
            zero |= zeros_in_contact(system, contact)
    return zero


def _entered(
    system: LagrangeSystem, combination: Combination, i: int, end: RegimeEnd, name: str
) -> Iterator[Combination]:
    """The combinations to try where the regime of contact `i` ends and that of this name follows."""
    chosen = system.chosen(combination)
    if chosen[i].held:  # a contact that is at its limit while others hold may now hold instead
        resting = (j for j, one in enumerate(chosen) if one is system.regimes[j][combination[j]].resting)
        yield from (_changed(system, combination, {i: name, j: "stick"}) for j in resting)
    direction = system.direction_of(i) if end.common else None
    names = [regime.name for regime in chosen]
    alone = _with_states(system, i, _part_of(system, i, end), name)
    for changes in alone if direction is None else direction.together(i, names, name):
        yield _changed(system, combination, changes)


def _part_of(system: LagrangeSystem, i: int, end: RegimeEnd) -> int:
    """The part whose regime ends: contact `i`, or a state of its law that has regimes of its own."""
    return system.parts_of_states[i][end.state] if i in system.parts_of_states and end.jump in YIELDS else i


def _with_states(system: LagrangeSystem, i: int, part: int, name: str) -> tuple[dict[int, str], ...]:
    """The changes to try where a part of contact `i` enters a regime: with it the states of its law."""
    states = system.parts_of_states.get(i, ()) if part == i else ()
    of_states = ("separation",) if name in APART else ("slip+", "slip-", "stick")
    return tuple({part: name, **dict.fromkeys(states, one)} for one in (of_states if states else (name,)))


def _changed(system: LagrangeSystem, combination: Combination, names: Mapping[int, str]) -> Combination:
    """The combination with the regimes of these names, as far as the contacts have them."""
    changed = list(combination)
    for i, name in names.items():
        known = [regime.name for regime in system.parts[i]]
        changed[i] = known.index(name) if name in known else combination[i]
    return tuple(changed)


def contact_suffix(system: LagrangeSystem, i: int) -> str:
    """Suffix of the outputs of a contact where there are several: _1, _2 ..."""
    return f"_{i + 1}" if len(system.mechanics.contacts) > 1 else ""


def contact_outputs(
    system: LagrangeSystem, chosen: Sequence[ContactRegime], solved: ContactForces
) -> dict[str, Any]:
    """What a mode shows of its contacts, by name."""
    outputs = {}
    for i, (contact, regime) in enumerate(zip(system.mechanics.contacts, chosen, strict=True)):
        values = _outputs_of_contact(contact, regime, solved.forces[i], solved.friction.get(i, sympy.S.Zero))
        outputs |= {name + contact_suffix(system, i): value for name, value in values}
    return outputs


def _outputs_of_contact(contact: AnyContact, regime: ContactRegime, force: Any, friction: Any) -> Any:
    if isinstance(contact, Stop):
        rigid = (DISTANCE, contact.distance), (REACTION, force)
        return (*rigid, *rubbing_outputs(contact, friction).items()) if contact.rubs else rigid
    shown = (("normal_force", regime.pressing),)
    if isinstance(contact, Friction):
        shown += tuple(rubbing_outputs(contact, force).items())
    penetration = contact.penetration
    return shown if penetration is None else (("penetration", penetration), ("gap", -penetration), *shown)
