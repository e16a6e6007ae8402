"""Many runs of one structure at once: the Taylor method, and of each run only its end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictionlab.hybrid import bookkeeping, lanes
from frictionlab.hybrid.affine import is_affine
from frictionlab.hybrid.layout import Numbers
from frictionlab.hybrid.methods import ENDS
from frictionlab.hybrid.natives import LONG
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.progress import Progress
from frictionlab.hybrid.status import Status
from frictionlab.hybrid.taylor import Taylor
from frictionlab.hybrid.under_way import UnderWay, under_way

ROUNDS = 100_000  # steps between two looks at the progress bar and ctrl-C
CODES = {
    **{status: code for code, status in ENDS.items()},
    Status.INTERRUPTED: bookkeeping.RUNNING,
    Status.STEP_CAP: lanes.CAPPED,
    Status.EVENT_CAP: lanes.CAPPED,
}


@dataclass(frozen=True)
class Ends:
    """How runs ended, a row for each.

    Parameters
    ----------
    t : array (N,)
    states : array (N, n)
    modes : int array (N,)
    steps, events : int array (N,)
    status : tuple of Status
    """

    t: np.ndarray
    states: np.ndarray
    modes: np.ndarray
    steps: np.ndarray
    events: np.ndarray
    status: tuple[Status, ...]


def run_all(problems: Sequence[Problem], method: Taylor, progress: Progress) -> Ends:
    """Run problems that share a program to their ends; each as it would run alone, to the last bit."""
    constants, terms = (np.array(rows) for rows in zip(*(problem.numbers for problem in problems)))
    states = np.array([problem.x0 for problem in problems])
    group = under_way(problems[0].program, Numbers(constants, terms), states, method)
    run_on(group, problems[0].t_end, progress)
    return ends(group)


def run_on(group: UnderWay, t_end: float, progress: Progress) -> None:
    """Take runs on to a time; those that ended early stay where they are."""
    runs = group.runs
    goes_on = (runs.status == bookkeeping.RUNNING) | (runs.status == bookkeeping.FINISHED)
    runs.times[goes_on, bookkeeping.END] = t_end
    runs.status[goes_on] = bookkeeping.RUNNING
    if is_affine(group.program):
        return _in_turn(group, np.flatnonzero(goes_on), progress)
    with np.errstate(all="ignore"):
        _side_by_side(group, goes_on, progress)


def _in_turn(group: UnderWay, which: np.ndarray, progress: Progress) -> None:
    """Where a step is a product with a matrix, for each run another, there is nothing to share."""
    runs = group.runs
    for i in which:
        numbers, (now, end) = Numbers(runs.constants[i], runs.terms[i]), runs.times[i, :2]
        raw = group.method.integrate(Problem(group.program, numbers, runs.states[i], end - now), progress)
        runs.states[i], runs.counts[i, bookkeeping.MODE] = raw.state, raw.mode
        runs.times[i, bookkeeping.NOW] = end if raw.status is Status.FINISHED else now + raw.t
        runs.totals[i] += len(raw.step_modes), len(raw.event_times)
        runs.status[i] = CODES[raw.status]


def _side_by_side(group: UnderWay, goes_on: np.ndarray, progress: Progress) -> None:
    runs, program, arrays = group.runs, group.program, (group.record, group.work)
    settings = group.native.code, group.method.degree, group.method.tol
    # Jets that were at hand are so no longer: such a run begins anew.  All do so the first time.
    begins = goes_on & (runs.counts[:, bookkeeping.READY] != 0)
    _line_up(runs, goes_on & ~begins)
    lanes.begin_runs(*settings, runs, np.flatnonzero(begins), program.initial, *arrays)
    left, interrupted, share = True, False, runs.times[:, bookkeeping.NOW]
    while left and not interrupted:
        waiting = np.flatnonzero(runs.queued >= lanes.FEW)  # afterwards there may be nobody left
        left = lanes.advance_runs(*settings, runs, group.seats, *arrays, ROUNDS)
        if runs.totals[:, 0].sum() > LONG:
            group.native.share(waiting.tolist())
        interrupted = progress.update(float(share.mean()))


def _line_up(runs: lanes.Runs, which: np.ndarray) -> None:
    """Have some runs wait, each in the queue of its mode, and nobody else."""
    modes = runs.counts[:, bookkeeping.MODE]
    for mode in range(len(runs.queued)):
        waiting = np.flatnonzero(which & (modes == mode))
        runs.queue[mode, : len(waiting)] = waiting
        runs.queued[mode] = len(waiting)


def ends(group: UnderWay) -> Ends:
    """Where runs stand."""
    runs = group.runs
    status = tuple(_status(int(s), totals, runs.caps) for s, totals in zip(runs.status, runs.totals))
    modes, now = runs.counts[:, bookkeeping.MODE], runs.times[:, bookkeeping.NOW]
    steps, events = runs.totals.T.copy()
    return Ends(now.copy(), runs.states, modes.copy(), steps, events, status)


def _status(status: int, totals: np.ndarray, caps: np.ndarray) -> Status:
    if status == lanes.CAPPED:
        return Status.STEP_CAP if totals[0] >= caps[0] else Status.EVENT_CAP
    return Status.INTERRUPTED if status == bookkeeping.RUNNING else ENDS[status]
