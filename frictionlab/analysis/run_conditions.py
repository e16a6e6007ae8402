"""Whether a run keeps the conditions of its modes, judged by their values alone, without another run.

Nothing of the search for events is used: guards and constraints are computed at many places of the run, dense
in time and in every step, so that an event that all methods step over alike is seen.  At an event that begins
stick, the reset may remove rounding errors only.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array, motion_size
from frictionlab.hybrid.accuracy import largest_sound_defect, worst_conditions
from frictionlab.hybrid.trajectory import Trajectory

TIMES, TIMES_PER_STEP = 20_000, 4  # places at which conditions are computed: in the whole run, in each step
MAX_TIMES = 200_000
# By its multiples the places are spread unevenly, so that no period hides from them.
GOLDEN = 0.6180339887498949
VIOLATION_WITHOUT_TOLERANCE = 1e-6  # share of a condition's size, for methods whose tolerance is not known
STICK_GUARD = "v_r"  # begins the names of the guards whose event makes a relative velocity zero


def broken_condition(run: Trajectory) -> str:
    """Which condition a run breaks, and where; an empty text where it keeps them all."""
    tol = run.description["method"].get("tol")
    limit = VIOLATION_WITHOUT_TOLERANCE if tol is None else largest_sound_defect(tol)
    return _broken_guard(run, limit) or _broken_reset(run, limit)


def _broken_guard(run: Trajectory, limit: float) -> str:
    t = _places(run)
    states, modes = run.states_and_modes(t)
    shares, which = worst_conditions(run.problem, run.raw, states, modes)
    worst = int(np.argmax(shares))
    if not shares[worst] > limit:
        return ""
    first = int(np.argmax(shares > limit))
    mode = run.automaton.mode(run.mode_names[modes[first]])
    missed = [f"event {event.name!r} of mode {mode.name!r} is missed" for event in mode.events]
    broken = [f"a constraint of mode {mode.name!r} is broken" for _ in mode.constraints]
    return (
        f"{(*missed, *broken)[which[first]]}: at t = {t[first]:.6g} s its function is beyond zero, "
        f"in the worst case by {shares[worst]:.1g} of its size"
    )


def _places(run: Trajectory) -> Array:
    """Ascending times all over the run and in every step; of other methods than series the starts of steps,
    as their dense output need not reach across a step."""
    if "tol" not in run.description["method"]:
        return np.unique(run.raw.step_times[:, 0])
    begins, lengths = run.raw.step_times.T
    per_step = min(TIMES_PER_STEP, MAX_TIMES // max(len(begins), 1))
    within = np.arange(1, per_step + 1) * GOLDEN % 1.0
    over = (np.arange(TIMES) + np.arange(TIMES) * GOLDEN % 1.0) / TIMES
    t = np.concatenate([(begins[:, None] + lengths[:, None] * within).ravel(), over * run.raw.t])
    return np.unique(t[t < run.raw.t])


def _broken_reset(run: Trajectory, limit: float) -> str:
    events, n = run.events, run.automaton.coordinates
    begins_stick = np.array([name.startswith(STICK_GUARD) for name in events.guard], dtype=bool)
    jumps: Any = np.abs(events.state - events.before)[:, n : 2 * n] / motion_size(run)[n : 2 * n]
    broken = np.flatnonzero(begins_stick & ~(jumps.max(axis=1, initial=0.0) <= limit))
    if not len(broken):
        return ""
    first = broken[0]
    return (
        f"at t = {events.t[first]:.6g} s the reset of event {str(events.guard[first])!r} takes away "
        f"{jumps[first].max():.1g} of the velocities, more than rounding"
    )
