"""Branches of periodic orbits: lengths of steps, special points, and ends.

Folds, period doublings and Neimark-Sacker points are zeros of test functions.  Where the sequence of modes
changes, the reason is given: a stay in a mode vanishes, or an orbit grazes a guard.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar, root_scalar

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.orbits.periodic_orbit import floquet_multipliers, transverse_multipliers
from frictionlab.analysis.orbits.pseudo_arclength import BranchPoint, continuation_step, reversed_point
from frictionlab.automaton import HybridAutomaton
from frictionlab.presentation import Kind
from frictionlab.tape.formulas import function_along_run
from frictionlab.tape.structural_zeros import sign_normal_form

LOCATION_XTOL = 1e-12  # share of the step to which a special point is located
# how far from the unit circle rounding may put the multipliers of a Neimark-Sacker point
UNIT_CIRCLE_ATOL = 1e-3
TEST_ATOL = 1e-9  # test functions are differences of numbers of about 1: below this they are rounding
NO_ORBIT = "no orbit found"
VANISHING_STAY_SHARE = 1e-3  # share of the period below which a stay is about to vanish
# an orbit grazes where an event function falls to this share of its largest value between events
GRAZING_RTOL = 1e-4
SAMPLES_PER_PERIOD = 4001
# Shares of the distance of the bounds: how far an orbit that touches may be from the last one that impacts,
# and the first step of the search for it.
MAX_TOUCH_DISTANCE, TOUCH_STEP = 0.2, 1e-4

BOUND, MAX_POINTS, INTERRUPTED = "bound", "most orbits", "interrupted"  # why a branch ends
# the longest step over this: a shorter step that fails means that the sequence of modes changes
SHORTEST_STEP_PARTS = 64
END_BISECTIONS = 40  # halvings of that step, until both sides of such a change have met
# up to so many iterations of Newton's method the next step is longer, from so many on shorter
FAST_ITERATIONS, SLOW_ITERATIONS = 3, 6
RESTART_LENGTHS = 5  # lengths tried to step beyond such a change, each a quarter of the one before
MIN_ALIGNMENT = 0.8  # least cosine of the angle between a step's chord and the tangent at its end
MAX_TANGENT_CHANGE = 0.3  # largest change of a component of the tangent in a step
# most orbits in a fit; and orbits it needs in excess of its coefficients, to estimate the scatter
HOPF_FIT_POINTS, HOPF_FIT_SPARE = 12, 3
VARIANCE_SAMPLES = 64  # of an orbit that shrinks to an equilibrium, so that it is nearly a sine
EXTRAPOLATION_RTOL = (
    1e-6  # share of the bounds' distance: a value extrapolated so far beyond a bound is at it
)
HOPF_SIZE_RTOL = 1e-2  # an orbit smaller than this share of the largest so far has shrunk to an equilibrium


def _transverse_multipliers(point: BranchPoint) -> Array:
    return transverse_multipliers(floquet_multipliers(point.monodromy))


def fold_test(point: BranchPoint) -> float:
    """How fast the parameter grows along the branch."""
    return float(point.tangent[-1])


def period_doubling_test(point: BranchPoint) -> float:
    """Zero where a multiplier is -1."""
    return float(np.prod(1.0 + _transverse_multipliers(point)).real)


def neimark_sacker_test(point: BranchPoint) -> float:
    """Zero where the product of two multipliers is 1."""
    values = _transverse_multipliers(point)
    products = np.outer(values, values)[np.triu_indices(len(values), 1)]
    return float(np.prod(1.0 - products).real)


class SpecialKind(Kind):
    """Kind of a special point of a branch of orbits."""

    FOLD = "fold"
    PERIOD_DOUBLING = "period doubling"
    NEIMARK_SACKER = "Neimark-Sacker"
    GRAZING = "grazing"
    MODE_CHANGE = "mode change"
    HOPF = "Hopf"


TEST_FUNCTIONS: dict[SpecialKind, Callable[[BranchPoint], float]] = {
    SpecialKind.FOLD: fold_test,
    SpecialKind.PERIOD_DOUBLING: period_doubling_test,
    SpecialKind.NEIMARK_SACKER: neimark_sacker_test,
}


class SpecialPoint(NamedTuple):
    """A special point, its kind, and the parameter there."""

    kind: SpecialKind
    point: BranchPoint
    value: float


def special_points_between(
    automaton: HybridAutomaton, point: BranchPoint, after: BranchPoint, step: float
) -> list[SpecialPoint]:
    """The special points between a point and the one a step after it, in their order.

    One that cannot be located, as no orbit is found within the step, is put at the point `after`.
    """
    by_share = []
    for kind, test in TEST_FUNCTIONS.items():
        before, then = test(point), test(after)
        # Both are rounding where a branch runs at one value of the parameter, or keeps its multipliers.
        if before * then < 0.0 and max(abs(before), abs(then)) > TEST_ATOL:
            try:
                at, share = locate_zero(automaton, point, step, test)
            except ValueError:
                at, share = after, step
            by_share += [(share, SpecialPoint(kind, at, at.value))] if _is_special(kind, at) else []
    return [special for _, special in sorted(by_share, key=lambda pair: pair[0])]


def locate_zero(
    automaton: HybridAutomaton, point: BranchPoint, step: float, test: Callable[[BranchPoint], float]
) -> tuple[BranchPoint, float]:
    """The point at which a test function changes its sign within a step, and how far into the step it is."""

    def value(share: float) -> float:
        return test(continuation_step(automaton, point, share)) if share else test(point)

    share: Any = brentq(value, 0.0, step, xtol=LOCATION_XTOL * step)
    return continuation_step(automaton, point, share), share


def _is_special(kind: SpecialKind, point: BranchPoint) -> bool:
    """Whether a zero of a test function is a special point.

    Two real multipliers whose product is 1 make a zero that is no Neimark-Sacker point.
    """
    values = _transverse_multipliers(point)
    pairs = values[np.abs(values.imag) > 0.0]
    return kind != SpecialKind.NEIMARK_SACKER or bool((np.abs(np.abs(pairs) - 1.0) < UNIT_CIRCLE_ATOL).any())


def branch_end_kind(automaton: HybridAutomaton, point: BranchPoint, other: BranchPoint | None) -> str:
    """The kind of change of the sequence of modes after an orbit.

    It is told from the orbit beyond the change where one is known, else from this orbit alone.
    """
    if other is not None:
        few, many = sorted((point, other), key=lambda side: len(side.modes))
        more = len(many.modes) - len(few.modes)
        return (
            SpecialKind.GRAZING
            if more == 2 or (more == 1 and _self_transitions(many) == _self_transitions(few) + 1)
            else SpecialKind.MODE_CHANGE
        )
    run, period = point.shot.run, point.period
    if len(run.events):
        stays = np.diff(np.append(run.events.t, run.events.t[0] + period))
        i = int(np.argmin(stays))
        if stays[i] < VANISHING_STAY_SHARE * period:
            back = run.events.source[i] == np.roll(run.events.target, -1)[i]
            return SpecialKind.GRAZING if back else SpecialKind.MODE_CHANGE
    if _grazes(automaton, point):
        return SpecialKind.GRAZING
    return SpecialKind.MODE_CHANGE if _at_guard_limit(automaton, point) else NO_ORBIT


def _self_transitions(point: BranchPoint) -> int:
    """How many events lead back to the mode that they end, as impacts do."""
    events = point.shot.run.events
    return int((events.source == events.target).sum())


def _grazes(automaton: HybridAutomaton, point: BranchPoint) -> bool:
    """Whether an event function has a minimum of nearly zero within a stay."""
    run = point.shot.run
    t = np.linspace(0.0, point.period, SAMPLES_PER_PERIOD)
    states, modes = run.states_and_modes(t)
    arguments, numbers = [*automaton.states, *automaton.parameters], automaton.parameters.values()
    for i in np.unique(modes):
        for event in automaton.mode(run.mode_names[i]).events:
            values = function_along_run(arguments, event.function)(*states.T, *numbers)
            if _has_zero_minimum(np.where(modes == i, values, np.nan)):
                return True
    return False


def _at_guard_limit(automaton: HybridAutomaton, point: BranchPoint) -> bool:
    """Whether an event function is nearly zero where its mode is entered, though not by construction.

    An example is the margin to the static limit of friction at an onset of stick: beyond the parameter's
    value at which it is zero, slip goes on.
    """
    events, numbers = point.shot.run.events, automaton.parameters.values()
    modes = {
        name: automaton.mode(name) for name in {*events.source.tolist(), *events.target.tolist()} if name
    }
    arguments = [*automaton.states, *automaton.parameters]
    for source, target, guard, state in zip(
        events.source, events.target, events.guard, events.state, strict=True
    ):
        left = modes[source]
        trigger = next(event for event in left.events if event.name == guard)
        zero = {*map(sign_normal_form, (trigger.function, *left.constraints, *trigger.reset.vanishing))}
        for event in modes[target].events:
            if sign_normal_form(event.function) in zero:
                continue
            function = function_along_run(arguments, event.function)
            along = function(*point.shot.run.states.T, *numbers)
            if abs(function(*state, *numbers)) < GRAZING_RTOL * np.abs(along).max():
                return True
    return False


def grazing_value(
    automaton: HybridAutomaton, point: BranchPoint, bounds: tuple[float, float]
) -> float | None:
    """The parameter at which an orbit's weakest impact becomes a touch; None where it does not.

    Towards it the impacting orbit changes as the root of the parameter's distance, so that Newton's method
    ends before it.  The orbit that only touches is one without the impact as well, and smooth in the
    parameter: it is where the least value of the event function over a period is zero.
    """
    events = point.shot.run.events
    back = np.flatnonzero(events.source == events.target)
    for i in back:
        mode, guard = str(events.source[i]), str(events.guard[i])
        if ((events.source == mode) & (events.guard == guard)).sum() == 1:
            value = _touching_value(automaton, point, mode, guard)
            if value is not None and bounds[0] <= value <= bounds[1]:
                return value
    return None


def _touching_value(automaton: HybridAutomaton, point: BranchPoint, mode: str, guard: str) -> float | None:
    left = automaton.mode(mode)
    function = next(event.function for event in left.events if event.name == guard)
    without = replace(left, events=tuple(event for event in left.events if event.name != guard))
    modes = tuple(without if other.name == mode else other for other in automaton.modes)
    free = replace(automaton.derived(), modes=modes)
    gap = function_along_run([*automaton.states, *automaton.parameters], function)
    resting = point._replace(tangent=np.zeros_like(point.tangent))  # so that only the value is moved
    numbers, at = tuple(automaton.parameters.values()), [resting]

    def margin(value: float) -> float:
        at[0] = continuation_step(free, at[0], MAX_TOUCH_DISTANCE, value)._replace(tangent=resting.tangent)
        run = at[0].shot.run
        t = np.linspace(0.0, run.raw.t, SAMPLES_PER_PERIOD)
        i = int(np.argmin(gap(*run(t).T, *numbers)))
        near = minimize_scalar(
            lambda s: float(gap(*run(s % run.raw.t), *numbers)),
            bounds=(t[i] - t[1], t[i] + t[1]),
            method="bounded",
            options={"xatol": 1e-9 * run.raw.t},
        )
        return float(near.fun)

    try:
        solution: Any = root_scalar(
            margin, x0=point.value, x1=point.value + TOUCH_STEP * point.scale[-1], method="secant", rtol=1e-12
        )
    except (ValueError, np.linalg.LinAlgError):
        return None
    near = abs(solution.root - point.value) < MAX_TOUCH_DISTANCE * point.scale[-1]
    return float(solution.root) if solution.converged and near else None


def _has_zero_minimum(values: Array) -> bool:
    """Whether values, NaN in other modes, have a minimum of nearly zero."""
    inner = values[1:-1]
    least = (inner <= values[:-2]) & (inner < values[2:])
    return bool((inner[least] < GRAZING_RTOL * np.nanmax(np.abs(values))).any())


class BranchHalf(NamedTuple):
    """One half of a branch: points and special points in order from the first orbit on, and why it ended."""

    points: list[BranchPoint]
    special: list[SpecialPoint]
    end: str


class BranchStep(NamedTuple):
    """A step along the branch: the orbit `after` it, if one is found, and its length.

    `end` is "bound" where that orbit is at a bound.  `edge` tells that the sequence of modes changes after
    it, or the branch ends; `other` is then the orbit beyond, if one is found.
    """

    after: BranchPoint | None
    length: float
    end: str = ""
    edge: bool = False
    other: BranchPoint | None = None


def follow_branch(
    automaton: HybridAutomaton,
    start: BranchPoint,
    bounds: tuple[float, float],
    max_step: float,
    max_points: int,
) -> Iterator[BranchHalf]:
    """Follow a branch from a point, which is left out; yields the half found so far after every orbit."""
    points: list[BranchPoint] = []
    special: list[SpecialPoint] = []
    point, length, largest = start, max_step / 4, start.scale[:-2]
    while len(points) < max_points:
        step = _next_step(automaton, point, length, max_step, bounds)
        after, end = step.after, step.end
        if after is not None:
            between = special_points_between(automaton, point, after, step.length)
            # Between two orbits within the bounds a branch may turn back outside.
            beyond = next((each for each in between if not _is_inside(each.point, bounds)), None)
            if beyond is not None:
                after, end = _orbit_at_bound(automaton, point, step.length, beyond, bounds), BOUND
                between = [each for each in between if _is_inside(each.point, bounds)]
            special += between
            points.append(after)
            largest = np.maximum(largest, after.scale[:-2])
            if (after.scale[:-2] < HOPF_SIZE_RTOL * largest).all():
                value = _within_bounds(_hopf_value([start, *points]), bounds)
                if value is not None:  # else the bound comes first
                    special.append(SpecialPoint(SpecialKind.HOPF, after, value))
                    end = SpecialKind.HOPF
            if end:
                return (yield BranchHalf(points, special, end))
            length = _next_length(step.length, after, max_step)
            point = after
        if step.edge:
            kind, ahead = (
                branch_end_kind(automaton, point, step.other),
                _restart_beyond(automaton, step.other, max_step / SHORTEST_STEP_PARTS),
            )
            touch = grazing_value(automaton, point, bounds) if kind != SpecialKind.MODE_CHANGE else None
            kind, value = (kind, point.value) if touch is None else (SpecialKind.GRAZING, touch)
            special += [SpecialPoint(SpecialKind(kind), point, value)] if kind != NO_ORBIT else []
            if ahead is None or not bounds[0] <= ahead.value <= bounds[1]:
                return (yield BranchHalf(points, special, kind))
            point, length = ahead, max_step / SHORTEST_STEP_PARTS
            points.append(point)
        yield BranchHalf(points, special, MAX_POINTS)


def _next_step(
    automaton: HybridAutomaton,
    point: BranchPoint,
    length: float,
    max_step: float,
    bounds: tuple[float, float],
) -> BranchStep:
    """The next orbit with the same modes; if there is none close by, the last one before the modes change."""
    while True:
        at_bound = _step_to_bound(automaton, point, length, bounds)
        if at_bound is not None:
            return at_bound
        after = _try_step(automaton, point, length)
        if after is not None and not _is_inside(after, bounds):
            at = _try_step(automaton, point, length, min(max(after.value, bounds[0]), bounds[1]))
            if _continues(point, at):
                return BranchStep(at, length, BOUND)
        elif _continues(point, after):
            return BranchStep(after, length)
        if length < max_step / SHORTEST_STEP_PARTS or (after is not None and after.modes != point.modes):
            return _locate_mode_change(automaton, point, length, after, bounds)
        length /= 2


def _step_to_bound(
    automaton: HybridAutomaton, point: BranchPoint, length: float, bounds: tuple[float, float]
) -> BranchStep | None:
    """The orbit at a bound that is within a step; beyond the bound there may be no model."""
    speed = point.tangent[-1] * point.scale[-1]
    bound = bounds[int(speed > 0.0)]
    if speed == 0.0 or (bound - point.value) / speed > length:
        return None
    share = (bound - point.value) / speed
    after = _try_step(automaton, point, share, bound)
    return BranchStep(after, share, BOUND) if _continues(point, after) else None


def _orbit_at_bound(
    automaton: HybridAutomaton,
    point: BranchPoint,
    length: float,
    beyond: SpecialPoint,
    bounds: tuple[float, float],
) -> BranchPoint:
    """The orbit at the bound that lies before a fold beyond it; the point itself where none is found."""
    bound = bounds[int(beyond.value > bounds[1])]
    share = length * (bound - point.value) / (beyond.value - point.value)
    return _try_step(automaton, point, share, bound) or point


def _is_inside(point: BranchPoint, bounds: tuple[float, float]) -> bool:
    """Whether the parameter is within the bounds, outside of which there may be no model."""
    return bounds[0] <= point.value <= bounds[1]


def _locate_mode_change(
    automaton: HybridAutomaton,
    point: BranchPoint,
    length: float,
    other: BranchPoint | None,
    bounds: tuple[float, float],
) -> BranchStep:
    """The orbits on both sides of a change of modes, or of the branch's end, found by halving a step."""
    low, high, last = 0.0, length, None
    other = other if other is not None and other.modes != point.modes else None
    for _ in range(END_BISECTIONS):
        middle = (low + high) / 2
        trial = _try_step(automaton, point, middle)
        if trial is not None and _is_same_way(point, trial) and _is_inside(trial, bounds):
            low, last = middle, trial
        else:
            high = middle
            other = trial if trial is not None and trial.modes != point.modes else other
    return BranchStep(last, low, edge=True, other=other)


