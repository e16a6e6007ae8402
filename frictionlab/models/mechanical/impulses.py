"""The impulse of each impact of a run, from what the velocities do there.

M (v+ - v-) = sum of W p: the impulses of the contacts that are closed at an event follow from its jump,
whatever the impact law.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import StructureKey
from frictionlab.models.symbols import parameter_symbols, structure_values
from frictionlab.tape.formulas import function_along_run

from .contact_regimes import CHATTER_FLIGHT, impact_rubs, normal_direction, rubbing_direction
from .equations_of_motion import LagrangeSystem, system_of
from .mechanics import Stop
from .modes import contact_suffix

if TYPE_CHECKING:
    from .mechanical_model import MechanicalModel

Array = NDArray[np.float64]
ROUNDING = 1e-13  # share of the greatest impulse of an event below which others are none
TOUCHING = 1e-9  # share of the coordinates, or of its largest value in a run, below which a gap is closed


@dataclass(frozen=True, eq=False)
class Striking:
    """A contact that has impacts: its place among the contacts, gap, and entries of W_N and, where impacts
    have friction, of W_T."""

    place: int
    suffix: str
    guard: str
    gap: Any
    normal: tuple[Any, ...]
    rubbing: tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class ImpulseTerms:
    """The contacts of a structure that have impacts, and the entries of M, row by row."""

    contacts: tuple[Striking, ...]
    masses: tuple[Any, ...]


def impulses_by_name(model: MechanicalModel, events: Any, states: Array) -> dict[str, Array]:
    """The impulses (E,) of a run's events, N s, by their names; see `Events`."""
    contacts = impulse_terms(model.structure_key).contacts
    by_name = {}
    for one, (normal, rubbed) in zip(contacts, impulses_of_contacts(model, events, states), strict=True):
        by_name["impulse" + one.suffix] = normal
        if one.rubbing:
            by_name["friction_impulse" + one.suffix] = rubbed
    return by_name


def impulses_of_contacts(model: MechanicalModel, events: Any, states: Array) -> list[tuple[Array, Array]]:
    """The impulses (E,) along W_N and W_T of each contact that has impacts, of the events of a run.

    The states (N, states) of its samples tell how far gaps open.
    """
    terms, numbers, n = impulse_terms(model.structure_key), structure_values(model), len(model.coordinates)
    before, after, guards = events.before, events.state, events.guard
    values = [(np.zeros(len(before)), np.zeros(len(before))) for _ in terms.contacts]
    struck = np.isin(guards, [CHATTER_FLIGHT, *(one.guard for one in terms.contacts)])
    rows = np.flatnonzero(struck & (before != after).any(axis=1))
    if not len(rows):
        return values

    def at(functions: tuple[Any, ...], states: Array) -> Array:
        columns = [np.broadcast_to(np.asarray(f(*states.T, *numbers), float), len(states)) for f in functions]
        return np.reshape(np.transpose(columns), (len(states), -1, n))

    masses = at(terms.masses, before[rows])
    sides = [at((*one.normal, *one.rubbing), before[rows]) for one in terms.contacts]
    gaps = [np.abs(one.gap(*before[rows].T, *numbers)) * np.ones(len(rows)) for one in terms.contacts]
    widest = [np.abs(one.gap(*states.T, *numbers)).max(initial=0.0) for one in terms.contacts]
    reach = np.abs(states[:, :n]).max(axis=0, initial=0.0)  # a gap that never opens is rounding of these
    sizes = [np.maximum(wide, np.abs(side[:, 0]) @ reach) for wide, side in zip(widest, sides, strict=True)]
    for k, e in enumerate(rows):
        fired = [guards[e] in (one.guard, CHATTER_FLIGHT) for one in terms.contacts]
        hit = [i for i, gap in enumerate(gaps) if fired[i] or gap[k] <= TOUCHING * sizes[i][k]]
        momentum = masses[k] @ (after[e, n : 2 * n] - before[e, n : 2 * n])
        columns = np.concatenate([np.zeros((0, n)), *(sides[i][k] for i in hit)]).T
        shares, first = impulses_along(columns, momentum), 0
        for i in hit:
            normal, rubbed = values[i]
            normal[e] = shares[first]
            rubbed[e] = shares[first + 1] if terms.contacts[i].rubbing else 0.0
            first += len(sides[i][k])
    return values


def impulses_along(directions: Array, jumps: Array) -> Array:
    """Impulses (k,) or (k, E) along directions (n, k) that make jumps (n,) or (n, E), 0 where rounding."""
    impulses = np.linalg.lstsq(directions, jumps)[0]
    largest = np.abs(impulses).max(axis=0, initial=0.0)
    return np.where(np.abs(impulses) > ROUNDING * largest, impulses, 0.0)


@lru_cache(maxsize=64)
def impulse_terms(key: StructureKey) -> ImpulseTerms:
    """The masses of a structure, and its contacts that have impacts."""
    system = system_of(key)
    arguments = [*system.states, *parameter_symbols(key)]

    def compiled(expression: Any) -> Any:
        return function_along_run(arguments, expression)

    contacts = (_striking(system, i, compiled) for i in range(len(system.mechanics.contacts)))
    return ImpulseTerms(tuple(one for one in contacts if one is not None), tuple(map(compiled, system.mass)))


def _striking(system: LagrangeSystem, i: int, compiled: Any) -> Striking | None:
    contact: Any = system.mechanics.contacts[i]
    suffix = contact_suffix(system, i)
    if isinstance(contact, Stop):
        gap, law, guard = contact.distance, contact.law, "impact"
    else:
        gap, law, guard = contact.penetration, contact.impact, "gap"
    if gap is None or law is None or not contact.modes:
        return None
    rubbing = rubbing_direction(system, contact) if impact_rubs(system, contact, law) else ()
    functions = tuple(map(compiled, normal_direction(system, contact))), tuple(map(compiled, rubbing))
    return Striking(i, suffix, guard + suffix, compiled(gap), *functions)
