"""`fl.bifurcation`: steady states against a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.hybrid.choice import method_of
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.status import Status
from frictionlab.hybrid.taylor import Taylor
from frictionlab.hybrid.validation import check_choice

from .branch import Bifurcation, collected, load_bifurcation
from .ensemble import ensemble
from .interrupts import noted_interrupts
from .journal import Journal
from .kinds import ENDED
from .sections import Section
from .steady_state import automaton_of, check_steady, steady_state
from .tasks import check_workers, run_tasks

__all__ = ["Bifurcation", "bifurcation", "load_bifurcation"]
STARTS = ("rest", "near", "continue")
GROUP = 16  # as many as two sets of lanes
KEPT = 200  # section points that are kept of each value, the last ones


def bifurcation(
    model: Any,
    parameter: str,
    values: Any,
    x0: Any = "rest",
    *,
    transient: float = 200.0,
    window: float = 100.0,
    longest: float | None = None,
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
        after a run that ended early.  Values that ascend and then descend show hysteresis.  One after
        another, so in one thread.
    transient, window, longest, method, section, tolerance
        As :func:`steady_state`: with `longest` values that have not settled go on, window by window.
    workers : int or None
        Threads; None takes one for each processor.
    executor : concurrent.futures.Executor or None
        Used instead of threads: a ProcessPoolExecutor, or a cluster's, such as Dask's
        ``client.get_executor()``.
    resume : path or None
        File in which results are kept as they come; if it is there, what it holds is not computed again.
        In the end it does not depend on the number of workers, or on how often the sweep was cut off.
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
        check_choice("x0", x0, STARTS)
    models = _models(model, parameter, values)
    settings = {"transient": transient, "window": window, "longest": longest}
    settings |= {"section": section, "tolerance": tolerance}
    for each in models:
        check_steady(each, "rest" if _continues(x0) else x0, **settings)
    options = {**settings, "method": method_of(method)}
    asked = _asked(model, parameter, models, x0, options)
    journal = Journal(asked, resume)
    names = [f"{parameter} = {getattr(m, parameter):g}" for m in models]
    if _continues(x0):
        _in_turn(models, names, options, journal, progress)
    else:
        groups = _groups(
            [i for i in range(len(models)) if i not in journal.results], models, options["method"]
        )

        def keep(task: int, results: list[dict[str, Any]]) -> None:
            for i, result in zip(groups[task], results):
                journal.keep(i, result)

        run_tasks(
            several,
            [([models[i] for i in group], x0, options) for group in groups],
            keep=keep,
            names=[", ".join(names[i] for i in group) for group in groups],
            workers=workers,
            executor=executor,
            progress=f"bifurcation over {parameter}" if progress else None,
        )
    journal.close()
    return collected(asked, journal.results)


def _models(model: Any, parameter: str, values: Any) -> list[Any]:
    automaton_of(model)  # raises for what has no parameters to replace
    values = np.asarray(values, dtype=float).ravel()
    if not len(values):
        raise ValueError("values must hold at least one number, got none: give those of the parameter")
    return [model.replace(**{parameter: float(value)}) for value in values]


def _continues(x0: Any) -> bool:
    return isinstance(x0, str) and x0 == "continue"


def _groups(left: Sequence[int], models: Sequence[Any], method: Method) -> list[Sequence[int]]:
    """Values whose transients are run side by side: that pays where no events come between."""
    alike = isinstance(method, Taylor) and not any(mode.events for mode in models[0].automaton().modes)
    size = GROUP if alike else 1
    return [left[i : i + size] for i in range(0, len(left), size)]


def several(models: Sequence[Any], x0: Any, options: dict[str, Any]) -> list[dict[str, Any]]:
    """One task: the steady states of some models, the same as each would have alone."""
    transient, longest = options["transient"], options["longest"]
    if len(models) == 1 or transient == 0.0:
        return [one(model, x0, options) for model in models]
    ends = ensemble(models, transient, x0=x0, method=options["method"], progress=False)
    left = longest - transient if longest is not None and longest > transient else None
    after = {**options, "transient": 0.0, "longest": left}
    ended = zip(models, ends.states, ends.status)
    return [one(m, state, after) if status.ok else one(m, x0, options) for m, state, status in ended]


def one(model: Any, x0: Any, options: dict[str, Any]) -> dict[str, Any]:
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
        "section": found.section.state[-KEPT:].tolist(),
        "final": found.trajectory.final_state.tolist(),
        "warning": found.warning,
    }


def _in_turn(
    models: Sequence[Any], names: Sequence[str], options: dict[str, Any], journal: Journal, progress: bool
) -> None:
    """Each from where the one before ended; ctrl-C ends it with what is done."""
    from tqdm.auto import tqdm

    bar = tqdm(models, "bifurcation", delay=1.0, leave=False, disable=not progress)
    start: Any = "rest"
    with noted_interrupts() as interrupted:
        for i, model in enumerate(bar):
            if i not in journal.results:
                try:
                    journal.keep(i, one(model, start, options))
                except KeyboardInterrupt:
                    return
                except Exception as error:
                    raise RuntimeError(f"{names[i]} failed with {type(error).__name__}: {error}") from error
            done = journal.results[i]
            start = "rest" if done["kind"] == ENDED else np.array(done["final"])
            if interrupted():
                return


def _asked(model: Any, parameter: str, models: Sequence[Any], x0: Any, options: dict[str, Any]) -> Any:
    start = x0 if isinstance(x0, str) else np.asarray(x0, dtype=float).tolist()
    values = [getattr(m, parameter) for m in models]
    states = [symbol.name for symbol in model.automaton().states]
    about = {"model": model.to_dict(), "parameter": parameter, "values": values, "x0": start}
    return {**about, **options, "method": options["method"].describe(), "states": states}
