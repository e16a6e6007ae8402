"""`fl.bifurcation`: steady states against a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.analysis.ensemble import ensemble
from frictionlab.analysis.steady_state.motion_kind import MotionKind
from frictionlab.analysis.steady_state.poincare_sections import Section
from frictionlab.analysis.steady_state.steady_state import check_steady_state_arguments, steady_state
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.method_registry import method_of
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Status
from frictionlab.models.coercion import automaton_of
from frictionlab.validation import check_choice

from .bifurcation_result import Bifurcation, bifurcation_from_results, load_bifurcation
from .journal import Journal
from .task_runner import check_workers, deferred_interrupts, run_tasks

__all__ = ["Bifurcation", "bifurcation", "load_bifurcation"]
INITIAL_STATES = ("rest", "near", "continue")
ENSEMBLE_SIZE = 16  # as many as two sets of lanes
MAX_SECTION_POINTS = 200  # section points kept for each value, the last ones


def bifurcation(
    model: Any,
    parameter: str,
    values: Any,
    x0: Any = "rest",
    *,
    transient: float = 200.0,
    window: float = 100.0,
    t_max: float | None = None,
    method: str | Method = "taylor",
    section: Section | None = None,
    tolerance: float = 1e-6,
    workers: int | None = None,
    executor: Executor | None = None,
    resume: str | Path | None = None,
    progress: bool = True,
) -> Bifurcation:
    """The steady state for each value of a parameter.

    Parameters
    ----------
    model : Model
    parameter : str
    values : array_like (N,)
    x0 : "rest", "near", "continue" or array_like (2n,)
        "continue" starts each value from where the one before ended, the first from rest, and so does one
        after a run that ended early.  Values that ascend and then descend show hysteresis.  The values are
        computed one after another, in one thread.
    transient, window, t_max, method, section, tolerance
        As :func:`steady_state`: with `t_max` motions that have not settled go on, window by window.
    workers : int or None
        Threads; None takes one for each processor.
    executor : concurrent.futures.Executor or None
        Used instead of threads: a ProcessPoolExecutor, or a cluster's, such as Dask's
        ``client.get_executor()``.
    resume : path or None
        File in which results are kept as they come; if it is there, what it holds is not computed again.
        The finished file does not depend on the number of workers, or on how often the sweep was interrupted.
    progress : bool

    Returns
    -------
    Bifurcation
        After ctrl-C with the values that were done.

    Raises
    ------
    TypeError
        For an unknown parameter, or what is no model.
    ValueError
        For other bad arguments, or a file of another sweep; like the others before any work is done.
    OSError
        Where the file cannot be written.
    RuntimeError
        Where a value fails, from its error; what was done before is in the file.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt().without("geometry")
    >>> fl.bifurcation(model, "mu_k", [0.2, 1.4], transient=150, window=20, progress=False).kinds
    ('equilibrium', 'periodic')
    """
    check_workers(workers)
    if isinstance(x0, str):
        check_choice("x0", x0, INITIAL_STATES)
    models = _models(model, parameter, values)
    settings = {"transient": transient, "window": window, "t_max": t_max}
    settings |= {"section": section, "tolerance": tolerance}
    for each in models:
        check_steady_state_arguments(each, "rest" if _is_continued(x0) else x0, **settings)
    options = {**settings, "method": method_of(method)}
    specification = _sweep_arguments(model, parameter, models, x0, options)
    journal = Journal(specification, resume)
    names = [f"{parameter} = {getattr(m, parameter):g}" for m in models]
    if _is_continued(x0):
        _run_continued(models, names, options, journal, progress)
    else:
        groups = _groups(
            [i for i in range(len(models)) if i not in journal.results], models, options["method"]
        )

        def keep(task: int, results: list[dict[str, Any]]) -> None:
            for i, result in zip(groups[task], results):
                journal.keep(i, result)

        run_tasks(
            steady_states_task,
            [([models[i] for i in group], x0, options) for group in groups],
            keep=keep,
            names=[", ".join(names[i] for i in group) for group in groups],
            workers=workers,
            executor=executor,
            progress=f"bifurcation over {parameter}" if progress else None,
        )
    journal.close()
    return bifurcation_from_results(specification, journal.results)


def _models(model: Any, parameter: str, values: Any) -> list[Any]:
    automaton_of(model)  # raises where there are no parameters to replace
    values = np.asarray(values, dtype=float).ravel()
    if not len(values):
        raise ValueError("values must hold at least one number, got none: give those of the parameter")
    return [model.replace(**{parameter: float(value)}) for value in values]


def _is_continued(x0: Any) -> bool:
    return isinstance(x0, str) and x0 == "continue"


def _groups(left: Sequence[int], models: Sequence[Any], method: Method) -> list[Sequence[int]]:
    """Groups of values whose transients are run side by side, which is quicker for models without events."""
    alike = isinstance(method, Taylor) and not any(mode.events for mode in models[0].automaton().modes)
    size = ENSEMBLE_SIZE if alike else 1
    return [left[i : i + size] for i in range(0, len(left), size)]


def steady_states_task(models: Sequence[Any], x0: Any, options: dict[str, Any]) -> list[dict[str, Any]]:
    """One task: the steady states of several models, each the same as if computed alone."""
    transient, t_max = options["transient"], options["t_max"]
    if len(models) == 1 or transient == 0.0:
        return [steady_state_task(model, x0, options) for model in models]
    ends = ensemble(models, transient, x0=x0, method=options["method"], progress=False)
    left = t_max - transient if t_max is not None and t_max > transient else None
    after = {**options, "transient": 0.0, "t_max": left}
    ended = zip(models, ends.states, ends.status)
    return [
        steady_state_task(m, state, after) if status.ok else steady_state_task(m, x0, options)
        for m, state, status in ended
    ]


def steady_state_task(model: Any, x0: Any, options: dict[str, Any]) -> dict[str, Any]:
    """One task: the steady state as data that JSON can hold."""
    found = steady_state(model, x0, progress=False, **options)
    if found.trajectory.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    period = None if np.isnan(found.period) else found.period
    return {
        "kind": found.kind,
        "period": period,
        "onsets": found.onsets_per_period,
        "intensity": None if np.isnan(found.intensity) else found.intensity,
        "shares": dict(found.time_in_mode),
        "section": found.section.state[-MAX_SECTION_POINTS:].tolist(),
        "final": found.trajectory.final_state.tolist(),
        "warning": found.warning,
    }


def _run_continued(
    models: Sequence[Any], names: Sequence[str], options: dict[str, Any], journal: Journal, progress: bool
) -> None:
    """The steady states one after another, each from where the one before ended; ctrl-C keeps those done."""
    from tqdm.auto import tqdm

    bar = tqdm(models, "bifurcation", delay=1.0, leave=False, disable=not progress)
    start: Any = "rest"
    with deferred_interrupts() as interrupted:
        for i, model in enumerate(bar):
            if i not in journal.results:
                try:
                    journal.keep(i, steady_state_task(model, start, options))
                except KeyboardInterrupt:
                    return
                except Exception as error:
                    raise RuntimeError(f"{names[i]} failed with {type(error).__name__}: {error}") from error
            done = journal.results[i]
            start = "rest" if done["kind"] == MotionKind.ENDED_EARLY else np.array(done["final"])
            if interrupted():
                return


def _sweep_arguments(
    model: Any, parameter: str, models: Sequence[Any], x0: Any, options: dict[str, Any]
) -> Any:
    start = x0 if isinstance(x0, str) else np.asarray(x0, dtype=float).tolist()
    values = [getattr(m, parameter) for m in models]
    states = [symbol.name for symbol in model.automaton().states]
    about = {"model": model.to_dict(), "parameter": parameter, "values": values, "x0": start}
    return {**about, **options, "method": options["method"].describe(), "states": states}
