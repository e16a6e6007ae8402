"""The comparison of a run with another one.

The two runs are of the same motion.  They are compared in their events and, between events, in their states.
Events close together (two at once, the last bounces before a Zeno point) count as one.  Impacts of bodies
that as good as rest beside each other do not count: whether they touch is rounding.  Nor does which of two
contacts holds a velocity that both could hold, as the feet of a rigid body do.  Once nothing moves any more,
events do not count: a mass that comes to rest on bristles vibrates on by rounding errors.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from frictionlab.analysis.motion_scales import Array, motion_size
from frictionlab.analysis.run_conditions import is_of_series
from frictionlab.hybrid.guard_bounds import Tape
from frictionlab.hybrid.trajectory import Trajectory

SIMULTANEOUS_SHARE = 1e-5  # share of the longest stay in a mode: events nearer to each other count as one
ACCUMULATION_SHARE = 1e-3  # share of the longest stay: shorter stays before a Zeno point belong to it
# share of the longest stay: this near to the end one run may have an event that the other lacks
END_MARGIN_SHARE = 1e-3
# share of the rates' terms by which two modes that move alike may differ: the same for all methods, as
# one run would else tell modes apart that count as one in the other
ALIKE_SHARE = 1e-9
# share of the motion's size: an impact that changes no state by this does not count, nor does an event after
# which no state changes by this any more
LEAST_JUMP = 1e-8
COMPARISON_TIMES = 2000  # times at which states are compared, in addition to some within every stay
SAMPLES_WITHIN_STAY = np.array([0.1, 0.5, 0.9])


class RunComparison(NamedTuple):
    """Whether two runs agree.

    Parameters
    ----------
    error : float
        Largest deviation up to `until`, as a share of the motion's size.
    until : float
        s: time up to which they were compared, or agreed.
    differs_at : float
        s: the first event in which they differ; infinite where there is none.
    """

    error: float
    until: float
    differs_at: float


class ModeStays(NamedTuple):
    """Groups of events close together, each of which counts as one event.

    For each group: times of its first and of its last event, the mode entered by the last, and whether one of
    them closed a Zeno accumulation.
    """

    first: Array
    last: Array
    mode: Array
    closed: Array


def mode_stays(run: Trajectory, together: float, size: Array, other: Trajectory | None = None) -> ModeStays:
    """A run's events, where those within `together` seconds of the one before count as one.

    Modes that are one motion in the run have one name, also those of an `other` run.  `size` is that of the
    motion in each state.
    """
    events, modes = run.events, _modes_by_motion(run, run if other is None else other)
    jumps = (np.abs(events.state - events.before) / size).max(axis=1, initial=0.0)
    counts = (jumps > LEAST_JUMP) | (modes[:-1] != modes[1:]) | events.closed
    t, target, closed = events.t[counts], modes[1:][counts], events.closed[counts]
    if not len(t):
        return ModeStays(t, t, target, closed)
    begins = np.flatnonzero(np.diff(t, prepend=-np.inf) > together)
    ends = np.append(begins[1:], len(t)) - 1
    return ModeStays(t[begins], t[ends], target[ends], np.logical_or.reduceat(closed, begins))


def _modes_by_motion(run: Trajectory, other: Trajectory) -> Any:
    """The mode of each stay between events: of modes that hold the same and move alike there the first name.

    Modes are those that one of the runs comes to.
    """
    first = run.mode_names[np.append(run.raw.step_modes, run.raw.mode)[0]]
    modes = np.append(first, run.events.target).astype(object)
    t = np.concatenate([[0.0], run.events.t, [run.raw.t]])
    for tapes in _tapes_by_constraints(run, other):
        names, stays = np.array([*tapes], dtype=object), np.flatnonzero(np.isin(modes, [*tapes]))
        within = t[stays, None] + np.diff(t)[stays, None] * SAMPLES_WITHIN_STAY
        states = run(within.ravel())
        rates = np.array([tape.values(states, tape.flow) for tape in tapes.values()])
        sizes = np.array([tape.magnitudes(states, tape.flow) for tape in tapes.values()])
        own = np.searchsorted(names, modes[stays]).repeat(within.shape[1]), np.arange(len(states))
        alike: Any = (np.abs(rates - rates[own]) <= ALIKE_SHARE * sizes[own]).all(axis=-1)
        alike[own] = True  # also where its rates are not finite
        modes[stays] = names[alike.reshape(len(names), *within.shape).all(axis=-1).argmax(axis=0)]
    return modes


def _tapes_by_constraints(*runs: Trajectory) -> list[dict[str, Tape]]:
    """Modes of runs that have constraints, by ascending names: groups of two and more with the same ones."""
    groups: dict[Any, dict[str, Tape]] = {}
    for run in runs:
        problem = run.problem
        for number in np.unique(run.raw.step_modes):
            name = run.mode_names[number]
            if held := frozenset(run.automaton.mode(name).constraints):
                tape = Tape(problem.program.code, problem.numbers, int(number))
                groups.setdefault(held, {})[name] = tape
    return [dict(sorted(tapes.items())) for tapes in groups.values() if len(tapes) > 1]


def longest_stay(run: Trajectory, end: float) -> float:
    """The longest time in `run` up to `end` without an event, s."""
    t = run.raw.event_times
    return float(np.diff(t[t < end], prepend=0.0, append=end).max())


def standstill_time(run: Trajectory, size: Array) -> float:
    """The end of the last step at whose start a state differs visibly from that at the end of the run, s;
    infinite where that is the last step, or nothing moves at all."""
    apart = np.abs(run.raw.step_states[:, : len(size)] - run.final_state) / size
    moving = np.flatnonzero((apart > LEAST_JUMP).any(axis=1))
    if not len(moving) or moving[-1] == len(apart) - 1:
        return np.inf
    return float(run.raw.step_times[moving[-1]].sum())


def accumulation_time(run: Trajectory) -> float:
    """A time just before the first Zeno accumulation; infinite where there is none.

    It is midway between the last separate event and the first of those close together.
    """
    stays = mode_stays(run, ACCUMULATION_SHARE * longest_stay(run, run.raw.t), motion_size(run))
    closed = np.flatnonzero(stays.closed)
    if not len(closed):
        return np.inf
    i = closed[0]
    return 0.5 * float(stays.first[i] + (stays.last[i - 1] if i else 0.0))


def compare_runs(
    run: Trajectory, other: Trajectory, size: Array, max_deviation: float, until: float = np.inf
) -> RunComparison:
    """Compare two runs up to `until`, to an event that differs, or to a deviation beyond `max_deviation`.

    A run `other` by another method than Taylor is compared at the starts of its steps only: between these its
    dense output, a series, may not converge, however exact the run is.
    """
    end = min(until, run.raw.t, other.raw.t)
    if not end > 0.0:
        return RunComparison(0.0, 0.0, np.inf)
    longest = longest_stay(other, end)
    together = SIMULTANEOUS_SHARE * longest
    one, two = mode_stays(run, together, size, other), mode_stays(other, together, size, run)
    still = min(end, standstill_time(run, size), standstill_time(other, size))
    differs_at = first_event_difference(one, two, still, END_MARGIN_SHARE * longest)
    end = min(end, differs_at)
    t = _comparison_times(two, end) if is_of_series(other) else other.raw.step_times[:, 0]
    apart = (
        _between_events(one, t, together)
        & _between_events(two, t, together)
        & (_events_before(one.first, t) == _events_before(two.first, t))
    )
    t = t[(t <= end) & (apart | (t > still))]
    deviation = np.abs((run(t) - other(t)) / size).max(axis=1, initial=0.0)
    beyond = np.flatnonzero(~(deviation <= max_deviation))
    if len(beyond):
        return RunComparison(float(deviation[: beyond[0]].max(initial=0.0)), float(t[beyond[0]]), differs_at)
    return RunComparison(float(deviation.max(initial=0.0)), end, differs_at)


def first_event_difference(one: ModeStays, two: ModeStays, end: float, late: float) -> float:
    """Time at which two runs first have different events before `end`; infinite where they have the same.

    The k-th events of both runs are the same if they lead to the same mode and each comes before event k + 1
    of the other run; so two missing events are noticed even if all others are alike.  Differences within
    `late` seconds of `end` do not count.
    """
    n = min(len(one.first), len(two.first))
    earlier = np.minimum(one.first[:n], two.first[:n])
    differs = one.mode[:n] != two.mode[:n]
    for a, b in ((one.first, two.first), (two.first, one.first)):
        differs |= a[:n] >= np.append(b, [np.inf, np.inf])[1 : n + 1]
    further = np.concatenate([one.first[n:], two.first[n:]])
    times = np.concatenate([earlier[differs], further])
    return float(times[times < end - late].min(initial=np.inf))


def _comparison_times(stays: ModeStays, end: float) -> Array:
    """Times at which states are compared: a grid, and some within every stay."""
    begins = np.append(0.0, stays.last)
    lengths = np.append(stays.first, end) - begins
    within = (begins[:, None] + lengths[:, None] * SAMPLES_WITHIN_STAY).ravel()
    t = np.unique(np.concatenate([np.linspace(0.0, end, COMPARISON_TIMES + 1), within]))
    return t[t >= 0.0]


def _events_before(first: Array, t: Array) -> Any:
    return np.searchsorted(first, t, side="right")


def _between_events(stays: ModeStays, t: Array, near: float) -> Any:
    """Whether a time is neither `near` an event nor within a group of events that count as one."""
    return _events_before(stays.first - near, t) == _events_before(stays.last + near, t)