def _try_step(
    automaton: HybridAutomaton, point: BranchPoint, length: float, value: float | None = None
) -> BranchPoint | None:
    try:
        return continuation_step(automaton, point, length, value)
    except (ValueError, np.linalg.LinAlgError):
        return None


def _continues(point: BranchPoint, after: BranchPoint | None) -> bool:
    """Whether a point continues the branch: it has the same modes and nearly the same tangent as before.

    The tangents are compared in period and parameter only, as the state has been moved along the orbit.
    """
    if after is None or not _is_same_way(point, after):
        return False
    return bool(np.abs(np.abs(after.tangent[-2:]) - np.abs(point.tangent[-2:])).max() < MAX_TANGENT_CHANGE)


def _is_same_way(point: BranchPoint, after: BranchPoint) -> bool:
    """Whether a point has the same modes and its tangent is nearly along the chord.

    Where an impact that comes once in two periods becomes a touch, the same orbit one period later starts:
    a step from one to the other passes the touch, and only the chord tells so.
    """
    return after.modes == point.modes and after.alignment > MIN_ALIGNMENT


def _hopf_value(points: list[BranchPoint]) -> float:
    """The parameter at which the amplitude becomes zero; near there it is a smooth function of its square.

    A line through the last two orbits would amplify their rounding errors about five times.  So lines and
    parabolas are fitted to the last twelve orbits or fewer, and the fit with the least standard error at zero
    is taken: more orbits average out rounding, fewer are less affected by curvature.
    """
    last = [p for p in points[-HOPF_FIT_POINTS:] if p.modes == points[-1].modes]
    size = last[-1].scale[:-2]
    square = np.array([float((_variance(p) / size**2).sum()) for p in last])
    value = np.array([p.value for p in last]) - last[-1].value
    fits = [
        _fit_at_zero(square[-count:], value[-count:], degree)
        for degree in (1, 2)
        for count in range(degree + 1 + HOPF_FIT_SPARE, len(last) + 1)
    ]
    if not fits:
        return float(last[-1].value + np.polyfit(square[-2:], value[-2:], 1)[-1])
    return last[-1].value + min(fits, key=lambda fit: fit[1])[0]


