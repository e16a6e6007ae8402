"""Many independent computations: in threads, or in any given executor, with a progress bar.

An executor gets tasks in chunks that take about a second, and a few chunks for each of its workers at a time.
So a task of a microsecond costs little, a lost worker takes a second of work with it, and neither the
executor nor this process holds more than it needs, however many tasks there are.

After a first ctrl-C the tasks that have begun are finished.  A second one abandons them and their results.  A
third one interrupts the computation at once.
"""

from __future__ import annotations

import os
import pickle
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from multiprocessing import parent_process
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any, NamedTuple

from frictionlab.analysis.options import Execution
from frictionlab.interruption import (
    POLL_TIME,
    STOP_SIGN,
    InterruptCounter,
    progress_bar,
    tell,
)

# chunks handed to each worker at a time, so that none waits, and ctrl-C does not have to wait for all of them
CHUNKS_PER_WORKER = 2
CHUNK_TIME = 1.0  # seconds that a chunk should take in an executor
LONGEST_CHUNK_TIME = 5.0  # seconds after which a worker hands back what it has done of a chunk
MAX_CHUNK_SIZE = 10_000  # tasks
MANY_WORKERS = 32  # taken for an executor that does not tell how many it has
QUIETLY = Execution(progress=False)
LEAVING_PRESS, URGENT_PRESS = 2, 3  # presses of ctrl-C that abandon running tasks, that interrupt at once
SILENT_TIME = 0.5  # seconds after ctrl-C before the user is told that tasks are still running
WORKER_CHECK_TIME = 2.0  # seconds between two looks at how many workers an executor has
# Whether a task of a sweep is being done here: its workers have the processors.
IN_TASK: ContextVar[bool] = ContextVar("IN_TASK", default=False)
NO_WORKER = "waiting: the executor has no worker"


class TaskFailure(RuntimeError):
    """A task that failed, or an executor that was lost; what was done before is kept."""


class ExecutorLost(TaskFailure):
    """An executor that takes no more tasks, or whose workers have died."""


def run_tasks(
    function: Callable[..., Any],
    tasks: Sequence[tuple[Any, ...]],
    *,
    keep: Callable[[int, Any], None],
    name: Callable[[int], str],
    todo: Iterable[int] | None = None,
    execution: Execution = QUIETLY,
    title: str = "",
    parts: Callable[[int], int] = lambda _: 1,
    watch: Callable[[], None] = lambda: None,
) -> bool:
    """Call `function` on each task and hand every result to `keep` with its index, as soon as it is known.

    Parameters
    ----------
    function : callable
        Called as ``function(*task)``.  For an executor of processes it has to be picklable.
    tasks : sequence of tuples
        They may be made when they are asked for.
    keep : callable of (index, result)
        Called in this thread only, and never interrupted by a first or a second ctrl-C.
    name : callable of index
        Name of a task, for the message where it fails, e.g. "mu_k = 1.4".
    todo : iterable of int or None
        Indices of the tasks to be done; None for all.
    execution : Execution
        Its workers, executor and progress.  Threads compute in parallel, as the solver's kernels release the
        lock of the interpreter.
    title : str
        What the progress bar says.
    parts : callable of index
        What the progress bar and errors count a task as.
    watch : callable
        Called in this thread ten times a second, and at the end.

    Returns
    -------
    bool
        Whether all were done without ctrl-C.  After a first ctrl-C tasks already begun are finished and kept.

    Raises
    ------
    TaskFailure
        Where a task fails, raised from its error, once those already begun are finished and kept.
    ExecutorLost
        Where the executor is lost, raised from what it said.
    """
    waiting = deque(range(len(tasks)) if todo is None else todo)
    count = sum(map(parts, waiting))
    bar = progress_bar(total=count, desc=title, shown=execution.progress)
    with InterruptCounter(URGENT_PRESS, bar) as interrupts:
        try:
            with _executor(execution, interrupts) as (pool, workers, chunk_time):
                run = _Run(function, tasks, keep, waiting, pool, workers, chunk_time, bar, parts)
                while not (run.errors or run.executor_error or interrupts.count) and run.submit():
                    run.collect(POLL_TIME)
                    watch()
                run.cancel()
                _finish_tasks(run, interrupts)
        except KeyboardInterrupt:
            return False
        finally:
            watch()
    if run.executor_error is not None and not interrupts.count:
        what = f"{type(run.executor_error).__name__}: {run.executor_error}"
        raise ExecutorLost(
            f"the executor was lost after {run.count} of {count} tasks ({what}): call again with a new one"
        ) from run.executor_error
    if run.errors and not interrupts.count:
        index, error = min(run.errors.items())
        raise failure(name(index), error) from error
    return not interrupts.count


