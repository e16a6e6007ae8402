"""Steady rotation as an equilibrium: the rates of a mode whose zeros are its steady motions.

Cyclic coordinates turn for ever.  Where nothing depends on how far some of them have turned together, as a
motor and the shaft on it, their velocities need not vanish.  One coordinate of each such group, the carrier
q_1, is set to zero.  The others are measured from it, as q_i - r_i q_1 with the ratio r_i in which they turn,
so that their rates are v_i - r_i v_1.  Of the flow that is left a steady rotation is an equilibrium, with the
eigenvalues of the whole system but the zero of the carrier.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.lazy_names import sympy


class SteadyRates(NamedTuple):
    """Rates whose zeros are the steady motions of a mode, and the places of states that follow from others.

    These are carriers, whose rates are minus themselves, and states that a constraint gives, such as a
    deflection at its limit.  No other rate depends on them.
    """

    rates: tuple[Any, ...]
    following: tuple[int, ...] = ()


def steady_rates(automaton: HybridAutomaton, mode: Mode) -> SteadyRates:
    """The rates of a mode; those of cyclic coordinates relative to the carriers, where there are any."""
    rates = list(mode.flow)
    names, n = automaton.state_names, automaton.coordinates
    places = sorted(names.index(name) for name in automaton.cyclic)
    carriers = _carriers(automaton, mode, places) if places else {}
    for place in places:
        moving = (ratios.get(place, 0) * automaton.states[n + one] for one, ratios in carriers.items())
        rates[place] = rates[place] - sum(moving, sympy.S.Zero)
    for carrier in carriers:
        rates[carrier] = -automaton.states[carrier]
    constrained = {place: rate for place, rate in constrained_states(automaton, mode) if place is not None}
    for place, rate in constrained.items():
        rates[place] = rate
    return SteadyRates(tuple(rates), tuple(sorted({*carriers, *constrained})))


def is_free(automaton: HybridAutomaton, mode: Mode) -> bool:
    """Whether a mode has no constraints but for those that give a state of a friction law."""
    return not mode.limit and all(place is not None for place, _ in constrained_states(automaton, mode))


def constrained_states(automaton: HybridAutomaton, mode: Mode) -> Iterator[tuple[int | None, Any]]:
    """For each constraint the place of the further state that it gives, and a rate that is zero there.

    The place is None for other constraints, such as those of velocities.
    """
    n = automaton.coordinates
    for constraint in mode.constraints:
        expression = sympy.sympify(constraint, strict=True)
        moving = not expression.free_symbols.isdisjoint(automaton.states[n : 2 * n])
        further = [] if moving else [x for x in automaton.states[2 * n :] if x in expression.free_symbols]
        slope = sympy.diff(expression, further[-1]) if further else sympy.S.Zero
        if slope == 0 or not slope.free_symbols.isdisjoint(automaton.states):
            yield None, None
        else:
            yield automaton.states.index(further[-1]), -expression / slope


def _carriers(automaton: HybridAutomaton, mode: Mode, places: Sequence[int]) -> dict[int, dict[int, Any]]:
    """The carriers, each with the ratios in which the others turn with it, by their places.

    Empty where something depends on how far any of the coordinates have turned.
    """
    states = {*automaton.states}
    angles = [automaton.states[place] for place in places]
    functions = (*mode.flow[automaton.coordinates :], *(e.function for e in mode.events), *mode.constraints)
    rows = []
    for slopes in _gradients(functions, angles):
        first = next((slope for slope in slopes if slope != 0), None)
        if first is None:
            continue
        ratios = [sympy.cancel(slope / first) for slope in slopes]
        if any(ratio.free_symbols & states for ratio in ratios):
            return {}
        rows.append(ratios)
    matrix = sympy.Matrix(len(rows), len(places), [one for row in rows for one in row])
    carriers = {}
    for together in matrix.nullspace():
        ratios = {place: ratio for place, ratio in zip(places, together, strict=True) if ratio != 0}
        # of a basis vector of sympy, the entry of the free column is the last that is not zero, and 1
        carriers[max(ratios)] = ratios
    return carriers


def _gradients(functions: Iterable[Any], angles: Sequence[Any]) -> Iterable[list[Any]]:
    for function in functions:
        expression = sympy.sympify(function, strict=True)
        if not expression.free_symbols.isdisjoint(angles):
            yield [sympy.diff(expression, angle) for angle in angles]
