"""Many runs of one structure at once: the Taylor method, and of each run only its end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictionlab.hybrid import bookkeeping, lanes, step_length
from frictionlab.hybrid.affine import is_affine
from frictionlab.hybrid.buffers import new_record, new_work
from frictionlab.hybrid.methods import ENDS
from frictionlab.hybrid.native_lanes import GUARD_TOL, LOG_TOL, ROWS, TOL, WIDTH
from frictionlab.hybrid.natives import LONG, natives
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.progress import Progress
from frictionlab.hybrid.status import Status
from frictionlab.hybrid.taylor import Taylor

ROUNDS = 100_000  # steps between two looks at the progress bar and ctrl-C


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
    if is_affine(problems[0].program):
        return _in_turn(problems, method, progress)
    with np.errstate(all="ignore"):
        return _side_by_side(problems, method, progress)


def _in_turn(problems: Sequence[Problem], method: Taylor, progress: Progress) -> Ends:
    """Where a step is a product with a matrix, for each run another, there is nothing to share."""
    raws = [method.integrate(problem, progress) for problem in problems]
    steps, events = (
        np.array([len(getattr(raw, name)) for raw in raws]) for name in ("step_modes", "event_times")
    )
    t, states, modes = (np.array([getattr(raw, name) for raw in raws]) for name in ("t", "state", "mode"))
    return Ends(t, states, modes, steps, events, tuple(raw.status for raw in raws))


def _side_by_side(problems: Sequence[Problem], method: Taylor, progress: Progress) -> Ends:
    program, order = problems[0].program, method.degree
    runs, seats = _runs(problems, method), _seats(problems[0], method)
    native, record = natives(program, method.jets, order + 1), new_record(program.code, 1, 2, 0)
    work = new_work(program.slots, program.code, order)
    lanes.begin_runs(native.code, order, method.tol, runs, program.initial, record, work)
    left, interrupted, share = True, False, runs.times[:, bookkeeping.NOW]
    while left and not interrupted:
        left = lanes.advance_runs(native.code, order, method.tol, runs, seats, record, work, ROUNDS)
        if runs.totals[:, 0].sum() > LONG:
            native.share(np.flatnonzero(runs.queued >= lanes.FEW).tolist())
        interrupted = progress.update(float(share.mean()))
    return _ends(runs)


def _runs(problems: Sequence[Problem], method: Taylor) -> lanes.Runs:
    count, code = len(problems), problems[0].program.code
    states, counts = np.array([p.x0 for p in problems]), np.zeros((count, bookkeeping.COUNTS), dtype=np.int64)
    times = np.tile(bookkeeping.times_of(problems[0].t_end, method.limits), (count, 1))
    counts[:, bookkeeping.RAISES] = method.raises
    constants = np.array([p.numbers.constants for p in problems])
    terms = np.array([p.numbers.terms for p in problems])
    return lanes.Runs(
        states=states,
        sizes=np.abs(states),
        times=times,
        counts=counts,
        signs=np.zeros(0, dtype=np.int64),
        constants=constants,
        terms=terms,
        sizes_of_constants=np.abs(constants),
        sizes_of_terms=np.abs(terms),
        totals=np.zeros((count, 2), dtype=np.int64),
        caps=np.array([method.max_steps, method.max_events]),
        status=np.full(count, bookkeeping.RUNNING),
        queue=np.zeros((len(code.flow), count), dtype=np.int64),
        queued=np.zeros(len(code.flow), dtype=np.int64),
    )


def _seats(problem: Problem, method: Taylor) -> lanes.Seats:
    program, control = problem.program, np.zeros((ROWS, WIDTH))
    control[TOL], control[LOG_TOL] = method.tol, np.log2(method.tol)
    control[GUARD_TOL] = method.tol * step_length.SLACK
    return lanes.Seats(
        runs=np.full(WIDTH, lanes.NOBODY),
        z=np.zeros((program.code.inputs, WIDTH)),
        constants=np.zeros((len(problem.numbers.constants), WIDTH)),
        terms=np.zeros((len(problem.numbers.terms), WIDTH)),
        jets=np.zeros((program.slots, method.degree + 1, WIDTH)),
        control=control,
    )


def _ends(runs: lanes.Runs) -> Ends:
    status = tuple(_status(int(s), totals, runs.caps) for s, totals in zip(runs.status, runs.totals))
    modes, now = runs.counts[:, bookkeeping.MODE], runs.times[:, bookkeeping.NOW]
    steps, events = runs.totals.T.copy()
    return Ends(now.copy(), runs.states, modes.copy(), steps, events, status)


def _status(status: int, totals: np.ndarray, caps: np.ndarray) -> Status:
    if status == lanes.CAPPED:
        return Status.STEP_CAP if totals[0] >= caps[0] else Status.EVENT_CAP
    return Status.INTERRUPTED if status == bookkeeping.RUNNING else ENDS[status]
