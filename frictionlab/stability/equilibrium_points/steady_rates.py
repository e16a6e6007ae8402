"""Steady motions as equilibria: the rates of a mode whose zeros are its steady motions.

Cyclic coordinates turn for ever.  Where nothing depends on how far some of them have turned together, as a
motor and the shaft on it, their velocities need not vanish.  One coordinate of each such group, the carrier
q_1, is set to zero.  The others are measured from it, as q_i - r_i q_1 with the ratio r_i in which they turn,
so that their rates are v_i - r_i v_1.  Of the flow that is left a steady rotation is an equilibrium, with the
eigenvalues of the whole system but the zero of the carrier.

A closed rigid contact keeps a distance g(q) at zero, which gives one coordinate and its velocity by the
others: q_k = h(q), v_k = dh/dt.  They are put in place of q_k and v_k, so what is left is the flow in minimal
coordinates, as if written by hand.  If g is linear in no coordinate, h is two steps of Newton's method from
q_k itself: where g = 0 its derivatives up to the third are those of the exact h, and more is never asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.hybrid_automaton import module_of_pieces
from frictionlab.lazy_names import sympy
from frictionlab.presentation import PHASE, TIME


class SteadyRates(NamedTuple):
    """Rates whose zeros are the steady motions of a mode, and the places of states that follow from others.

    These are carriers and idle clocks, whose rates are minus themselves, and states that a constraint gives,
    such as a deflection at its limit or the height on a rigid contact.  The rate of one that a constraint
    gives is what it gives minus the state.  No other rate depends on them.
    """

    rates: tuple[Any, ...]
    following: tuple[int, ...] = ()


def steady_rates(
    automaton: HybridAutomaton, mode: Mode, preferred: Sequence[int] = (), idle: Sequence[int] = ()
) -> SteadyRates:
    """The rates of a mode; those of cyclic coordinates relative to the carriers, where there are any.

    Distances give the coordinates `preferred` (their places), if they can.  Clocks that are `idle`, such as
    the phase of a load that vanishes, are set to zero like carriers.
    """
    rates, carriers = _relative_rates(automaton, mode, idle)
    n, dependent = automaton.coordinates, states_by_constraints(automaton, mode, preferred).dependent
    values = {automaton.states[place]: one.value for place, one in dependent.items() if place < 2 * n}
    for place, rate in [*enumerate(rates)] if values else ():
        rates[place] = sympy.sympify(rate, strict=True).xreplace(values)
    for place, one in dependent.items():
        rates[place] = one.rate
    return SteadyRates(tuple(rates), tuple(sorted({*carriers, *dependent})))


def _relative_rates(
    automaton: HybridAutomaton, mode: Mode, idle: Sequence[int]
) -> tuple[list[Any], Iterable[int]]:
    """The rates of a mode, those of cyclic coordinates relative to the carriers; and the places of these and
    of idle clocks."""
    rates, n = list(mode.flow), automaton.coordinates
    places = sorted(automaton.state_names.index(name) for name in automaton.cyclic)
    carriers = _carriers(automaton, mode, places) if places else {}
    for place in places:
        moving = (ratios.get(place, 0) * automaton.states[n + one] for one, ratios in carriers.items())
        rates[place] = rates[place] - sum(moving, sympy.S.Zero)
    for place in (*carriers, *idle):
        rates[place] = -automaton.states[place]
    return rates, (*carriers, *idle)


def static_rates(automaton: HybridAutomaton, mode: Mode, idle: Sequence[int]) -> tuple[Any, ...]:
    """What vanishes at the steady motions of a mode, without M^-1: functions of states and reactions.

    Forces are in place of accelerations.  A distance of zero goes with each reaction.
    """
    assert mode.balance is not None
    rates, _ = _relative_rates(automaton, mode, idle)
    n, (dependent, _, distances) = automaton.coordinates, states_by_constraints(automaton, mode)
    rates[n : 2 * n] = mode.balance.forces
    for place, one in dependent.items():
        if place >= 2 * n:
            rates[place] = one.rate
    return (*rates, *distances)


def clocks_of(automaton: HybridAutomaton) -> list[int]:
    """The places of the phase and the time."""
    first, names = 2 * automaton.coordinates, automaton.state_names
    return [place for place in range(first, len(names)) if names[place] in (PHASE, TIME)]


def is_free(automaton: HybridAutomaton, mode: Mode) -> bool:
    """Whether each constraint of a mode gives a state, so that its equilibria are single points.

    In stick each place within the friction cone is one.
    """
    return not mode.limit and not states_by_constraints(automaton, mode).remainder


class DependentState(NamedTuple):
    """What a constraint says of a state: its value by the others, and a rate that is zero there."""

    value: Any
    rate: Any


class ConstrainedStates(NamedTuple):
    """The states that the constraints of a mode give, by their places, the constraints that give none, and
    the distances among them."""

    dependent: dict[int, DependentState]
    remainder: tuple[Any, ...]
    distances: tuple[Any, ...]


def states_by_constraints(
    automaton: HybridAutomaton, mode: Mode, preferred: Sequence[int] = ()
) -> ConstrainedStates:
    """The states that constraints give: a distance a coordinate and its velocity, the limit of a friction law
    the law's state.
    """
    n, states = automaton.coordinates, automaton.states
    some = [sympy.sympify(constraint, strict=True) for constraint in mode.constraints]
    clocks = _clock_rates(automaton, mode)
    distances = [one for one in some if _is_distance(one, states, n, clocks)]
    moving, speeds = (*states[:n], *clocks), (*states[n : 2 * n], *clocks.values())
    rates = [_rate(one, moving, speeds) for one in distances]
    others = [one for one in some if one not in distances and all(sympy.expand(one - r) for r in rates)]
    dependent = _coordinates_by_distances(automaton, distances, preferred, clocks)
    if len(dependent) == 2 * len(distances) == len(some) - len(others):
        some = others  # else a distance lacks its rate, or two distances are one
    else:
        dependent = {}
    remainder = []
    for constraint in some:
        place, slope = _law_state(constraint, states, n)
        if place is None:
            remainder.append(constraint)
        else:
            rate = -constraint / slope
            dependent[place] = DependentState(states[place] + rate, rate)
    return ConstrainedStates(dependent, tuple(remainder), tuple(distances))


def _clock_rates(automaton: HybridAutomaton, mode: Mode) -> dict[Any, Any]:
    """The rates of the clocks; a state of such a name whose rate depends on states is none."""
    rates = {automaton.states[i]: sympy.sympify(mode.flow[i], strict=True) for i in clocks_of(automaton)}
    return {x: rate for x, rate in rates.items() if rate.free_symbols.isdisjoint(automaton.states)}


def _is_distance(constraint: Any, states: Sequence[Any], n: int, clocks: Iterable[Any]) -> bool:
    """Whether a constraint is one of coordinates, and of clocks beside them."""
    inputs = constraint.free_symbols & {*states}
    return not inputs.isdisjoint(states[:n]) and inputs <= {*states[:n], *clocks}


def _law_state(constraint: Any, states: Sequence[Any], n: int) -> tuple[int | None, Any]:
    """The place of the further state that a constraint gives, and its slope; None for velocities."""
    moving = not constraint.free_symbols.isdisjoint(states[n : 2 * n])
    further = [] if moving else [x for x in states[2 * n :] if x in constraint.free_symbols]
    slope = sympy.diff(constraint, further[-1]) if further else sympy.S.Zero
    if slope == 0 or not slope.free_symbols.isdisjoint(states):
        return None, slope
    return states.index(further[-1]), slope


def _coordinates_by_distances(
    automaton: HybridAutomaton, distances: Sequence[Any], preferred: Sequence[int], clocks: Mapping[Any, Any]
) -> dict[int, DependentState]:
    """The coordinates that distances of zero give, first of these, and their velocities, by their places;
    `clocks` have the rates of the clocks."""
    n, states = automaton.coordinates, automaton.states
    q, v, solutions = states[:n], states[n : 2 * n], {}
    for distance in distances:
        equation = sympy.expand(distance.xreplace({x: one.value for x, one in solutions.items()}))
        candidates = [x for x in q if x in equation.free_symbols and x.name not in automaton.cyclic]
        candidates = [x for x in candidates if x not in solutions]
        if not candidates:
            return {}
        slopes = {x: _order_of_choice(sympy.diff(equation, x), x, states) for x in reversed(candidates)}
        x = min(slopes, key=lambda x: (q.index(x) not in preferred, slopes[x]))
        root = _root(equation, x)
        solutions = {
            other: DependentState(*(part.xreplace({x: root.value}) for part in one))
            for other, one in solutions.items()
        }
        solutions[x] = root
    free = [i for i in range(n) if q[i] not in solutions]
    dependent = {}
    for x, one in solutions.items():
        place = q.index(x)
        moving, speeds = [*(q[i] for i in free), *clocks], [*(v[i] for i in free), *clocks.values()]
        speed = _rate(one.value, moving, speeds)
        dependent[place], dependent[n + place] = one, DependentState(speed, speed - v[place])
    return dependent


def _rate(function: Any, q: Sequence[Any], v: Sequence[Any]) -> Any:
    """The rate of a function of coordinates and clocks."""
    return sum((sympy.diff(function, x) * rate for x, rate in zip(q, v, strict=True)), sympy.S.Zero)


def _order_of_choice(slope: Any, x: Any, states: Sequence[Any]) -> int:
    """Which coordinate a distance gives: first one with a slope that is a number, then one that is linear."""
    states_of_slope = slope.free_symbols & {*states}
    return 2 if x in states_of_slope else 1 if states_of_slope else 0


def _root(function: Any, x: Any) -> DependentState:
    """Where a function of x is zero, if it is linear in x; else two steps of Newton's method from x."""
    slope = sympy.diff(function, x)
    if x in slope.free_symbols:
        step = x - function / slope
        return DependentState(step.xreplace({x: step}), -function / slope)
    value = sympy.expand(-function.subs(x, 0) / slope)
    return DependentState(value, value - x)


