"""How far two runs of one motion agree: in their events, and in their states between these."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from frictionlab.hybrid.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory

from .recurrence import Array, sizes
from .returns import groups

TOGETHER = 1e-5  # of the longest stay in a mode: events nearer to each other count as one
PILED = 1e-3  # of it: stays so short that lead to an accumulation belong to it
AT_THE_END = 1e-3  # of the longest stay: so near to the end one run may have an event that the other has not
GRID = 2000  # times at which states are compared, besides some within every stay
WITHIN = np.array([0.1, 0.5, 0.9])
STILL = 1e-6  # of its values: a motion of less is measured by this much of them


class Agreement(NamedTuple):
    """Whether two runs agree.

    Parameters
    ----------
    error : float
        Largest deviation up to `until`, as a share of the motion's size.
    until : float
        s: up to where they were compared, or came apart.
    parted : float
        s: the first event in which they differ; infinite where there is none.
    """

    error: float
    until: float
    parted: float


class Stays(NamedTuple):
    """Events, those close together as one: when the first and the last of them happen, the mode entered,
    whether an accumulation was closed."""

    first: Array
    last: Array
    mode: Array
    closed: Array


def sizes_of(run: Trajectory, samples: int | None = None) -> Array:
    """Size of a motion, or of its first `samples`, in each state: the largest range in its group.

    Groups are coordinates, velocities, others.
    """
    states = run.states[:samples]  # within steps too: at the events of dry friction all velocities are zero
    ranges, values = sizes(states), np.abs(states).max(axis=0)
    for group in groups(run.automaton.coordinates):
        largest = max(ranges[group].max(initial=0.0), STILL * values[group].max(initial=0.0))
        ranges[group] = largest or 1.0
    return ranges


def stays(run: Trajectory, together: float) -> Stays:
    """A run's events, where those within `together` seconds of the one before count as one."""
    t, events = run.raw.event_times, run.events
    if not len(t):
        return Stays(t, t, events.target, events.closed)
    new = np.diff(t, prepend=-np.inf) > together
    begins = np.flatnonzero(new)
    ends = np.append(begins[1:], len(t)) - 1
    return Stays(t[begins], t[ends], events.target[ends], np.logical_or.reduceat(events.closed, begins))


def longest_stay(run: Trajectory, end: float) -> float:
    """The longest time in `run` up to `end` without an event, s."""
    t = run.raw.event_times
    return float(np.diff(t[t < end], prepend=0.0, append=end).max())


def pile_up(run: Trajectory) -> float:
    """Time between the last event by itself and the first that pile up; infinite where none do."""
    found = stays(run, PILED * longest_stay(run, run.raw.t))
    closed = np.flatnonzero(found.closed)
    if not len(closed):
        return np.inf
    i = closed[0]
    return 0.5 * float(found.first[i] + (found.last[i - 1] if i else 0.0))


def agreement(
    run: Trajectory, other: Trajectory, size: Array, most: float, until: float = np.inf
) -> Agreement:
    """Compare two runs up to `until`, to an event in which they differ, or to a deviation beyond `most`.

    Of other methods than Taylor's `other` is looked at where its steps begin: between these the series that
    stand for it may not converge, however exact it is.
    """
    end = min(until, run.raw.t, other.raw.t)
    if not end > 0.0:
        return Agreement(0.0, 0.0, np.inf)
    longest = longest_stay(other, end)
    one, two = stays(run, TOGETHER * longest), stays(other, TOGETHER * longest)
    parted = first_difference(one, two, end, AT_THE_END * longest)
    end = min(end, parted)
    taylor = other.description["method"]["name"] == Taylor.name
    t = _times(two, end) if taylor else other.raw.step_times[:, 0]
    t = t[(t <= end) & _between(one, t) & _between(two, t) & (_count(one.first, t) == _count(two.first, t))]
    deviation = np.abs((run(t) - other(t)) / size).max(axis=1, initial=0.0)
    beyond = np.flatnonzero(~(deviation <= most))
    if len(beyond):
        return Agreement(float(deviation[: beyond[0]].max(initial=0.0)), float(t[beyond[0]]), parted)
    return Agreement(float(deviation.max(initial=0.0)), end, parted)


def first_difference(one: Stays, two: Stays, end: float, late: float) -> float:
    """When two runs first have different events before `end`; infinite where they have the same.

    Events number k of both are the same where they lead to the same mode, and each comes before number
    k + 1 of the other: so it is noted if two are missing and all others look alike.
    """
    n = min(len(one.first), len(two.first))
    earlier = np.minimum(one.first[:n], two.first[:n])
    differs = one.mode[:n] != two.mode[:n]
    for a, b in ((one.first, two.first), (two.first, one.first)):
        differs |= a[:n] >= np.append(b, [np.inf, np.inf])[1 : n + 1]
    further = np.concatenate([one.first[n:], two.first[n:]])
    times = np.concatenate([earlier[differs], further])
    return float(times[times < end - late].min(initial=np.inf))


def _times(found: Stays, end: float) -> Array:
    """Times at which states are compared: a grid, and some within every stay."""
    begins = np.append(0.0, found.last)
    lengths = np.append(found.first, end) - begins
    within = (begins[:, None] + lengths[:, None] * WITHIN).ravel()
    t = np.unique(np.concatenate([np.linspace(0.0, end, GRID + 1), within]))
    return t[t >= 0.0]


def _count(first: Array, t: Array) -> Any:
    return np.searchsorted(first, t, side="right")


def _between(found: Stays, t: Array) -> Any:
    """Whether no events that are close together are under way."""
    return _count(found.first, t) == _count(found.last, t)
