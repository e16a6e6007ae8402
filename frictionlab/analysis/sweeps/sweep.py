"""`fl.sweep`: any function of a model over a grid; and `run_tasks`, which runs many independent computations.

Tasks run in threads, or in any given executor; they can be resumed and show a progress bar.  After a first
ctrl-C those that have begun are finished.  A second one abandons them and their results.  A third one
interrupts the computation at once.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Container, Iterator, Mapping, Sequence, Sized
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from multiprocessing import parent_process
from time import monotonic
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.options import Execution, ExecutionKeywords, merge_keywords
from frictionlab.analysis.simulate import initial_state_of, named_state
from frictionlab.analysis.sweeps.journal import Journal, results_schema
from frictionlab.interruption import (
    POLL_TIME,
    STOP_SIGN,
    InterruptCounter,
    deferred_interrupts,
    progress_bar,
    tell,
)
from frictionlab.models.composition import parameter_unit
from frictionlab.models.model import require_model
from frictionlab.presentation import Drawable, count, import_optional, shorten, span
from frictionlab.stored_data import anything
from frictionlab.validation import abbreviate, check_mapping, check_sequence, float_array

if TYPE_CHECKING:
    from frictionlab.models.model import Model

# tasks handed to each worker at a time, so that ctrl-C does not have to wait for all of them
TASKS_PER_WORKER = 2
QUIETLY = Execution(progress=False)
LEAVING_PRESS, URGENT_PRESS = 2, 3  # presses of ctrl-C that abandon running tasks, that interrupt at once
SILENT_TIME = 0.5  # seconds after ctrl-C before the user is told that tasks are still running


def run_tasks(
    function: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    *,
    keep: Callable[[int, Any], None],
    names: Sequence[str],
    done: Container[int] = (),
    execution: Execution = QUIETLY,
    title: str = "",
) -> bool:
    """Call `function` on each task and hand every result to `keep` with its index, as soon as it is known.

    Parameters
    ----------
    function : callable
        Called as ``function(*task)``.  For an executor of processes it has to be picklable.
    tasks : sequence of tuples
    keep : callable of (index, result)
        Called in this thread only, and never interrupted by a first or a second ctrl-C.
    names : sequence of str
        Name of each task, for the message where it fails, e.g. "mu_k = 1.4".
    done : container of int
        Indices of the tasks that are left out.
    execution : Execution
        Its workers, executor and progress.  Threads compute in parallel, as the solver's kernels release the
        lock of the interpreter.
    title : str
        What the progress bar says.

    Returns
    -------
    bool
        Whether all were done without ctrl-C.  After a first ctrl-C tasks already begun are finished and kept.

    Raises
    ------
    RuntimeError
        Where a task fails, raised from its error, once those already begun are finished and kept.
    """
    executor, count = execution.executor, execution.workers or os.cpu_count() or 1
    left = [(i, task) for i, task in enumerate(tasks) if i not in done]
    max_running = TASKS_PER_WORKER * count if executor is None else len(left)
    bar = progress_bar(total=len(left), desc=title, shown=execution.progress)
    todo, running, failed = iter(left), {}, {}
    with bar, deferred_interrupts(URGENT_PRESS) as interrupts:
        try:
            with _executor(executor, count, interrupts) as pool:
                while not failed and not interrupts.count:
                    _submit_tasks(running, todo, max_running, pool, function)
                    if not running:
                        break
                    _collect_results(running, keep, failed, bar)
                for future in [f for f in running if f.cancel()]:
                    del running[future]
                _finish_tasks(running, interrupts, lambda: _collect_results(running, keep, failed, bar))
        except KeyboardInterrupt:
            return False
    if failed and not interrupts.count:
        index, error = min(failed.items())
        raise RuntimeError(f"{names[index]} failed with {type(error).__name__}: {error}") from error
    return not interrupts.count


def _finish_tasks(running: Sized, interrupts: InterruptCounter, collect: Callable[[], None]) -> None:
    """Collect the results of tasks that have begun; after ctrl-C, tell the user of the wait."""
    since, told = monotonic(), False
    while running and interrupts.count < LEAVING_PRESS:
        if interrupts.count and not told and monotonic() - since > SILENT_TIME:
            tasks = "the task that has" if len(running) == 1 else f"the {len(running)} tasks that have"
            tell(f"ctrl-C: waiting for {tasks} begun; press it again to leave what is not done")
            told = True
        collect()


def check_function(name: str, function: Any, cure: str) -> None:
    """Raise unless `function` can be called."""
    if not callable(function):
        raise TypeError(f"{name} must be a function of a model, got {abbreviate(function)}: {cure}")


def function_name(function: Callable[..., Any]) -> str:
    """The name by which files tell functions apart."""
    name = getattr(function, "__name__", type(function).__name__)
    return getattr(function, "__qualname__", name)


def _collect_results(
    running: dict[Future[Any], int],
    keep: Callable[[int, Any], None],
    failed: dict[int, BaseException],
    bar: Any,
) -> None:
    """Keep the results that have arrived, waiting for a moment at most."""
    for future in wait(running, timeout=POLL_TIME, return_when=FIRST_COMPLETED).done:
        index = running.pop(future)
        error = future.exception()
        if error is None:
            keep(index, future.result())
            bar.update()
        else:
            failed[index] = error


def _call(function: Callable[..., Any], *task: Any) -> Any:
    ignore_interrupts_in_worker()
    return function(*task)


def _submit_tasks(
    running: dict[Future[Any], int],
    todo: Iterator[tuple[int, tuple[Any, ...]]],
    max_running: int,
    pool: Executor,
    function: Any,
) -> None:
    while len(running) < max_running:
        index, task = next(todo, (None, ()))
        if index is None:
            return
        running[pool.submit(_call, function, *task)] = index


@contextmanager
def _executor(given: Executor | None, workers: int, interrupts: InterruptCounter) -> Iterator[Executor]:
    """The given executor, which is left open, or one of threads, whose runs stop if they are abandoned."""
    if given is not None:
        yield given
        return
    sign = threading.Event()
    pool = ThreadPoolExecutor(workers, initializer=STOP_SIGN.set, initargs=(sign,))
    try:
        yield pool
    except BaseException:
        sign.set()
        raise
    finally:
        if interrupts.count >= LEAVING_PRESS:
            sign.set()
        pool.shutdown(wait=not sign.is_set(), cancel_futures=True)


def ignore_interrupts_in_worker() -> None:
    """Ignore ctrl-C in a process of a pool: it reaches all processes of a terminal, and only the first
    handles it."""
    if parent_process() is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


@dataclass(frozen=True, eq=False)
class Sweep(Drawable):
    """Results over a grid of parameters and initial states.

    Parameters
    ----------
    over : mapping of str to array
        Parameters and their values, one axis of the grid each.
    x0 : tuple
        Initial states, the last axis; empty where the function takes none.
    results : object array
        What the function returned; None for what was not done before ctrl-C.
    model : Model
        With the values that are not in `over`.
    function : str
        Name of the function; "result" of one that has none.
    """

    drawn_by = "plot_sweep"

    over: Mapping[str, NDArray[np.float64]]
    x0: tuple[Any, ...]
    results: NDArray[np.object_]
    model: Model
    function: str

    def __repr__(self) -> str:
        axes = [f"{name} {span(values)} ({len(values)})" for name, values in self.over.items()]
        axes += [count(len(self.x0), "initial state")] if self.x0 else []
        left = sum(result is None for result in self.results.ravel())
        return f"Sweep({self.function} over {shorten(axes)}{f'; {left} without result' if left else ''})"

    def to_array(self) -> NDArray[np.float64]:
        """The results as numbers; NaN for those that are None."""
        return np.vectorize(lambda r: np.nan if r is None else float(r), otypes=[float])(self.results)

    def to_dataframe(self) -> Any:
        """One row for each point of the grid, as a pandas DataFrame (needs the extra ``data``).

        Mappings have a column for each key, other results one named "result".
        """
        pd = import_optional("pandas", "to_dataframe")
        axes = {**self.over, **({"x0": self.labels()} if self.x0 else {})}
        index = pd.MultiIndex.from_product(list(axes.values()), names=list(axes))
        index = index if len(axes) > 1 else index.get_level_values(0)
        table = pd.DataFrame([_row(result) for result in self.results.ravel()], index=index)
        table.attrs["units"] = {
            name: unit for name in self.over if (unit := parameter_unit(self.model, name))
        }
        return table

    def to_xarray(self) -> Any:
        """The table of :meth:`to_dataframe` as an xarray Dataset, a dimension for each parameter (needs the
        extra ``data``).

        The values of each parameter have to differ from each other.
        """
        import_optional("xarray", "to_xarray")
        return self.to_dataframe().to_xarray()

    def labels(self) -> list[str]:
        """A label for each initial state: its name, or its index."""
        return [start if isinstance(start, str) else f"state {i}" for i, start in enumerate(self.x0)]


def sweep(
    model: Model,
    function: Callable[..., Any],
    over: Mapping[str, Any],
    *,
    x0: Sequence[Any] = (),
    execution: Execution | None = None,
    **keywords: Unpack[ExecutionKeywords],
) -> Sweep:
    """Call a function with the model at each point of a grid of parameters.

    Parameters
    ----------
    model : Model
    function : callable
        Called as ``function(model)``, or as ``function(model, start)`` where `x0` is given.
    over : mapping of str to array_like
        Parameters and their values.
    x0 : sequence
        Initial states: names, or arrays (2n,), as :func:`simulate` takes them.
    execution : Execution or None
        Workers, executor, file and progress bar; None takes the defaults.  Results that the file of `resume`
        keeps have to be numbers, texts, or lists and mappings of such.  The file knows the function by its
        name only: use another file for another function, and for other settings inside a function.
    **keywords
        Fields of :class:`Execution`, which replace those of `execution`: ``workers=2``.

    Returns
    -------
    Sweep

    Raises
    ------
    TypeError
        For an unknown parameter or keyword, or where an argument is no model or function.
    ValueError
        For a value that breaks a rule or a bad initial state.  Both are raised before any task starts, but
        for the TypeError of a result that JSON cannot hold.
    OSError
        Where the file cannot be written, or another sweep is using it.
    RuntimeError
        Where the function fails, raised from its error; the results before it are in the file.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the Sweep with None for what was not done.  A first
        press lets tasks that have begun finish, a second one abandons them.

    Examples
    --------
    >>> import frictionlab as fl
    >>> sweep = fl.sweep(fl.SliderOnBelt(), lambda m: fl.equilibrium(m).normal_force, {"F": [100, 200]})
    >>> sweep.to_array().round(2)
    array([ 60.75, 121.54])
    """
    require_model(model, cure="write sweep(model, function, over), the model made, such as fl.SliderOnBelt()")
    check_function("function", function, "write sweep(model, function, over)")
    (how,) = merge_keywords("sweep", keywords, execution=(Execution, execution))
    axes = grid_axes(over)
    points = list(product(*axes.values()))
    models = [model.replace(**dict(zip(axes, map(float, point)))) for point in points]
    x0 = check_sequence("x0", x0, f"write [{abbreviate(x0)}]")
    starts = [named_state(start) for start in x0]
    for start in starts:
        initial_state_of(model, start)
    specification = {"function": function_name(function), "model": model.to_dict(), "x0": starts}
    specification |= {"over": {k: v.tolist() for k, v in axes.items()}}
    tasks = [(m, start) for m in models for start in x0] if starts else [(m,) for m in models]
    schema = results_schema([anything] * len(tasks))  # users' functions return what they like
    with Journal(specification, how.resume, schema) as journal:
        complete = run_tasks(
            function,
            tasks,
            keep=journal.keep,
            names=[_point(axes, points[i // (len(starts) or 1)]) for i in range(len(tasks))],
            done=frozenset(journal.results),
            execution=how,
            title="sweep",
        )
        journal.put_in_order()
    results = np.empty(len(tasks), dtype=object)
    for i, result in journal.results.items():
        results[i] = result
    shape = [len(values) for values in axes.values()] + ([len(starts)] if starts else [])
    swept = Sweep(axes, tuple(x0), results.reshape(shape), model, own_name(function))
    if not complete:
        raise journal.interruption(swept, len(tasks))
    return swept


def grid_axes(over: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Parameters and their values (N,), one axis of a grid each."""
    cure = 'give each its values, such as {"mu_k": [0.5, 1.0]}'
    check_mapping("over", over, cure)
    axes = {
        name: float_array(f"over[{abbreviate(name)}]", values, cure).ravel() for name, values in over.items()
    }
    empty = [name for name, values in axes.items() if not len(values)]
    if empty or not axes:
        raise ValueError(
            f"over must hold values of each parameter, got none of {', '.join(empty) or 'any'}: {cure}"
        )
    return axes


def _point(axes: Mapping[str, Any], point: tuple[float, ...]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in zip(axes, point))


def own_name(function: Callable[..., Any]) -> str:
    """The name of a function; "result" of one that has none."""
    name = getattr(function, "__name__", "<lambda>")
    return "result" if name == "<lambda>" else name


def _row(result: Any) -> Mapping[str, Any]:
    if result is None:
        return {}
    return result if isinstance(result, Mapping) else {"result": result}


def studies_by_name(studies: Any) -> dict[str, Callable[..., Any]]:
    """The studies by name."""
    named = dict(studies) if isinstance(studies, Mapping) else {own_name(studies): studies}
    if not named:
        raise ValueError('studies must be one at least, got none: give {"onset": a function of a model}')
    for study in named.values():
        check_function(
            "studies" if isinstance(studies, Mapping) else "study", study, "give one such as fl.steady_state"
        )
    return {str(name): study for name, study in named.items()}
