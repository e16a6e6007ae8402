"""How far a run can be trusted: a warning from the defects of its steps, and the comparison with another run.

The two runs are of the same motion.  They are compared in their events and, between events, in their states.
Events close together (two at once, the last bounces before a Zeno point) count as one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.hybrid.accuracy import defects
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory

SUSPECT_TOLERANCES = 1e4  # times the tolerance: the defects of sound steps are hundreds of times smaller
HARMLESS_DEFECT = 1e-9  # share of the motion's size: smaller than any analysis here resolves
STEPS_PER_MODE = 64  # steps of a mode that are sampled, so that the check costs next to nothing


def defect_warning(run: Trajectory) -> str | None:
    """A warning where steps of a Taylor run are far less exact than its tolerance, else None.

    Some steps are sampled of each mode whose equations are not low-degree polynomials of the states; for
    polynomials the series itself tells how long a step may be.
    """
    tol = run.description.get("method", {}).get("tol")
    if tol is None:
        return None
    code, order = run.problem.program.code, run.samples.order
    modes = [mode for mode in np.unique(run.raw.step_modes) if code.degrees[mode] >= order]
    steps = [_evenly_spread(np.flatnonzero(run.raw.step_modes == mode)) for mode in modes]
    if not steps:
        return None
    return defect_message(defects(run.problem, run.raw, order, np.concatenate(steps)), tol)


def defect_message(defect: Mapping[str, float], tol: float) -> str | None:
    """A warning where a defect is too large for a run with the tolerance `tol`, else None."""
    bad = {mode: size for mode, size in defect.items() if not size <= largest_sound_defect(tol)}
    if not bad:
        return None
    worst = max(bad, key=bad.__getitem__)
    return (
        f"steps in mode {worst!r} are wrong by up to {bad[worst]:.1g} of the motion's size, "
        f"{bad[worst] / tol:.0e} times the tolerance: a law may be too sharp there for its series"
    )


def largest_sound_defect(tol: float) -> float:
    """The defect above which steps of a run with the tolerance `tol` are suspect."""
    return max(SUSPECT_TOLERANCES * tol, HARMLESS_DEFECT)


def _evenly_spread(steps: np.ndarray) -> np.ndarray:
    """Some of the steps, evenly spread."""
    return steps[np.unique(np.linspace(0, len(steps) - 1, STEPS_PER_MODE).astype(int))]


SIMULTANEOUS_SHARE = 1e-5  # share of the longest stay in a mode: events nearer to each other count as one
ACCUMULATION_SHARE = 1e-3  # share of the longest stay: shorter stays before a Zeno point belong to it
END_MARGIN_SHARE = (
    1e-3  # share of the longest stay: this near to the end one run may have an event that the other lacks
)
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


def mode_stays(run: Trajectory, together: float) -> ModeStays:
    """A run's events, where those within `together` seconds of the one before count as one."""
    t, events = run.raw.event_times, run.events
    if not len(t):
        return ModeStays(t, t, events.target, events.closed)
    new = np.diff(t, prepend=-np.inf) > together
    begins = np.flatnonzero(new)
    ends = np.append(begins[1:], len(t)) - 1
    return ModeStays(t[begins], t[ends], events.target[ends], np.logical_or.reduceat(events.closed, begins))


def longest_stay(run: Trajectory, end: float) -> float:
    """The longest time in `run` up to `end` without an event, s."""
    t = run.raw.event_times
    return float(np.diff(t[t < end], prepend=0.0, append=end).max())


def accumulation_time(run: Trajectory) -> float:
    """A time just before the first Zeno accumulation; infinite where there is none.

    It is midway between the last separate event and the first of those close together.
    """
    found = mode_stays(run, ACCUMULATION_SHARE * longest_stay(run, run.raw.t))
    closed = np.flatnonzero(found.closed)
    if not len(closed):
        return np.inf
    i = closed[0]
    return 0.5 * float(found.first[i] + (found.last[i - 1] if i else 0.0))


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
    one, two = mode_stays(run, SIMULTANEOUS_SHARE * longest), mode_stays(other, SIMULTANEOUS_SHARE * longest)
    differs_at = first_event_difference(one, two, end, END_MARGIN_SHARE * longest)
    end = min(end, differs_at)
    taylor = other.description["method"]["name"] == Taylor.name
    t = _comparison_times(two, end) if taylor else other.raw.step_times[:, 0]
    t = t[
        (t <= end)
        & _outside_accumulations(one, t)
        & _outside_accumulations(two, t)
        & (_events_before(one.first, t) == _events_before(two.first, t))
    ]
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


def _comparison_times(found: ModeStays, end: float) -> Array:
    """Times at which states are compared: a grid, and some within every stay."""
    begins = np.append(0.0, found.last)
    lengths = np.append(found.first, end) - begins
    within = (begins[:, None] + lengths[:, None] * SAMPLES_WITHIN_STAY).ravel()
    t = np.unique(np.concatenate([np.linspace(0.0, end, COMPARISON_TIMES + 1), within]))
    return t[t >= 0.0]


def _events_before(first: Array, t: Array) -> Any:
    return np.searchsorted(first, t, side="right")


def _outside_accumulations(found: ModeStays, t: Array) -> Any:
    """Whether a time is outside all groups of events close together."""
    return _events_before(found.first, t) == _events_before(found.last, t)
