"""Many runs of one structure at once, by the Taylor method; only the end of each run is kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictionlab.hybrid.codegen.native_cache import COMPILE_AFTER
from frictionlab.hybrid.ensemble import lanes
from frictionlab.hybrid.ensemble.arrays import Batch, BatchRuns, new_batch
from frictionlab.hybrid.kernels import run_state
from frictionlab.hybrid.methods.base import STATUS_OF_CODE
from frictionlab.hybrid.methods.taylor import Taylor, is_affine, longest_step
from frictionlab.hybrid.problem import Problem, Status
from frictionlab.hybrid.real_powers import cut_where_undefined
from frictionlab.hybrid.variational.tangent_jets import state_on_constraints, states_on_constraints
from frictionlab.interruption import Progress
from frictionlab.presentation import Drawable, count, span, tally
from frictionlab.tape.program import Numbers, Program

STEPS_PER_ROUND = 100_000  # steps between two updates of the progress bar, which check for ctrl-C
MEMORY_CAPPED = lanes.CAPPED - 1  # the status of a run, advanced alone, whose steps would fill the memory
CODE_OF_STATUS = {
    **{status: code for code, status in STATUS_OF_CODE.items()},
    Status.INTERRUPTED: run_state.RUNNING,
    Status.STEP_CAP: lanes.CAPPED,
    Status.EVENT_CAP: lanes.CAPPED,
    Status.MEMORY_CAP: MEMORY_CAPPED,
}


@dataclass(frozen=True)
class BatchResult(Drawable):
    """How runs ended, a row for each.

    Parameters
    ----------
    t : array (N,)
    states : array (N, n)
    modes : int array (N,)
        Indices into `mode_names`; -1 where a run has no mode.
    steps, events : int array (N,)
    status : tuple of Status
    names, units : tuple of str
        Names of the states, and their units, "" where they are not known.
    mode_names, cyclic : tuple of str
        Names of the modes, and of the coordinates that may turn for ever.
    """

    drawn_by = "plot_ends"

    t: np.ndarray
    states: np.ndarray
    modes: np.ndarray
    steps: np.ndarray
    events: np.ndarray
    status: tuple[Status, ...]
    names: tuple[str, ...] = ()
    mode_names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    cyclic: tuple[str, ...] = ()

    def __repr__(self) -> str:
        ends = tally(status.name.lower().replace("_", " ") for status in self.status)
        return f"BatchResult({count(len(self.t), 'run')} up to {span(self.t)} s: {ends})"


def integrate_batch(problems: Sequence[Problem], method: Taylor, progress: Progress) -> BatchResult:
    """Run problems that share a program to their ends; each as it would run alone, to the last bit."""
    group = new_batch(problems, method)
    advance_batch(group, problems[0].t_end, progress)
    return batch_result(group)


def advance_batch(group: Batch, t_end: float, progress: Progress) -> None:
    """Advance runs to a time; those that ended early keep their state."""
    runs = group.runs
    goes_on = (runs.status == run_state.RUNNING) | (runs.status == run_state.FINISHED)
    runs.times[goes_on, run_state.END] = t_end
    runs.status[goes_on] = run_state.RUNNING
    if group.alone or not takes_lanes(group.program, group.order, t_end):
        return _advance_one_by_one(group, np.flatnonzero(goes_on), progress)
    changing = "states", "times", "counts", "totals"
    before = runs._replace(**{name: getattr(runs, name).copy() for name in changing})
    with np.errstate(all="ignore"):
        _advance_side_by_side(group, goes_on, progress)
    _cut_where_undefined(group, before, progress)


def takes_lanes(program: Program, order: int, t_end: float) -> bool:
    """Whether runs of a program step in lanes.

    They do not where a step is a product with the run's own matrix, nor beyond the longest step of the order.
    """
    return not (is_affine(program) or t_end > longest_step(order))


def _advance_one_by_one(group: Batch, which: np.ndarray, progress: Progress) -> None:
    """Advance each run alone, as where modes are derived on demand."""
    runs = group.runs
    for i in which:
        now, end = runs.times[i, :2]
        problem = _problem_of_run(group, i, end - now)
        raw = group.method.integrate(problem, group.order, progress)
        raw = cut_where_undefined(problem.with_derived_modes(), raw)
        runs.states[i], runs.counts[i, run_state.MODE] = raw.state, raw.mode
        runs.times[i, run_state.NOW] = end if raw.status is Status.FINISHED else now + raw.t
        runs.totals[i] += len(raw.step_modes), len(raw.event_times)
        runs.status[i] = CODE_OF_STATUS[raw.status]


def _cut_where_undefined(group: Batch, before: BatchRuns, progress: Progress) -> None:
    """End runs where the base of a power became negative, as single runs end; `before` is where they were.

    Such a run is computed again alone, with a record of its steps.
    """
    runs = group.runs
    for i in np.flatnonzero(runs.undefined):
        now, end = before.times[i, :2]
        begins = before.counts[i, run_state.JETS_READY] != 0
        mode = None if begins else int(before.counts[i, run_state.MODE])
        numbers = Numbers(runs.constants[i], runs.terms[i])
        limit = float(before.times[i, run_state.CHATTER])
        problem = Problem(group.program, numbers, before.states[i], end - now, mode, chatter=limit)
        raw = group.method.integrate(problem, group.order, progress)
        cut = cut_where_undefined(problem, raw)
        if cut is not raw:
            runs.states[i], runs.counts[i, run_state.MODE] = cut.state, cut.mode
            runs.times[i, run_state.NOW] = now + cut.t
            runs.totals[i] = before.totals[i] + (len(cut.step_modes), len(cut.event_times))
            runs.status[i] = CODE_OF_STATUS[cut.status]
    runs.undefined[:] = 0


def _problem_of_run(group: Batch, i: int, duration: float) -> Problem:
    """A run from its present state on."""
    state = group.runs.states[i]
    if group.alone:
        return group.alone[i]._replace(x0=state, t_end=duration)
    return Problem(group.program, Numbers(group.runs.constants[i], group.runs.terms[i]), state, duration)


def _advance_side_by_side(group: Batch, goes_on: np.ndarray, progress: Progress) -> None:
    runs, program, arrays = group.runs, group.program, (group.record, group.scratch)
    settings = group.native.code, run_state.Truncation(group.order, group.method.tol)
    begins = goes_on & (runs.counts[:, run_state.JETS_READY] != 0)
    _fill_queues(runs, goes_on & ~begins)
    lanes.begin_runs(*settings, runs, np.flatnonzero(begins), program.initial, group.scratch)
    left, interrupted, share = True, False, runs.times[:, run_state.NOW]
    while left and not interrupted:
        # Before the call, which may leave no run waiting.
        waiting = np.flatnonzero(runs.queued >= lanes.MIN_RUNS_FOR_LANES)
        left = lanes.advance_batch_kernel(*settings, runs, group.lanes, *arrays, STEPS_PER_ROUND)
        if runs.totals[:, 0].sum() > COMPILE_AFTER:
            group.native.share(waiting.tolist())
        interrupted = progress.update(float(share.mean()))


def _fill_queues(runs: BatchRuns, which: np.ndarray) -> None:
    """Fill the queues of the modes with the runs `which`, and no others."""
    modes = runs.counts[:, run_state.MODE]
    for mode in range(len(runs.queued)):
        waiting = np.flatnonzero(which & (modes == mode))
        runs.queue[mode, : len(waiting)] = waiting
        runs.first[mode], runs.queued[mode] = 0, len(waiting)


def batch_result(group: Batch) -> BatchResult:
    """The present state of all runs."""
    runs = group.runs
    status = tuple(_status(int(s), totals, runs.caps) for s, totals in zip(runs.status, runs.totals))
    modes, now = runs.counts[:, run_state.MODE], runs.times[:, run_state.NOW]
    steps, events = runs.totals.T.copy()
    states = _final_states(group, status)
    return BatchResult(now.copy(), states, modes.copy(), steps, events, status)


def _final_states(group: Batch, status: Sequence[Status]) -> np.ndarray:
    """Those of single runs, which are on the constraints of their modes."""
    runs, program = group.runs, group.program
    states, modes = runs.states.copy(), runs.counts[:, run_state.MODE]
    ended = np.array([how.ok for how in status])
    if group.alone:
        for i in np.flatnonzero(ended).tolist():
            problem = _problem_of_run(group, i, 0.0).with_derived_modes()
            states[i] = state_on_constraints(problem.program, problem.numbers, int(modes[i]), states[i])
        return states
    for mode in np.unique(modes[ended]):
        some = ended & (modes == mode)
        numbers = Numbers(runs.constants[some], runs.terms[some])
        states[some] = states_on_constraints(program, numbers, int(mode), states[some])
    return states


def _status(status: int, totals: np.ndarray, caps: np.ndarray) -> Status:
    if status == lanes.CAPPED:
        return Status.STEP_CAP if totals[0] >= caps[0] else Status.EVENT_CAP
    if status == MEMORY_CAPPED:
        return Status.MEMORY_CAP
    return Status.INTERRUPTED if status == run_state.RUNNING else STATUS_OF_CODE[status]
