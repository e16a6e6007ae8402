"""Many tasks: in chunks, in shards, in executors that are lost."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from types import SimpleNamespace

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.analysis.options import Execution
from frictionlab.analysis.sweeps import tasks as module
from frictionlab.analysis.sweeps.tasks import MANY_WORKERS, TaskFailure, run_tasks, worker_count
from frictionlab.partial_results import keep_partial_result
from tests.helpers import killed_cluster

MODEL = fl.SliderOnBelt()
QUIET = {"progress": False}
GRID = {"mu_k": np.linspace(0.1, 1.0, 7), "F": [100.0, 200.0]}


def friction(model):
    return {"friction": model.F * model.mu_k}


class CountingPool(ThreadPoolExecutor):
    """Two threads, and how many chunks they had to do at a time."""

    def __init__(self):
        super().__init__(2)
        self.submitted, self.left, self.most, self._counting = 0, 0, 0, threading.Lock()

    def submit(self, function, /, *arguments, **keywords):
        with self._counting:
            self.submitted, self.left = self.submitted + 1, self.left + 1
            self.most = max(self.most, self.left)
        future = super().submit(function, *arguments, **keywords)
        future.add_done_callback(self._ended)
        return future

    def _ended(self, future):
        with self._counting:
            self.left -= 1


def run(function, count, executor, results, **options):
    """Run the tasks, put what they give into `results`, return whether all were done."""
    about = {"name": "task {}".format, "execution": Execution(executor=executor, progress=False)}
    return run_tasks(function, [(i,) for i in range(count)], keep=results.__setitem__, **about, **options)


def test_many_short_tasks_are_few_chunks_of_which_each_worker_has_two():
    results = {}
    with CountingPool() as pool:
        assert run(abs, 20_000, pool, results)
    assert results == {i: i for i in range(20_000)}
    assert pool.submitted < 100
    assert pool.most <= 4


def test_only_the_tasks_asked_for_are_done():
    results = {}
    with CountingPool() as pool:
        assert run(abs, 100, pool, results, todo=range(3, 100, 10))
    assert results == {i: i for i in range(3, 100, 10)}


def fails_late(i):
    if i == 7_777:
        raise ZeroDivisionError("oops")
    return i


def cannot_be_sent(i):
    return (lambda: i) if i == 7_777 else i


class SendingPool(CountingPool):
    """Threads that send results as processes do."""

    def submit(self, function, /, *arguments, **keywords):
        return super().submit(lambda: pickle.loads(pickle.dumps(function(*arguments, **keywords))))


@pytest.mark.parametrize(
    ("function", "pool", "error"),
    [(fails_late, CountingPool, "ZeroDivisionError"), (cannot_be_sent, SendingPool, "")],
)
def test_a_task_that_fails_within_a_chunk_is_named_and_loses_none_before_it(function, pool, error):
    results = {}
    with pool() as workers, pytest.raises(TaskFailure, match=f"task 7777 failed with {error}"):
        run(function, 20_000, workers, results)
    assert 7_777 not in results
    assert set(range(7_000)) <= set(results)


class TwoArguments(Exception):
    """An error that cannot be made again from its text."""

    def __init__(self, text, number):
        super().__init__(text)


def two_arguments(i):
    """Of the module, so that other processes find it."""
    if i == 5:
        raise TwoArguments("oops", 1)
    return i


@pytest.mark.slow
def test_an_error_that_cannot_be_sent_is_that_of_its_task_and_ends_no_pool_of_processes():
    results = {}
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        with pytest.raises(TaskFailure, match="task 5 failed with RuntimeError: TwoArguments: oops"):
            run(two_arguments, 10, pool, results)
        assert pool.submit(abs, -1).result() == 1
    assert set(range(5)) <= set(results)


def test_an_error_that_tells_of_an_executor_is_that_of_its_task():
    def fails(i):
        raise BrokenExecutor("oops")

    with (
        CountingPool() as pool,
        pytest.raises(TaskFailure, match=r"task 0 failed with .*BrokenExecutor: oops"),
    ):
        run(fails, 1, pool, {})


def test_after_a_failure_that_does_not_come_again_chunks_grow_again():
    calls = []

    def fails_once(i):
        calls.append(i)
        if i == 7_777 and calls.count(i) == 1:
            raise MemoryError
        return i

    results = {}
    with CountingPool() as pool:
        assert run(fails_once, 40_000, pool, results)
    assert results == {i: i for i in range(40_000)}
    assert pool.submitted < 12_000


def test_a_chunk_that_takes_long_is_handed_back(monkeypatch):
    monkeypatch.setattr(module, "LONGEST_CHUNK_TIME", 0.01)

    def longer(i):
        time.sleep(0.005 if i > 50 else 0.0)
        return i

    results = {}
    with CountingPool() as pool:
        assert run(longer, 80, pool, results)
    assert results == {i: i for i in range(80)}
    assert pool.submitted > 8


class LostExecutor(Executor):
    """Does a number of chunks, and is then gone: what it is given is cancelled, broken or refused."""

    def __init__(self, lasts, end):
        self._lasts, self._end = lasts, end

    def submit(self, function, /, *arguments, **keywords):
        future = Future()
        self._lasts -= 1
        if self._lasts >= 0:
            future.set_result(function(*arguments))
        elif self._end == "cancelled":
            future.cancel()
        elif self._end == "broken":
            future.set_exception(BrokenExecutor("a process was terminated abruptly"))
        else:
            raise RuntimeError("cannot schedule new futures after shutdown")
        return future


@pytest.mark.parametrize("end", ["cancelled", "broken", "refused"])
def test_a_lost_executor_is_named_and_what_was_done_is_kept(tmp_path, end):
    path = tmp_path / "sweep.jsonl"
    with pytest.raises(RuntimeError, match=r"executor was lost after \d+ of 14 tasks") as info:
        fl.sweep(MODEL, friction, GRID, executor=LostExecutor(3, end), resume=path, **QUIET)
    assert "frictionlab.partial_result() is what there is; resume=" in str(info.value)
    part = fl.partial_result()
    done = sum(result is not None for result in part.results.ravel())
    assert 0 < done == path.read_text().count('"task"') < 14
    again = fl.sweep(MODEL, friction, GRID, resume=path, **QUIET)
    assert again.to_dataframe().equals(fl.sweep(MODEL, friction, GRID, **QUIET).to_dataframe())


def test_a_bar_that_stands_still_says_that_no_worker_is_left(monkeypatch):
    said, workers = [], [{"a": 1}, {}, {}, {"b": 1}]
    monkeypatch.setattr(module, "WORKER_CHECK_TIME", 0.0)

    class Cluster(ThreadPoolExecutor):
        _client = SimpleNamespace(nthreads=lambda: workers.pop(0) if len(workers) > 1 else workers[0])

    bar = SimpleNamespace(update=lambda n: None, set_postfix_str=said.append, close=lambda: None)
    monkeypatch.setattr(module, "progress_bar", lambda **_: bar)
    with Cluster(1) as pool:
        run(lambda i: time.sleep(0.15), 6, pool, {})
    assert said == [module.NO_WORKER, ""]


CALLS = []


def counted(model):
    CALLS.append(model)
    return friction(model)


def test_shards_are_jobs_of_their_own_and_make_up_the_whole(tmp_path):
    path, whole = tmp_path / "sweep.jsonl", tmp_path / "whole.jsonl"
    expected = fl.sweep(MODEL, counted, GRID, resume=whole, **QUIET)
    for i in (2, 0):
        part = fl.sweep(MODEL, counted, GRID, shard=(i, 3), resume=path, **QUIET)
        done = [k for k, result in enumerate(part.results.ravel()) if result is not None]
        assert done == list(range(i, 14, 3))
    assert sorted(p.name for p in tmp_path.glob("*.jsonl")) == [
        "sweep.0-of-3.jsonl",
        "sweep.2-of-3.jsonl",
        "whole.jsonl",
    ]
    CALLS.clear()
    assert fl.sweep(MODEL, counted, GRID, resume=path, **QUIET).to_dataframe().equals(expected.to_dataframe())
    assert len(CALLS) == len(range(1, 14, 3))
    assert path.read_bytes() == whole.read_bytes()


@pytest.mark.parametrize(
    ("shard", "message"),
    [
        ((3, 3), r"shard\[0\] must be .*below 3"),
        ((-1, 3), r"shard\[0\]"),
        ((0, 0), r"shard\[1\] must be"),
        ((1,), "shard must be an index and a number of jobs"),
        (1, "shard must be"),
    ],
)
def test_a_bad_shard_is_refused(shard, message):
    with pytest.raises((TypeError, ValueError), match=message):
        fl.sweep(MODEL, friction, GRID, shard=shard, **QUIET)


def test_shards_of_another_sweep_are_refused(tmp_path):
    path = tmp_path / "sweep.jsonl"
    fl.sweep(MODEL, friction, GRID, shard=(0, 2), resume=path, **QUIET)
    with pytest.raises(ValueError, match=r"sweep.0-of-2.jsonl differs in .*over"):
        fl.sweep(MODEL, friction, {"F": [1.0]}, resume=path, **QUIET)


def test_values_of_a_large_grid_are_checked_before_any_is_computed():
    calls = []
    with pytest.raises(ValueError, match="M must be greater than 0"):
        fl.sweep(MODEL, calls.append, {"M": np.linspace(1.0, 0.0, 20_000)}, **QUIET)
    grid = {"mu_k": np.linspace(0.0, 2.0, 200), "mu_s": np.linspace(1.0, 3.0, 100)}
    with pytest.raises(ValueError, match="mu_s must be at least mu_k"):  # at a corner of the grid
        fl.sweep(MODEL, calls.append, grid, **QUIET)
    assert not calls


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["workers", "scheduler"])
def test_a_cluster_whose_processes_are_killed(tmp_path, lost):
    """Others take over from workers that are killed; after a scheduler's end another cluster goes on."""
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    grid = {"mu_k": np.linspace(0, 3, 100)}
    here = fl.sweep(MODEL, killed_cluster.friction, grid, resume=tmp_path / "here", **QUIET)
    script = [sys.executable, "-m", "tests.helpers.killed_cluster", str(tmp_path / "there"), lost]
    said = subprocess.run(script, capture_output=True, text=True, timeout=300, check=True).stdout
    assert ("the executor was lost after" in said) == (lost == "scheduler")
    assert here.results.size == 100
    assert (tmp_path / "there").read_bytes() == (tmp_path / "here").read_bytes()