def failure(name: str, error: BaseException) -> TaskFailure:
    """The error to raise where a task fails."""
    return TaskFailure(f"{name} failed with {type(error).__name__}: {error}")


class Chunk(NamedTuple):
    """What a worker hands back: the results of the first tasks of a chunk, and the seconds it took."""

    results: list[Any]
    seconds: float


def call_chunk(function: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> Chunk:
    """Call a function on tasks, one after another, in a worker.

    An error that could not be read where it arrives would end a pool of processes, and one that says that an
    executor was lost would be taken for that.  So both come as a RuntimeError with their text, the first only
    from a process of a pool.
    """
    ignore_interrupts_in_worker()
    IN_TASK.set(True)
    results: list[Any] = []
    begun = monotonic()
    for task in tasks:
        try:
            results.append(function(*task))
        except Exception as error:
            lost = isinstance(error, (BrokenExecutor, CancelledError))
            if lost or (parent_process() is not None and not _can_be_sent(error)):
                raise RuntimeError(f"{type(error).__name__}: {error}") from None
            raise
        if monotonic() - begun > LONGEST_CHUNK_TIME:
            break
    return Chunk(results, monotonic() - begun)


def _can_be_sent(error: Exception) -> bool:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # whatever its class does when it is made again
        return False
    return True


class _Run:
    """Tasks that are left, chunks that are running, and failures."""

    def __init__(
        self,
        function: Callable[..., Any],
        tasks: Sequence[tuple[Any, ...]],
        keep: Callable[[int, Any], None],
        left: deque[int],
        pool: Executor,
        workers: Callable[[], int],
        chunk_time: float,
        bar: Any,
        parts: Callable[[int], int],
    ) -> None:
        self.errors: dict[int, BaseException] = {}
        self.executor_error: BaseException | None = None  # what the executor said where it was lost
        self.count = 0  # of parts that are done
        self.chunks: dict[Future[Chunk], list[int]] = {}
        self._function, self._tasks, self._keep, self._left = function, tasks, keep, left
        self._pool, self._workers, self._chunk_time = pool, workers, chunk_time
        self._bar, self._parts = bar, parts
        self._arrived: SimpleQueue[Future[Chunk]] = SimpleQueue()
        self._size, self._waiting = 1, False
        self._alone = 0  # tasks of a chunk that failed, to be done one by one

    def submit(self) -> bool:
        """Hand chunks to the executor until it has enough; returns whether any are running."""
        workers = self._workers()
        while self._left and len(self.chunks) < CHUNKS_PER_WORKER * max(workers, 1):
            even = -(-len(self._left) // (CHUNKS_PER_WORKER * max(workers, 1)))
            chunk = [self._left.popleft() for _ in range(min(self._size, even, len(self._left)))]
            try:
                future = self._pool.submit(call_chunk, self._function, [self._tasks[i] for i in chunk])
            except (RuntimeError, OSError, CancelledError) as error:  # a broken or closed executor
                self._left.extendleft(reversed(chunk))
                self.executor_error = self.executor_error or error
                return False
            self.chunks[future] = chunk
            future.add_done_callback(self._arrived.put)
        if (workers == 0) != self._waiting:
            self._waiting = workers == 0
            self._bar.set_postfix_str(NO_WORKER if self._waiting else "")
        return bool(self.chunks)

    def collect(self, patience: float) -> None:
        """Keep the results that have arrived, waiting for so many seconds at most if there are none."""
        with suppress(Empty):
            self._take(self._arrived.get(timeout=patience) if patience else self._arrived.get_nowait())
            while True:
                self._take(self._arrived.get_nowait())

    def _take(self, future: Future[Chunk]) -> None:
        chunk = self.chunks.pop(future, None)
        if chunk is None:
            return
        error = (
            CancelledError("its tasks were cancelled, as where a scheduler ends")
            if future.cancelled()
            else future.exception()
        )
        if isinstance(error, (BrokenExecutor, CancelledError)):
            self.executor_error = self.executor_error or error
            return
        if error is not None and len(chunk) > 1:  # which of them failed, or cannot be sent, shows one by one
            self._alone, self._size = len(chunk), 1
            self._left.extendleft(reversed(chunk))
            return
        if error is not None:
            self.errors[chunk[0]] = error
            return
        results, seconds = future.result()
        for index, result in zip(chunk, results):
            self._keep(index, result)
        self._left.extendleft(reversed(chunk[len(results) :]))
        done = sum(map(self._parts, chunk[: len(results)]))
        self.count += done
        self._bar.update(done)
        self._alone -= len(results)
        if self._chunk_time and self._alone <= 0:
            longest = int(self._chunk_time * len(results) / max(seconds, 1e-9))
            self._size = max(1, min(longest, MAX_CHUNK_SIZE))

    def cancel(self) -> None:
        """Take back the chunks that have not begun."""
        for future in [f for f in self.chunks if f.cancel()]:
            del self.chunks[future]


def _finish_tasks(run: _Run, interrupts: InterruptCounter) -> None:
    """Collect the results of tasks that have begun; after ctrl-C, tell the user of the wait."""
    since, has_warned = monotonic(), False
    if run.executor_error is not None:  # what is still running may never end
        run.collect(0.0)
        return
    while run.chunks and interrupts.count < LEAVING_PRESS:
        if interrupts.count and not has_warned and monotonic() - since > SILENT_TIME:
            count = len(run.chunks)
            tasks = "the task that has" if count == 1 else f"the {count} tasks that have"
            tell(f"ctrl-C: waiting for {tasks} begun; press it again to leave what is not done")
            has_warned = True
        run.collect(POLL_TIME)
    run.collect(0.0)  # what arrived with the last press


def thread_count(workers: int | None) -> int:
    """The number of threads: one for each processor that this process may use where none is given."""
    allowed = getattr(os, "sched_getaffinity", None)  # a batch system or taskset gives a job some of them
    return workers or (len(allowed(0)) if allowed else os.cpu_count()) or 1


def worker_count(execution: Execution) -> int:
    """How many tasks are computed at once; many where an executor does not tell, or has none yet."""
    if execution.executor is None:
        return thread_count(execution.workers)
    return _Workers(execution.executor, execution.workers)() or MANY_WORKERS


@contextmanager
def worker_threads(workers: int) -> Iterator[tuple[Executor, threading.Event]]:
    """Threads, and the sign at which their runs stop.  An error sets it; no thread is awaited then."""
    sign = threading.Event()
    pool = ThreadPoolExecutor(workers, initializer=STOP_SIGN.set, initargs=(sign,))
    try:
        yield pool, sign
    except BaseException:
        sign.set()
        raise
    finally:
        pool.shutdown(wait=not sign.is_set(), cancel_futures=True)


@contextmanager
def _executor(
    execution: Execution, interrupts: InterruptCounter
) -> Iterator[tuple[Executor, Callable[[], int], float]]:
    """The executor, its number of workers, and the seconds that a chunk should take.

    A given executor is left open.  If there is none, it is one of threads, whose runs stop if they are
    abandoned.
    """
    if execution.executor is not None:
        yield execution.executor, _Workers(execution.executor, execution.workers), CHUNK_TIME
        return
    workers = thread_count(execution.workers)
    with worker_threads(workers) as (pool, sign):
        yield pool, lambda: workers, 0.0
        if interrupts.count >= LEAVING_PRESS:
            sign.set()


class _Workers:
    """How many workers an executor has, as far as it tells; a cluster's number changes."""

    def __init__(self, executor: Executor, count: int | None) -> None:
        fixed = (getattr(executor, name, None) for name in ("_max_workers", "num_workers"))  # of mpi4py
        self._count = count or next((n for n in fixed if isinstance(n, int)), MANY_WORKERS)
        self._client: Any = None if count else getattr(executor, "_client", None)  # of Dask
        self._asked = -WORKER_CHECK_TIME

    def __call__(self) -> int:
        """The number now, 0 where the executor says that none is left."""
        if hasattr(self._client, "nthreads") and monotonic() - self._asked > WORKER_CHECK_TIME:
            with suppress(Exception):  # a lost scheduler cancels what it was given, which is seen there
                self._count = sum(self._client.nthreads().values())
            self._asked = monotonic()
        return self._count


def ignore_interrupts_in_worker() -> None:
    """Ignore ctrl-C in a process of a pool: it reaches all processes of a terminal, and only the first
    handles it."""
    if parent_process() is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
