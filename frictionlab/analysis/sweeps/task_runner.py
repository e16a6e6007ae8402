"""Many independent computations: in threads by default, in any executor, resumable, with a progress bar.

After a first ctrl-C tasks that have begun are finished; after a second one they are left, and their results
lost; a third one interrupts wherever it is.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Container, Iterator, Sequence, Sized
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import parent_process
from time import monotonic
from typing import Any

from frictionlab.analysis.options import Execution
from frictionlab.interruption import POLL_TIME, STOP_SIGN, Presses, deferred_interrupts, progress_bar, tell

TASKS_PER_WORKER = (
    2  # tasks handed to each worker at a time, so that ctrl-C does not have to wait for all of them
)
QUIETLY = Execution(progress=False)
LEAVING_PRESS, URGENT_PRESS = 2, 3  # the presses of ctrl-C that leave tasks in progress, and that interrupt
SILENT_TIME = 0.5  # seconds in which tasks may finish after ctrl-C before the user is told of them


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
    """Call `function` on each task and hand every result to `keep` with its index, as soon as it is there.

    Parameters
    ----------
    function : callable
        Called as ``function(*task)``.  An executor of processes needs to be able to pickle it.
    tasks : sequence of tuples
    keep : callable of (index, result)
        Called in this thread only, and never interrupted by a first or a second ctrl-C.
    names : sequence of str
        Name of each task, for the message where it fails, e.g. "mu_k = 1.4".
    done : container of int
        Indices of the tasks that are left out.
    execution : Execution
        Its workers, executor and progress; the solver's kernels run at the same time in threads.
    title : str
        What the progress bar says.

    Returns
    -------
    bool
        Whether all were done and nobody pressed ctrl-C; tasks already begun are still finished and kept.

    Raises
    ------
    RuntimeError
        Where a task fails, from its error, once those already begun are finished and kept.
    """
    executor, count = execution.executor, execution.workers or os.cpu_count() or 1
    left = [(i, task) for i, task in enumerate(tasks) if i not in done]
    max_running = TASKS_PER_WORKER * count if executor is None else len(left)
    bar = progress_bar(total=len(left), desc=title, shown=execution.progress)
    todo, running, failed = iter(left), {}, {}
    with bar, deferred_interrupts(URGENT_PRESS) as presses:
        try:
            with _executor(executor, count, presses) as pool:
                while not failed and not presses.count:
                    _submit_tasks(running, todo, max_running, pool, function)
                    if not running:
                        break
                    _collect_results(running, keep, failed, bar)
                for future in [f for f in running if f.cancel()]:
                    del running[future]
                _finish_tasks(running, presses, lambda: _collect_results(running, keep, failed, bar))
        except KeyboardInterrupt:
            return False
    if failed and not presses.count:
        index, error = min(failed.items())
        raise RuntimeError(f"{names[index]} failed with {type(error).__name__}: {error}") from error
    return not presses.count


def _finish_tasks(running: Sized, presses: Presses, collect: Callable[[], None]) -> None:
    """Collect the results of tasks that have begun, and say so where ctrl-C has asked for the end."""
    since, told = monotonic(), False
    while running and presses.count < LEAVING_PRESS:
        if presses.count and not told and monotonic() - since > SILENT_TIME:
            tasks = "the task that has" if len(running) == 1 else f"the {len(running)} tasks that have"
            tell(f"ctrl-C: waiting for {tasks} begun; press it again to leave what is not done")
            told = True
        collect()


def check_function(name: str, function: Any, cure: str) -> None:
    """Raise unless it can be called."""
    if not callable(function):
        raise TypeError(f"{name} must be a function of a model, got {function!r}: {cure}")


def function_name(function: Callable[..., Any]) -> str:
    """What files tell functions apart by."""
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
def _executor(given: Executor | None, workers: int, presses: Presses) -> Iterator[Executor]:
    """The executor given, left open, or one of threads, whose runs stop where nobody waits for them."""
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
        if presses.count >= LEAVING_PRESS:
            sign.set()
        pool.shutdown(wait=not sign.is_set(), cancel_futures=True)


def ignore_interrupts_in_worker() -> None:
    """Ignore ctrl-C in a process of a pool: it reaches all processes of a terminal, and only the first
    handles it."""
    if parent_process() is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
