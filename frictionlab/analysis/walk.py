"""A walk along a branch of closed orbits: the length of its steps, its ends, what it meets on its way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from frictionlab.automaton import HybridAutomaton

from .arclength import Point, reversed_point, stepped
from .specials import Found, between, located

BOUND, LOST, MOST, INTERRUPTED = "bound", "no orbit found", "most orbits", "interrupted"
GRAZING, CHANGE, HOPF = "grazing", "mode change", "Hopf"
BRIEF = 64  # parts of the longest step below which a failure is the end of the modes' sequence
HALVINGS = 30  # from there on, until both sides of such an end have met
EASY, HARD = 3, 6  # iterations of Newton's method that make the next step longer, or shorter
BEND = 0.9  # least cosine between the tangents at both ends of a step
SHRUNK = 1e-3  # share of the largest size so far below which an orbit has become an equilibrium
VANISHING = 1e-3  # share of the period below which a stay is about to vanish


class Walk(NamedTuple):
    """The points and the special points found, in turn, and why it ended."""

    points: list[Point]
    special: list[Found]
    end: str


class Step(NamedTuple):
    """The orbit a step ahead, the length, and where the modes change just after it: what is found there."""

    after: Point | None
    length: float
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
        step = _next(automaton, point, length, longest)
        if step.after is not None:
            after, end = _within(automaton, point, step, bounds)
            special += between(automaton, point, after, step.length)
            points.append(after)
            largest = np.maximum(largest, after.scale[:-2])
            if (after.scale[:-2] < SHRUNK * largest).all():
                special.append(Found(HOPF, after))
                end = HOPF
            if end:
                return (yield Walk(points, special, end))
            length = _paced(step.length, after, longest)
            point = after
        if step.edge:
            special += [Found(_kind(point, step.other), point)] if _kind(point, step.other) != LOST else []
            if step.other is None:
                return (yield Walk(points, special, _kind(point, None)))
            point, length = _away(automaton, step.other, longest / BRIEF), longest / BRIEF
            points.append(point)
        yield Walk(points, special, MOST)


def _next(automaton: HybridAutomaton, point: Point, length: float, longest: float) -> Step:
    """The next orbit with the same modes; where there is none at a short distance, the last such."""
    while True:
        after = _tried(automaton, point, length)
        if after is not None and after.modes == point.modes and _straight(point, after):
            return Step(after, length)
        if length < longest / BRIEF or (after is not None and after.modes != point.modes):
            return _edge(automaton, point, length, after)
        length /= 2


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
    return Step(last, low, True, other)


def _tried(automaton: HybridAutomaton, point: Point, length: float) -> Point | None:
    try:
        return stepped(automaton, point, length)
    except (ValueError, np.linalg.LinAlgError):
        return None


def _straight(point: Point, after: Point) -> bool:
    """Whether the tangents at the ends agree in period and parameter: the state has moved along the orbit."""
    return bool(abs(np.linalg.norm(after.tangent[-2:]) - np.linalg.norm(point.tangent[-2:])) < 1.0 - BEND)


def _within(
    automaton: HybridAutomaton, point: Point, step: Step, bounds: tuple[float, float]
) -> tuple[Point, str]:
    """The orbit after a step, or that at the bound which it passes."""
    low, high = bounds
    passed = low if step.after.value < low else high if step.after.value > high else None
    if passed is None:
        return step.after, ""
    return located(automaton, point, step.length, lambda p: p.value - passed)[0], BOUND


def _paced(length: float, after: Point, longest: float) -> float:
    factor = 1.5 if after.cost <= EASY else 0.5 if after.cost >= HARD else 1.0
    return min(factor * length, longest)


def _away(automaton: HybridAutomaton, point: Point, length: float) -> Point:
    """The point, pointing to where the modes stay as they are."""
    ahead = _tried(automaton, point, length)
    return point if ahead is not None and ahead.modes == point.modes else reversed_point(point)


def _kind(point: Point, other: Point | None) -> str:
    """What happens to the modes after an orbit, by those of the other side or by the stay that vanishes."""
    if other is not None:
        few, many = sorted((len(point.modes), len(other.modes)))
        return GRAZING if many == few + 2 or (few, many) == (1, 2) else CHANGE
    run, period = point.shot.run, point.period
    if not len(run.events):
        return LOST
    stays = np.diff(np.append(run.events.t, run.events.t[0] + period))
    i = int(np.argmin(stays))
    if stays[i] > VANISHING * period:
        return LOST
    return GRAZING if run.events.source[i] == np.roll(run.events.target, -1)[i] else CHANGE