def _carriers(automaton: HybridAutomaton, mode: Mode, places: Sequence[int]) -> dict[int, dict[int, Any]]:
    """The carriers, each with the ratios in which the others turn with it, by their places.

    Empty where something depends on how far any of the coordinates have turned.
    """
    states = {*automaton.states}
    angles = [automaton.states[place] for place in places]
    functions = (*mode.flow[automaton.coordinates :], *(e.function for e in mode.events), *mode.constraints)
    rows = []
    for slopes in _gradients(_arguments_of_pieces(functions), angles):
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


def _arguments_of_pieces(functions: Iterable[Any]) -> list[Any]:
    """The functions with numbers in the place of functions in pieces, whose arguments follow.

    The ratio of two derivatives of such a function is a number that sympy does not see.
    """
    pieces, waiting = module_of_pieces(), [sympy.sympify(function, strict=True) for function in functions]
    if pieces is None:
        return waiting
    smooth: list[Any] = []
    while waiting:
        function = waiting.pop(0)
        parts = function.atoms(pieces.Pieces)
        smooth.append(function.xreplace({part: sympy.Dummy() for part in parts}))
        waiting += [argument for part in sorted(parts, key=str) for argument in part.args]
    return smooth


def _gradients(functions: Iterable[Any], angles: Sequence[Any]) -> Iterable[list[Any]]:
    for function in functions:
        expression = sympy.sympify(function, strict=True)
        if not expression.free_symbols.isdisjoint(angles):
            yield [sympy.diff(expression, angle) for angle in angles]