def test_a_cluster_whose_jobs_have_not_begun_counts_as_many_workers():
    client = SimpleNamespace(nthreads=dict)
    cluster = SimpleNamespace(submit=print, _client=client)
    assert worker_count(Execution(executor=cluster)) == MANY_WORKERS
    client.nthreads = lambda: {"one": 2, "other": 1}
    assert worker_count(Execution(executor=cluster)) == 3


def test_a_process_has_no_more_threads_than_processors_that_it_may_use(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {5}, raising=False)
    assert worker_count(Execution()) == 1
    assert worker_count(Execution(workers=3)) == 3


class Pressed:
    """An argument while whose reading ctrl-C is pressed."""

    def __array__(self, dtype=None, copy=None):
        signal.raise_signal(signal.SIGINT)
        return np.array([1.0])


@pytest.mark.parametrize(
    "study",
    [
        lambda: fl.simulate(MODEL, 1.0, x0=Pressed()),
        lambda: fl.bifurcation(MODEL, "mu_k", Pressed()),
        lambda: fl.sweep(MODEL, friction, {"mu_k": Pressed()}),
    ],
    ids=["simulate", "bifurcation", "sweep"],
)
def test_ctrl_c_before_a_study_begins_leaves_no_earlier_result(study):
    keep_partial_result("of another study")
    with pytest.raises(KeyboardInterrupt):
        study()
    assert fl.partial_result() is None
