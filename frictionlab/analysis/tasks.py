"""Many independent computations: in threads by default, in any executor, resumable, with a progress bar."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Any

AHEAD = 2  # tasks handed to each worker at a time, so that ctrl-C does not have to wait for all of them


def run_tasks(
    function: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    *,
    keep: Callable[[int, Any], None],
    workers: int | None = None,
    executor: Executor | None = None,
    progress: str | None = None,
) -> bool:
    """Call `function` on each task and hand every result to `keep` with its index, as soon as it is there.

    Parameters
    ----------
    function : callable
        Called as ``function(*task)``.  An executor of processes needs to be able to pickle it.
    tasks : sequence of tuples
    keep : callable of (index, result)
        Called in this thread only.
    workers : int or None
        Threads; None takes one for each processor.  The solver's kernels run at the same time in threads.
    executor : concurrent.futures.Executor or None
        Used instead of threads, and left open.
    progress : str or None
        What the progress bar says; None shows none.

    Returns
    -------
    bool
        Whether all were done; False after ctrl-C, when tasks already begun are still finished and kept.
    """
    from tqdm.auto import tqdm

    bar = tqdm(total=len(tasks), desc=progress, disable=progress is None, delay=1.0, leave=False)
    count = workers or os.cpu_count() or 1
    most = AHEAD * count if executor is None else len(tasks)
    with bar, _executor(executor, count) as pool:
        todo = iter(enumerate(tasks))
        running: dict[Future[Any], int] = {}
        complete = True
        while True:
            try:
                if complete:
                    _refill(running, todo, most, pool, function)
                if not running:
                    return complete
                done, _ = wait(running, return_when=FIRST_COMPLETED)
            except KeyboardInterrupt:
                if not complete:
                    raise
                complete = False
                for future in [f for f in running if f.cancel()]:
                    del running[future]
                continue
            for future in done:
                keep(running.pop(future), future.result())
                bar.update()


def _refill(
    running: dict[Future[Any], int],
    todo: Iterator[tuple[int, tuple[Any, ...]]],
    most: int,
    pool: Executor,
    function: Any,
) -> None:
    while len(running) < most:
        index, task = next(todo, (None, ()))
        if index is None:
            return
        running[pool.submit(function, *task)] = index


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
