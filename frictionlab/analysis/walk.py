"""A walk along a branch of closed orbits: the length of its steps, its ends, what it meets on its way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from frictionlab.automaton import HybridAutomaton

from .arclength import Point, reversed_point, stepped
from .edges import LOST, edge_kind
from .recurrence import Array
from .specials import Found, between

BOUND, MOST, INTERRUPTED, HOPF = "bound", "most orbits", "interrupted", "Hopf"
BRIEF = 64  # parts of the longest step below which a failure is the end of the modes' sequence
HALVINGS = 40  # from there on, until both sides of such an end have met
EASY, HARD = 3, 6  # iterations of Newton's method that make the next step longer, or shorter
AWAY = 5  # lengths tried to get away from such an end, each a quarter of the one before
BEND = 0.3  # largest change of a component of the tangent in a step
FITTED, SPARE = 12, 3  # orbits at most, and more than a polynomial has coefficients at least, to see scatter
SHRUNK = 1e-2  # share of the largest size so far below which an orbit has become an equilibrium


class Walk(NamedTuple):
    """The points and the special points found, in turn, and why it ended."""

    points: list[Point]
    special: list[Found]
    end: str


class Step(NamedTuple):
    """The orbit a step ahead, the length, "bound" where that is there, and at an edge of the modes the orbit
    beyond, if one is found.
    """

    after: Point | None
    length: float
    end: str = ""
    edge: bool = False
    other: Point | None = None


def walk(
    automaton: HybridAutomaton, start: Point, bounds: tuple[float, float], longest: float, most: int
) -> Iterator[Walk]:
    """Follow a branch from a point on, which is left out; yields what it has after every orbit."""
    points: list[Point] = []
    special: list[Found] = []
    point, length, largest = start, longest / 4, start.scale[:-2]
    while len(points) < most:
        step = _next(automaton, point, length, longest, bounds)
        if step.after is not None:
            special += between(automaton, point, step.after, step.length)
            points.append(step.after)
            largest, end = np.maximum(largest, step.after.scale[:-2]), step.end
            if (step.after.scale[:-2] < SHRUNK * largest).all():
                special.append(Found(HOPF, step.after, _vanished([start, *points])))
                end = HOPF
            if end:
                return (yield Walk(points, special, end))
            length = _paced(step.length, step.after, longest)
            point = step.after
        if step.edge:
            kind, ahead = (
                edge_kind(automaton, point, step.other),
                _away(automaton, step.other, longest / BRIEF),
            )
            special += [Found(kind, point, point.value)] if kind != LOST else []
            if ahead is None or not bounds[0] <= ahead.value <= bounds[1]:
                return (yield Walk(points, special, kind))
            point, length = ahead, longest / BRIEF
            points.append(point)
        yield Walk(points, special, MOST)


def _next(
    automaton: HybridAutomaton, point: Point, length: float, longest: float, bounds: tuple[float, float]
) -> Step:
    """The next orbit with the same modes; where there is none at a short distance, the last such."""
    while True:
        at_bound = _at_bound(automaton, point, length, bounds)
        if at_bound is not None:
            return at_bound
        after = _tried(automaton, point, length)
        if _goes_on(point, after):
            return Step(after, length)
        if length < longest / BRIEF or (after is not None and after.modes != point.modes):
            return _edge(automaton, point, length, after)
        length /= 2


def _at_bound(
    automaton: HybridAutomaton, point: Point, length: float, bounds: tuple[float, float]
) -> Step | None:
    """The orbit at a bound, where that is within a length: beyond it there may be no model."""
    speed = point.tangent[-1] * point.scale[-1]
    bound = bounds[int(speed > 0.0)]
    if speed == 0.0 or (bound - point.value) / speed > length:
        return None
    share = (bound - point.value) / speed
    after = _tried(automaton, point, share, bound)
    return Step(after, share, BOUND) if _goes_on(point, after) else None


def _edge(automaton: HybridAutomaton, point: Point, length: float, other: Point | None) -> Step:
    """Where the modes change, or the branch ends, within a length: both sides, by halving it."""
    low, high, last = 0.0, length, None
    other = other if other is not None and other.modes != point.modes else None
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        found = _tried(automaton, point, middle)
        if found is not None and found.modes == point.modes:
            low, last = middle, found
        else:
            high, other = middle, found if found is not None else other
    return Step(last, low, edge=True, other=other)


def _tried(
    automaton: HybridAutomaton, point: Point, length: float, value: float | None = None
) -> Point | None:
    try:
        return stepped(automaton, point, length, value)
    except (ValueError, np.linalg.LinAlgError):
        return None


def _goes_on(point: Point, after: Point | None) -> bool:
    """Whether it is an orbit of the same modes, in line with the one before.

    The tangents are compared in period and parameter only, as the state has been moved along the orbit.
    """
    if after is None or after.modes != point.modes:
        return False
    return bool(np.abs(np.abs(after.tangent[-2:]) - np.abs(point.tangent[-2:])).max() < BEND)


def _vanished(points: list[Point]) -> float:
    """The parameter at which the amplitude comes to zero: near there it is a smooth function of its square.

    A line through the last two orbits would take their rounding to some five times itself.  So lines and
    parabolas are fitted to the last dozen or fewer, and that with the least standard error at zero is taken:
    more orbits mean less rounding, fewer of them less curvature.
    """
    last = [p for p in points[-FITTED:] if p.modes == points[-1].modes]
    size = last[-1].scale[:-2]
    square = np.array([float(np.linalg.norm(p.scale[:-2] / size)) ** 2 for p in last])
    value = np.array([p.value for p in last]) - last[-1].value
    fits = [
        _at_zero(square[-count:], value[-count:], degree)
        for degree in (1, 2)
        for count in range(degree + 1 + SPARE, len(last) + 1)
    ]
    if not fits:
        return float(last[-1].value + np.polyfit(square[-2:], value[-2:], 1)[-1])
    return last[-1].value + min(fits, key=lambda fit: fit[1])[0]


def _at_zero(x: Array, y: Array, degree: int) -> tuple[float, float]:
    """Where a fitted polynomial is at x = 0, and the standard error of that."""
    powers = (x[:, None] / x.max()) ** np.arange(degree + 1)
    inverse = np.linalg.pinv(powers)
    left = y - powers @ (inverse @ y)
    scatter = np.sqrt(left @ left / (len(x) - degree - 1))
    return float(inverse[0] @ y), float(scatter * np.linalg.norm(inverse[0]))


def _paced(length: float, after: Point, longest: float) -> float:
    factor = 1.5 if after.cost <= EASY else 0.5 if after.cost >= HARD else 1.0
    return min(factor * length, longest)


def _away(automaton: HybridAutomaton, point: Point | None, length: float) -> Point | None:
    """The point, pointing to where the modes stay as they are; None where there is no such way."""
    for part in length * 0.25 ** np.arange(AWAY):
        for way in () if point is None else (point, reversed_point(point)):
            ahead = _tried(automaton, way, float(part))
            if ahead is not None and ahead.modes == way.modes:
                return way
    return None
