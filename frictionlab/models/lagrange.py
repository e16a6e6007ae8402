"""A model's energies, loads and contacts as a hybrid automaton, by Lagrange's equations.

A contact that holds a velocity at zero gives the force that keeps it there; several are solved for at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.on_demand import ModesOnDemand, Sketch

from .chatter import SHORTEST, chatter
from .mechanics import Friction, Stop
from .regimes import End, Regime
from .resets import impact, projection
from .symbols import multiplied_out
from .system import Pair, System, name_of, system


def derived(model: Any) -> HybridAutomaton:
    """States and modes of a symbolic copy of a model, one mode for each combination of regimes.

    Several contacts have many combinations, of which a run visits few: each is derived once it is asked for.
    """
    found = system(model)
    chosen, numbers = found.combinations, {}
    if len(found.mechanics.contacts) > 1:
        sketches = (_sketch(name, some, len(found.states)) for name, some in chosen.items())
        modes: Any = ModesOnDemand(sketches, lambda name: mode_of(found, chosen[name]))
    else:
        modes = tuple(mode_of(found, some) for some in chosen.values())
        limit = chatter(found)
        if limit is not None:
            modes, numbers = (*modes, limit), {SHORTEST: 0.0}
    return HybridAutomaton(found.states, modes, numbers, len(found.q))


def _sketch(name: str, chosen: Sequence[Regime], states: int) -> Sketch:
    """What can be said without solving for forces: sticking needs v_r = 0, sliding v_r of its sign."""
    needs: list[Any] = []
    for regime in chosen:
        if regime.force is None:
            needs += [sign * c for c in regime.constraints for sign in (1, -1)]
        else:
            needs += [end.function for end in regime.ends(regime.force)]
    held = any(regime.held is not None for regime in chosen)
    return Sketch(name, (sympy.S.Zero,) * states, constraints=tuple(needs), held=held)


def solved(found: System, chosen: Sequence[Regime]) -> tuple[list[Any], list[Any]]:
    """Accelerations, and the force of each contact."""
    contacts = found.mechanics.contacts
    free = sympy.Matrix([load - rest for load, rest in zip(found.loads, found.internal, strict=True)])
    for contact, regime in zip(contacts, chosen, strict=True):
        free += found.direction(contact) * (0 if regime.force is None else regime.force)
        if isinstance(contact, Friction) and regime.name != "separation":
            free += found.normal(contact) * contact.pressing
    held = [i for i, regime in enumerate(chosen) if regime.force is None]
    forces = [regime.force for regime in chosen]
    if not held:
        return list(found.inverse * free), forces
    pair = found.pair(chosen[held[0]].held) if len(held) == 1 else None
    if pair is not None:
        accelerations, forces[held[0]] = _as_one_body(found, pair, free)
        return accelerations, forces
    return _held_by_forces(found, chosen, held, free)


def _as_one_body(found: System, pair: Pair, r: Any) -> tuple[list[Any], Any]:
    """Accelerations of two bodies that stick to each other, of one expression, and the force between."""
    one, two, mass = pair.first, pair.second, found.masses
    accelerations = [force / m for force, m in zip(r, mass, strict=True)]
    accelerations[one] = accelerations[two] = (r[one] + r[two]) / (mass[one] + mass[two])
    return accelerations, sticking_force(found, pair, r)


def sticking_force(found: System, pair: Pair, r: Sequence[Any]) -> Any:
    """F_T from x1'' = x2'' with M x1'' = r1 + F_T and m x2'' = r2 - F_T, Eqs. (1) and (5)."""
    heavy, light = found.masses[pair.first], found.masses[pair.second]
    return (heavy * r[pair.second] - light * r[pair.first]) / (heavy + light)


def _held_by_forces(
    found: System, chosen: Sequence[Regime], held: Sequence[int], free: Any
) -> tuple[list[Any], list[Any]]:
    """The same where the velocities of several contacts, or one of any direction, are held."""
    inverse, forces = found.inverse, [regime.force for regime in chosen]
    rows = sympy.Matrix([[sympy.diff(chosen[i].held, rate) for rate in found.v] for i in held])
    along = sympy.Matrix([found.rate(chosen[i].held) for i in held]) + rows * inverse * free
    columns = sympy.Matrix.hstack(*(found.direction(found.mechanics.contacts[i]) for i in held))
    holding = (rows * inverse * columns).LUsolve(-along)
    for i, force in zip(held, holding, strict=True):
        forces[i] = multiplied_out(force)
    # Expanded, what cancels is gone: a held velocity keeps its value to the last bit.
    return [multiplied_out(a) for a in inverse * (free + columns * holding)], forces


def mode_of(found: System, chosen: Sequence[Regime]) -> Mode:
    """The mode of one regime for each contact."""
    accelerations, forces = solved(found, chosen)
    name = name_of(chosen)
    events = [
        _event(found, chosen, i, end) for i, regime in enumerate(chosen) for end in regime.ends(forces[i])
    ]
    clock = [found.mechanics.frequency for _ in found.phase]
    events += [
        Event("period", 2 * sympy.pi - phase, (name,), Reset({phase: phase - 2 * sympy.pi}))
        for phase in found.phase
    ]
    constraints = tuple(c for regime in chosen for c in regime.constraints)
    outputs = _outputs(found, chosen, forces)
    return Mode(name, (*found.v, *accelerations, *clock), tuple(events), constraints, outputs)


def _event(found: System, chosen: Sequence[Regime], i: int, end: End) -> Event:
    names, known = [regime.name for regime in chosen], found.combinations
    targets = (name_of([*names[:i], target, *names[i + 1 :]]) for target in end.targets)
    targets = tuple(target for target in targets if target in known)
    contact, label = found.mechanics.contacts[i], end.name + number(found, i)
    if end.jump == "impact":
        return Event(label, end.function, targets, *impact(found, contact))
    if end.jump == "project":
        return Event(label, end.function, targets, projection(found, contact))
    return Event(label, end.function, targets)


def number(found: System, i: int) -> str:
    """What tells the contacts apart where there are several: _1, _2 ..."""
    return f"_{i + 1}" if len(found.mechanics.contacts) > 1 else ""


def _outputs(found: System, chosen: Sequence[Regime], forces: Sequence[Any]) -> dict[str, Any]:
    outputs = {}
    for i, (contact, regime, force) in enumerate(zip(found.mechanics.contacts, chosen, forces, strict=True)):
        outputs |= {name + number(found, i): value for name, value in _quantities(contact, regime, force)}
    return outputs


def _quantities(contact: Friction | Stop, regime: Regime, force: Any) -> Any:
    if isinstance(contact, Stop):
        return ("distance", contact.distance), ("reaction", force)
    normal = sympy.S.Zero if regime.name == "separation" else contact.pressing
    shown = (
        ("normal_force", normal),
        ("friction_force", force),
        ("relative_velocity", contact.relative_velocity),
    )
    return shown if contact.gap is None else (("gap", contact.gap), *shown)
