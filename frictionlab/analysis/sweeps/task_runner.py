"""Many independent computations: in threads by default, in any executor, resumable, with a progress bar.

After a first ctrl-C tasks that have begun are finished; a second one interrupts at once.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Container, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import parent_process
from typing import Any

from frictionlab.analysis.options import Execution
from frictionlab.hybrid.progress import progress_bar

TASKS_PER_WORKER = (
    2  # tasks handed to each worker at a time, so that ctrl-C does not have to wait for all of them
)
QUIETLY = Execution(progress=False)
INTERRUPT_POLL_TIME = 0.2  # seconds between two looks at ctrl-C


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
        Called in this thread only, and never interrupted by a first ctrl-C.
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
        Whether all were done; False after ctrl-C, when tasks already begun are still finished and kept.

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
    with bar, _executor(executor, count) as pool, deferred_interrupts() as interrupted:
        while not failed and not interrupted():
            _submit_tasks(running, todo, max_running, pool, function)
            if not running:
                return True
            _collect_results(running, keep, failed, bar)
        for future in [f for f in running if f.cancel()]:
            del running[future]
        while running:
            _collect_results(running, keep, failed, bar)
    if failed and not interrupted():
        index, error = min(failed.items())
        raise RuntimeError(f"{names[index]} failed with {type(error).__name__}: {error}") from error
    return False


def check_function(name: str, function: Any, cure: str) -> None:
    """Raise unless it can be called."""
    if not callable(function):
        raise TypeError(f"{name} must be a function of a model, got {function!r}: {cure}")


def _collect_results(
    running: dict[Future[Any], int],
    keep: Callable[[int, Any], None],
    failed: dict[int, BaseException],
    bar: Any,
) -> None:
    """Keep the results that have arrived, waiting for a moment at most."""
    for future in wait(running, timeout=INTERRUPT_POLL_TIME, return_when=FIRST_COMPLETED).done:
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
def _executor(given: Executor | None, workers: int) -> Iterator[Executor]:
    if given is not None:
        yield given
        return
    pool = ThreadPoolExecutor(workers)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], bool]]:
    """Context in which a first ctrl-C is only noted, as the function yielded tells; a second one interrupts.

    In a thread other than the main one Python delivers no signals, so nothing is installed there.
    """
    noted: list[int] = []

    def note(number: int, frame: Any) -> None:
        if noted:
            raise KeyboardInterrupt
        noted.append(number)

    previous = signal.getsignal(signal.SIGINT)
    here = threading.current_thread() is threading.main_thread() and callable(previous)
    if here:
        signal.signal(signal.SIGINT, note)
    try:
        yield lambda: bool(noted)
    finally:
        if here:
            signal.signal(signal.SIGINT, previous)


def ignore_interrupts_in_worker() -> None:
    """Ignore ctrl-C in a process of a pool: it reaches all processes of a terminal, and only the first
    handles it."""
    if parent_process() is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
