"""The continuation driver: step lengths along a branch of periodic orbits, its ends, the special points
between.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.automaton import HybridAutomaton

from .branch_ends import NO_ORBIT, branch_end_kind
from .pseudo_arclength import BranchPoint, continuation_step, reversed_point
from .special_points import SpecialPoint, special_points_between

BOUND, MAX_POINTS, INTERRUPTED, HOPF = "bound", "most orbits", "interrupted", "Hopf"
SHORTEST_STEP_PARTS = 64  # parts of the longest step below which a failure is the end of the modes' sequence
END_BISECTIONS = 40  # from there on, until both sides of such an end have met
FAST_ITERATIONS, SLOW_ITERATIONS = (
    3,
    6,
)  # iterations of Newton's method that make the next step longer, or shorter
RESTART_LENGTHS = 5  # lengths tried to get away from such an end, each a quarter of the one before
MAX_TANGENT_CHANGE = 0.3  # largest change of a component of the tangent in a step
HOPF_FIT_POINTS, HOPF_FIT_SPARE = (
    12,
    3,
)  # orbits at most, and more than a polynomial has coefficients at least, to see scatter
HOPF_SIZE_RTOL = 1e-2  # share of the largest size so far below which an orbit has become an equilibrium


class BranchHalf(NamedTuple):
    """The points and the special points found, in turn, and why it ended."""

    points: list[BranchPoint]
    special: list[SpecialPoint]
    end: str


class BranchStep(NamedTuple):
    """The orbit a step ahead, the length, "bound" where that is there, and at an edge of the modes the orbit
    beyond, if one is found.
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
    """Follow a branch from a point on, which is left out; yields what it has after every orbit."""
    points: list[BranchPoint] = []
    special: list[SpecialPoint] = []
    point, length, largest = start, max_step / 4, start.scale[:-2]
    while len(points) < max_points:
        step = _next_step(automaton, point, length, max_step, bounds)
        if step.after is not None:
            special += special_points_between(automaton, point, step.after, step.length)
            points.append(step.after)
            largest, end = np.maximum(largest, step.after.scale[:-2]), step.end
            if (step.after.scale[:-2] < HOPF_SIZE_RTOL * largest).all():
                special.append(SpecialPoint(HOPF, step.after, _hopf_value([start, *points])))
                end = HOPF
            if end:
                return (yield BranchHalf(points, special, end))
            length = _next_length(step.length, step.after, max_step)
            point = step.after
        if step.edge:
            kind, ahead = (
                branch_end_kind(automaton, point, step.other),
                _restart_beyond(automaton, step.other, max_step / SHORTEST_STEP_PARTS),
            )
            special += [SpecialPoint(kind, point, point.value)] if kind != NO_ORBIT else []
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
    """The next orbit with the same modes; where there is none at a short distance, the last such."""
    while True:
        at_bound = _step_to_bound(automaton, point, length, bounds)
        if at_bound is not None:
            return at_bound
        after = _try_step(automaton, point, length)
        if _continues(point, after):
            return BranchStep(after, length)
        if length < max_step / SHORTEST_STEP_PARTS or (after is not None and after.modes != point.modes):
            return _locate_mode_change(automaton, point, length, after)
        length /= 2


def _step_to_bound(
    automaton: HybridAutomaton, point: BranchPoint, length: float, bounds: tuple[float, float]
) -> BranchStep | None:
    """The orbit at a bound, where that is within a length: beyond it there may be no model."""
    speed = point.tangent[-1] * point.scale[-1]
    bound = bounds[int(speed > 0.0)]
    if speed == 0.0 or (bound - point.value) / speed > length:
        return None
    share = (bound - point.value) / speed
    after = _try_step(automaton, point, share, bound)
    return BranchStep(after, share, BOUND) if _continues(point, after) else None


def _locate_mode_change(
    automaton: HybridAutomaton, point: BranchPoint, length: float, other: BranchPoint | None
) -> BranchStep:
    """Where the modes change, or the branch ends, within a length: both sides, by halving it."""
    low, high, last = 0.0, length, None
    other = other if other is not None and other.modes != point.modes else None
    for _ in range(END_BISECTIONS):
        middle = (low + high) / 2
        found = _try_step(automaton, point, middle)
        if found is not None and found.modes == point.modes:
            low, last = middle, found
        else:
            high, other = middle, found if found is not None else other
    return BranchStep(last, low, edge=True, other=other)


def _try_step(
    automaton: HybridAutomaton, point: BranchPoint, length: float, value: float | None = None
) -> BranchPoint | None:
    try:
        return continuation_step(automaton, point, length, value)
    except (ValueError, np.linalg.LinAlgError):
        return None


def _continues(point: BranchPoint, after: BranchPoint | None) -> bool:
    """Whether it is an orbit of the same modes, in line with the one before.

    The tangents are compared in period and parameter only, as the state has been moved along the orbit.
    """
    if after is None or after.modes != point.modes:
        return False
    return bool(np.abs(np.abs(after.tangent[-2:]) - np.abs(point.tangent[-2:])).max() < MAX_TANGENT_CHANGE)


def _hopf_value(points: list[BranchPoint]) -> float:
    """The parameter at which the amplitude comes to zero: near there it is a smooth function of its square.

    A line through the last two orbits would take their rounding to some five times itself.  So lines and
    parabolas are fitted to the last dozen or fewer, and that with the least standard error at zero is taken:
    more orbits mean less rounding, fewer of them less curvature.
    """
    last = [p for p in points[-HOPF_FIT_POINTS:] if p.modes == points[-1].modes]
    size = last[-1].scale[:-2]
    square = np.array([float(np.linalg.norm(p.scale[:-2] / size)) ** 2 for p in last])
    value = np.array([p.value for p in last]) - last[-1].value
    fits = [
        _fit_at_zero(square[-count:], value[-count:], degree)
        for degree in (1, 2)
        for count in range(degree + 1 + HOPF_FIT_SPARE, len(last) + 1)
    ]
    if not fits:
        return float(last[-1].value + np.polyfit(square[-2:], value[-2:], 1)[-1])
    return last[-1].value + min(fits, key=lambda fit: fit[1])[0]


def _fit_at_zero(x: Array, y: Array, degree: int) -> tuple[float, float]:
    """Where a fitted polynomial is at x = 0, and the standard error of that."""
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
    """The point, pointing to where the modes stay as they are; None where there is no such way."""
    for part in length * 0.25 ** np.arange(RESTART_LENGTHS):
        for way in () if point is None else (point, reversed_point(point)):
            ahead = _try_step(automaton, way, float(part))
            if ahead is not None and ahead.modes == way.modes:
                return way
    return None
