"""`fl.ensemble`: many runs at once, of which only the final states are kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import wait
from dataclasses import replace
from typing import Any

import numpy as np

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.options import Execution
from frictionlab.analysis.sweeps.tasks import IN_TASK, thread_count, worker_threads
from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.modes_on_demand import ModeNames
from frictionlab.compilation.decorators import needs_compilation
from frictionlab.hybrid.chatter_limit import with_chatter_limit
from frictionlab.hybrid.codegen.jet_codegen import lane_count
from frictionlab.hybrid.ensemble.arrays import Batch, new_batch
from frictionlab.hybrid.ensemble.batch import (
    BatchResult,
    advance_batch,
    batch_result,
    integrate_batch,
    takes_lanes,
)
from frictionlab.hybrid.ensemble.lanes import advance_batch_kernel
from frictionlab.hybrid.kernels.run_state import NOW
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Problem, Status
from frictionlab.hybrid.real_powers import undefined_start
from frictionlab.hybrid.solve import method_of, problem_of
from frictionlab.interruption import POLL_TIME, Progress, interruption
from frictionlab.models.model import ModelOrAutomaton, automaton_of
from frictionlab.presentation import unit_of_state
from frictionlab.tape.arguments import check_automaton
from frictionlab.tape.packing import program_of
from frictionlab.validation import abbreviate, check_t_end, explains_keywords, is_sequence

__all__ = ["BatchResult", "ensemble"]

MOST_MODES_IN_LANES = 81  # those of four contacts; deriving more takes longer than lanes save


@explains_keywords
def ensemble(
    models: Sequence[ModelOrAutomaton],
    t_end: float,
    *,
    x0: Any = "rest",
    method: str | Taylor = "taylor",
    workers: int | None = None,
    progress: bool = True,
) -> BatchResult:
    """Run many models of one structure from 0 to `t_end`, side by side.

    Runs that are in the same mode take their steps together, as lanes of vector instructions.  The runs are
    shared out to threads, which compute in parallel.  Each run takes the steps that it would take in
    :func:`simulate`, to the last bit, whatever the others do.  Only the final states are kept.

    Parameters
    ----------
    models : sequence of Model or HybridAutomaton
        With the same laws and interface; their parameters may differ.  For many initial states repeat one
        model: ``[model] * 100``.
    t_end : float
        End time in seconds, positive.
    x0 : "rest", "near", mapping, array_like (2n,) or (N, 2n), or a sequence of the former
        One initial state for all runs, or one for each.
    method : "taylor" or Taylor
    workers : int or None
        Number of threads.  None takes one for each processor, but no more than have full lanes; within a
        task of a sweep, whose workers have the processors, a single one.
    progress : bool

    Returns
    -------
    BatchResult
        Also if some runs ended early: see ``status``.

    Raises
    ------
    TypeError
        Where `models` is no sequence of models.
    ValueError
        For other bad arguments.  Both are raised before any run starts, but for a start where a law has no
        real value.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the BatchResult as far as the runs had come.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt().without("geometry")
    >>> ends = fl.ensemble([model.replace(mu_k=mu) for mu in (0.5, 1.0, 1.5)], 2.0, progress=False)
    >>> ends.states.shape
    (3, 8)
    """
    execution = Execution(workers=workers, progress=progress)
    solver = method_of(method)
    if not isinstance(solver, Taylor):
        raise ValueError(
            f"method must be 'taylor' or a Taylor, got {abbreviate(method)}: use fl.sweep for others"
        )
    t_end = check_t_end(t_end, "give the length of the runs in seconds")
    if not is_sequence(models):
        raise TypeError(
            f"models must be a sequence of models, got {abbreviate(models)}: write [model], or [model] * 100"
        )
    models = list(models)
    if not models:
        raise ValueError("models must hold at least one model, got none: give those that are to be run")
    problems = _problems(models, x0, float(t_end), solver)
    for i, problem in enumerate(problems):
        if problem.program is not problems[0].program:
            raise ValueError(
                f"models must share their laws and interface, models[{i}] differs from models[0]: "
                "call ensemble for each kind, or use fl.sweep"
            )
    with Progress(t_end, progress, needs_compilation(advance_batch_kernel)) as bar:
        ends = _run_in_threads(problems, solver, execution, bar)
    for i in np.flatnonzero((ends.steps == 0) & (np.array(ends.status) == Status.NOT_FINITE)):
        if words := undefined_start(automaton_of(models[i]), problems[i], int(ends.modes[i])):
            raise ValueError(f"x0 of models[{i}] {words}")
    first = automaton_of(models[0])
    modes = problem_for_batch(first, problems[0].x0, 0.0, solver).program.modes
    units = tuple(unit_of_state(models[0], name) for name in first.state_names)
    names = {"names": first.state_names, "mode_names": modes, "cyclic": first.cyclic}
    result = replace(ends, units=units, **names)
    if bar.stopped:
        raise interruption(f"the ensemble was stopped at {result.t.mean():g} of {t_end:g} s", result)
    return result


def _run_in_threads(
    problems: Sequence[Problem], method: Taylor, execution: Execution, bar: Progress
) -> BatchResult:
    """Run problems to their ends, every so many-th in one thread, as the work of neighbours is alike."""
    count = min(thread_count(execution.workers), len(problems))
    if not execution.workers:
        count = 1 if IN_TASK.get() else min(count, _most_threads(problems, method))
    if count == 1:
        return integrate_batch(problems, method, bar)
    groups = [new_batch(problems[first::count], method) for first in range(count)]
    with worker_threads(count) as (pool, stop):
        left = {pool.submit(_advance_in_thread, group, problems[0].t_end) for group in groups}
        while left:
            done, left = wait(left, POLL_TIME)
            for thread in done:
                thread.result()  # an error ends the others too
            if bar.update(float(np.mean([group.runs.times[:, NOW].mean() for group in groups]))):
                stop.set()
    return _in_turn([batch_result(group) for group in groups])


def _most_threads(problems: Sequence[Problem], method: Taylor) -> int:
    """How many threads are worth while: in lanes a few runs take as long as full lanes of them."""
    program, t_end = problems[0].program, problems[0].t_end
    side_by_side = problems[0].derive is None and takes_lanes(program, method.order_of(program), t_end)
    return max(1, len(problems) // lane_count()) if side_by_side else len(problems)


def _advance_in_thread(group: Batch, t_end: float) -> None:
    with Progress(t_end, False) as bar:
        advance_batch(group, t_end, bar)


def _in_turn(results: Sequence[BatchResult]) -> BatchResult:
    """The runs of results in turn: the first run of each, then the second ones."""
    rows = [first + len(results) * np.arange(len(result.t)) for first, result in enumerate(results)]
    turns = np.argsort(np.concatenate(rows))

    def merged(name: str) -> np.ndarray:
        return np.concatenate([getattr(result, name) for result in results])[turns]

    status = [how for result in results for how in result.status]
    return BatchResult(
        merged("t"),
        merged("states"),
        merged("modes"),
        merged("steps"),
        merged("events"),
        tuple(status[i] for i in turns),
    )


def start_group(automaton: HybridAutomaton, states: np.ndarray, method: Taylor) -> Batch:
    """A batch of runs of one automaton from states (N, n), to be advanced; the arguments are not checked."""
    problem = problem_for_batch(automaton, states[0], 0.0, method)
    return new_batch([problem._replace(x0=state) for state in states], method)


def advance_group(group: Batch, t_end: float) -> None:
    """Advance the runs of a batch to a time, without a progress bar; KeyboardInterrupt after ctrl-C."""
    with Progress(t_end, False) as bar:
        advance_batch(group, t_end, bar)
    if bar.stopped:
        raise KeyboardInterrupt


def _is_one_for_each(x0: Any) -> bool:
    if isinstance(x0, str) or not isinstance(x0, (Sequence, np.ndarray)):
        return False
    return any(isinstance(each, (str, Mapping)) or np.ndim(each) > 0 for each in x0)


def _problems(models: Sequence[ModelOrAutomaton], x0: Any, t_end: float, method: Taylor) -> list[Problem]:
    each = x0 if _is_one_for_each(x0) else [x0] * len(models)
    if len(each) != len(models):
        raise ValueError(
            f"x0 must hold a state for each of the {len(models)} models, got {len(each)}: give as many"
        )
    first: dict[int, int] = {}  # one model may be given for many initial states
    for i, model in enumerate(models):
        first.setdefault(id(model), i)
    automata = {key: _check_model(models[i], i) for key, i in first.items()}
    starts = [initial_state_of(model, x0, automata[id(model)]) for model, x0 in zip(models, each)]
    problems = {
        key: problem_for_batch(one, starts[first[key]], t_end, method) for key, one in automata.items()
    }
    return [problems[id(model)]._replace(x0=start) for model, start in zip(models, starts)]


def problem_for_batch(automaton: HybridAutomaton, x0: np.ndarray, t_end: float, method: Taylor) -> Problem:
    """The problem with all modes, which lanes need; where these are too many, with those that runs enter."""
    limit = method.chatter_limit(automaton)
    automaton = with_chatter_limit(automaton, limit)
    if isinstance(automaton.names, ModeNames) and automaton.names.more_than(MOST_MODES_IN_LANES):
        return problem_of(automaton, x0, t_end, chatter=limit)
    return Problem(*program_of(automaton), x0, t_end, chatter=limit)


def _check_model(model: ModelOrAutomaton, i: int) -> HybridAutomaton:
    try:
        automaton = automaton_of(model)
        check_automaton(automaton)
    except (TypeError, ValueError) as error:
        raise type(error)(f"models[{i}]: {error}") from error
    return automaton