def _variance(point: BranchPoint) -> Array:
    """That of each state (n,) along an orbit, by the trapezium rule, which is exact to rounding for smooth
    periodic motions; a range would depend on where the steps of the run happen to end."""
    t = np.linspace(0.0, point.period, VARIANCE_SAMPLES, endpoint=False)
    return point.shot.run(t)[:, :-1].var(axis=0)


def _within_bounds(value: float, bounds: tuple[float, float]) -> float | None:
    """An extrapolated value, at a bound where it is beyond that by rounding; None where it is outside."""
    inside = float(np.clip(value, *bounds))
    return inside if abs(value - inside) <= EXTRAPOLATION_RTOL * (bounds[1] - bounds[0]) else None


def _fit_at_zero(x: Array, y: Array, degree: int) -> tuple[float, float]:
    """Value of a fitted polynomial at x = 0, and its standard error."""
    powers = (x[:, None] / x.max()) ** np.arange(degree + 1)
    inverse = np.linalg.pinv(powers)
    left = y - powers @ (inverse @ y)
    scatter = np.sqrt(left @ left / (len(x) - degree - 1))
    return float(inverse[0] @ y), float(scatter * np.linalg.norm(inverse[0]))


def _next_length(length: float, after: BranchPoint, max_step: float) -> float:
    factor = 1.5 if after.cost <= FAST_ITERATIONS else 0.5 if after.cost >= SLOW_ITERATIONS else 1.0
    return min(factor * length, max_step)


def _restart_beyond(
    automaton: HybridAutomaton, point: BranchPoint | None, length: float
) -> BranchPoint | None:
    """The point with its tangent in the direction in which the modes stay the same; None if neither does."""
    for part in length * 0.25 ** np.arange(RESTART_LENGTHS):
        for way in () if point is None else (point, reversed_point(point)):
            ahead = _try_step(automaton, way, float(part))
            if ahead is not None and ahead.modes == way.modes:
                return way
    return None
