"""Many independent computations: in threads, or in any given executor, with a progress bar.

After a first ctrl-C the tasks that have begun are finished.  A second one abandons them and their results.  A
third one interrupts the computation at once.
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
from frictionlab.interruption import (
    POLL_TIME,
    STOP_SIGN,
    InterruptCounter,
    deferred_interrupts,
    progress_bar,
    tell,
)

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
    todo, running = iter(left), {}
    failed: dict[int, BaseException] = {}
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
        raise failure(names[index], error) from error
    return not interrupts.count


def failure(name: str, error: BaseException) -> RuntimeError:
    """The error to raise where a task fails."""
    return RuntimeError(f"{name} failed with {type(error).__name__}: {error}")


def _finish_tasks(running: Sized, interrupts: InterruptCounter, collect: Callable[[], None]) -> None:
    """Collect the results of tasks that have begun; after ctrl-C, tell the user of the wait."""
    since, told = monotonic(), False
    while running and interrupts.count < LEAVING_PRESS:
        if interrupts.count and not told and monotonic() - since > SILENT_TIME:
            tasks = "the task that has" if len(running) == 1 else f"the {len(running)} tasks that have"
            tell(f"ctrl-C: waiting for {tasks} begun; press it again to leave what is not done")
            told = True
        collect()


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
