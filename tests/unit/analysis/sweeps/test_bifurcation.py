"""Sweeps of steady states: the same by whatever workers, hysteresis, tables, refusals."""

import json
import signal
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.steady_state.steady_state import settle
from frictionlab.analysis.sweeps import tasks
from frictionlab.analysis.sweeps.bifurcation import MAX_SECTION_POINTS, bifurcation_from_results
from frictionlab.analysis.sweeps.journal import write_journal
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.interruption import STOP_SIGN
from tests.helpers.cases import slow_but

FLAT = fl.SliderOnBelt().without("geometry")
VALUES = [0.3, 0.5, 1.4, 2.9]
SHORT = {"transient": 40.0, "window": 20.0, "progress": False}


@pytest.fixture(scope="module")
def one_worker(tmp_path_factory):
    return fl.bifurcation(FLAT, "mu_k", VALUES, workers=1, **SHORT)


def damped_oscillator():
    x, y, k = sp.symbols("x y k")
    return HybridAutomaton((x, y), (Mode("m", (y, -k * x - y / 10)),), {k: 1.0}, coordinates=1)


def same(found, expected):
    return json.dumps(found.results, sort_keys=True) == json.dumps(expected.results, sort_keys=True)


@pytest.mark.parametrize("workers", slow_but([2], [2, 5, None]))
def test_the_number_of_workers_changes_nothing(one_worker, workers, tmp_path):
    path = tmp_path / "sweep.jsonl"
    found = fl.bifurcation(FLAT, "mu_k", VALUES, workers=workers, resume=path, **SHORT)
    assert same(found, one_worker)
    assert path.read_bytes() == one_worker.save(tmp_path / "saved").read_bytes()


@pytest.mark.slow
def test_processes_give_the_same(one_worker):
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert same(fl.bifurcation(FLAT, "mu_k", VALUES, executor=pool, **SHORT), one_worker)


@pytest.mark.slow
def test_a_cluster_gives_the_same(one_worker):
    distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        found = fl.bifurcation(FLAT, "mu_k", VALUES, executor=client.get_executor(), **SHORT)
    assert same(found, one_worker)


def test_values_are_those_of_steady_state(one_worker):
    alone = fl.steady_state(FLAT.replace(mu_k=1.4), **SHORT)
    assert one_worker.kinds[2] == alone.kind == "periodic"
    assert one_worker.periods[2] == alone.period
    assert one_worker.intensities[2] == alone.intensity
    assert one_worker.onsets[2] == 1
    assert np.array_equal(one_worker.sections[2], alone.section.state[-MAX_SECTION_POINTS:])
    assert {k: v[2] for k, v in one_worker.shares.items()} == dict(alone.time_in_mode)


def test_up_and_down_shows_hysteresis():
    up, down = [0.3, 0.5, 0.7, 2.1], [0.7, 0.5, 0.3]
    long = {"transient": 180.0, "window": 20.0, "progress": False}
    found = fl.bifurcation(FLAT, "mu_k", up + down, "continue", **long)
    assert found.kinds[:3] == ("equilibrium",) * 3
    assert found.kinds[3:] == ("periodic",) * 4
    assert fl.critical_value(FLAT, "mu_k", (0.0, 3.0)) == pytest.approx(2.0, abs=0.1)
    onward = fl.steady_state(FLAT.replace(mu_k=0.5), np.array(found.results[0]["final"]), **long)
    assert np.array_equal(onward.trajectory.final_state, found.results[1]["final"])


def test_section_points_for_a_scatter_plot(one_worker):
    values, states = one_worker.section("x1")
    moving = [len(s) for s, kind in zip(one_worker.sections, one_worker.kinds) if kind != "equilibrium"]
    assert len(values) == len(states) == sum(moving)
    assert set(one_worker.section("x1", "periodic")[0]) <= {0.5, 1.4, 2.9}
    assert len(one_worker.section("x1", "non-periodic")[0]) == 0
    with pytest.raises(ValueError, match="name must be one of 'x1'"):
        one_worker.section("x7")


def test_equilibria_are_points_of_their_own():
    found = fl.bifurcation(FLAT, "mu_k", [0.2, 0.3], "near", transient=150.0, window=20.0)
    values, states = found.section("y1", "equilibrium")
    assert values.tolist() == [0.2, 0.3]
    expected = [fl.equilibrium(FLAT.replace(mu_k=v)).q[1] for v in values]
    assert np.allclose(states, expected, rtol=1e-4)
    assert len(found.section("y1")[0]) == 0


def test_tables(one_worker):
    frame = one_worker.to_dataframe()
    assert frame.index.name == "mu_k"
    assert frame.index.tolist() == VALUES
    assert frame["kind"].tolist() == list(one_worker.kinds)
    assert np.allclose(frame[["stick", "slip+", "slip-", "separation"]].sum(axis=1), 1.0)
    xarray = pytest.importorskip("xarray", reason="the extra data is not installed")
    table = one_worker.to_xarray()
    assert isinstance(table, xarray.Dataset)
    assert float(table.intensity.sel(mu_k=1.4)) == one_worker.intensities[2]
    assert float(table.share.sel(mu_k=1.4, mode="stick")) == one_worker.shares["stick"][2]
    states = table.section.sel(mu_k=1.4, state="x1").dropna("point")
    assert np.array_equal(states, one_worker.sections[2][:, 0])


def test_what_ends_early_is_said_and_hinders_nothing():
    linear = FLAT.without("cubic", "nonsmooth")
    found = fl.bifurcation(
        linear, "mu_k", [2.5, 0.3], "continue", transient=100.0, window=10.0, progress=False
    )
    assert found.kinds[0] == "ended early"
    assert found.kinds[1] in ("not settled yet", "equilibrium")
    assert np.isnan(found.intensities[0])


@pytest.mark.parametrize(
    ("model", "parameter", "x0", "transient"),
    [
        (fl.ImpactOscillator(), "Omega", "rest", 40.0),
        (fl.SliderOnBelt().without("nonsmooth", "geometry"), "mu_k", "near", 2.0),
        # modes of its own
        (fl.Structure([("m", [[1.0]])], [[1.0]], [[0.1]], parameters={"m": 2.0}), "m", "near", 2.0),
        (damped_oscillator(), "k", [1.0, 0.0], 200.0),  # at rest, judged by what it was in the transient
    ],
)
def test_values_side_by_side_give_what_each_gives_alone(model, parameter, x0, transient):
    """Transients run in groups; whether a value is in one makes no difference."""
    values = np.linspace(0.2, 1.0, 18)
    options = {"x0": x0, "transient": transient, "window": 20.0, "progress": False}
    together = fl.bifurcation(model, parameter, values, **options)
    for i in (0, 7, 17):
        alone = fl.bifurcation(model, parameter, values[i : i + 1], **options)
        assert alone.results[0] == together.results[i]


def test_a_value_that_fails_among_others_is_named_and_the_others_are_kept(monkeypatch, tmp_path):
    def fails_once(model, *arguments, **options):
        if model.parameters["mu_k"] == 1.4:
            raise ArithmeticError("by design")
        return settle(model, *arguments, **options)

    monkeypatch.setattr("frictionlab.analysis.steady_state.steady_state.settle", fails_once)
    monkeypatch.setattr("frictionlab.analysis.sweeps.bifurcation.settle", fails_once)
    options = {"transient": 2.0, "window": 2.0, "progress": False, "workers": 1}
    with pytest.raises(RuntimeError, match=r"^mu_k = 1\.4 failed with ArithmeticError: by design"):
        fl.bifurcation(FLAT, "mu_k", VALUES, resume=tmp_path / "sweep.jsonl", **options)
    assert set(fl.load_bifurcation(tmp_path / "sweep.jsonl").results) >= {0, 1}


def test_values_that_go_on_begin_where_their_group_ended(monkeypatch):
    options = {"transient": 5.0, "window": 5.0, "t_max": 60.0, "progress": False, "workers": 1}
    alone = [fl.bifurcation(FLAT, "mu_k", [value], **options) for value in VALUES]
    assert fl.bifurcation(FLAT, "mu_k", VALUES, **options | {"t_max": None}).kinds[0] == "not settled yet"
    monkeypatch.delattr("frictionlab.analysis.sweeps.bifurcation.run_transient")
    together = fl.bifurcation(FLAT, "mu_k", VALUES, **options)
    assert [*together.results.values()] == [one.results[0] for one in alone]


def test_a_second_ctrl_c_leaves_what_a_group_has_done(monkeypatch, tmp_path):
    """And a third one, pressed while the result is made, does not leave an earlier partial result."""

    def press_at_third(model, *arguments, **options):
        if model.parameters["mu_k"] == VALUES[2]:
            for patience in (0.3, 10.0):
                signal.raise_signal(signal.SIGINT)
                STOP_SIGN.get().wait(patience)
        return settle(model, *arguments, **options)

    def pressed(specification, results):
        signal.raise_signal(signal.SIGINT)
        return bifurcation_from_results(specification, results)

    monkeypatch.setattr("frictionlab.analysis.sweeps.bifurcation.settle", press_at_third)
    monkeypatch.setattr("frictionlab.analysis.sweeps.bifurcation.bifurcation_from_results", pressed)
    options = {"transient": 2.0, "window": 2.0, "progress": False, "workers": 1}
    with pytest.raises(KeyboardInterrupt, match="stopped after 2 of 4 tasks"):
        fl.bifurcation(FLAT, "mu_k", VALUES, resume=tmp_path / "sweep.jsonl", **options)
    monkeypatch.undo()
    assert set(fl.partial_result().results) == {0, 1}
    assert set(fl.load_bifurcation(tmp_path / "sweep.jsonl").results) == {0, 1}


def test_ctrl_c_while_the_file_is_written_first_leaves_a_result_without_values(monkeypatch, tmp_path):
    def pressed(*arguments):
        signal.raise_signal(signal.SIGINT)
        return write_journal(*arguments)

    options = {"transient": 2.0, "window": 2.0, "progress": False, "resume": tmp_path / "sweep.jsonl"}
    with monkeypatch.context() as patch:
        patch.setattr("frictionlab.analysis.sweeps.journal.write_journal", pressed)
        with pytest.raises(KeyboardInterrupt, match="stopped after 0 of 4 tasks"):
            fl.bifurcation(FLAT, "mu_k", VALUES, **options)
    assert set(fl.partial_result().kinds) == {""}
    assert "" not in fl.bifurcation(FLAT, "mu_k", VALUES, **options).kinds


class Pool(ThreadPoolExecutor):
    """Counts what it is given, and is lost where it is given more."""

    def __init__(self, workers, most=1000):
        super().__init__(workers)
        self.count, self.most = 0, most

    def submit(self, *task):
        if self.count == self.most:
            raise BrokenExecutor("a worker died")
        self.count += 1
        return super().submit(*task)


def test_each_worker_of_an_executor_has_values_to_compute(monkeypatch):
    shown = []
    bar = SimpleNamespace(update=shown.append, set_postfix_str=lambda _: None, close=lambda: None)
    monkeypatch.setattr(tasks, "progress_bar", lambda total, **_: shown.append(-total) or bar)
    with Pool(3) as pool:
        found = fl.bifurcation(fl.MassOnBelt(), "mu_k", np.linspace(0.1, 0.4, 6), executor=pool, **SHORT)
    assert (pool.count, len(found.results)) == (3, 6)
    assert (shown[0], sum(shown)) == (-6, 0)  # the bar counts values


def test_a_method_derived_from_taylor_runs_all_by_itself():
    lengths = []

    class Noted(fl.Taylor):
        def integrate(self, problem, *others):
            lengths.append(problem.t_end)
            return super().integrate(problem, *others)

    fl.bifurcation(fl.MassOnBelt(), "mu_k", [0.1, 0.2, 0.3, 0.4], method=Noted(), workers=1, **SHORT)
    assert lengths == [SHORT["transient"], SHORT["window"]] * 4


def test_an_executor_that_is_lost_is_not_tried_again():
    with (
        Pool(2, 1) as pool,
        pytest.raises(RuntimeError, match=r"executor was lost after \d+ of 40 tasks \(BrokenExecutor: a "),
    ):
        fl.bifurcation(fl.MassOnBelt(), "mu_k", np.linspace(0.1, 0.4, 40), executor=pool, **SHORT)


@pytest.mark.slow
def test_values_that_have_not_settled_go_on_as_in_steady_state(tmp_path):
    smooth = fl.SliderOnBelt().without("nonsmooth", "geometry")
    path, values = tmp_path / "sweep.jsonl", [0.3, 1.5]
    options = {"transient": 10.0, "window": 20.0, "progress": False}
    short = fl.bifurcation(smooth, "mu_k", values, **options)
    long = fl.bifurcation(smooth, "mu_k", values, t_max=300.0, resume=path, **options)
    alone = [fl.steady_state(smooth.replace(mu_k=v), t_max=300.0, **options) for v in values]
    assert short.kinds == ("not settled yet",) * 2
    assert long.kinds == tuple(found.kind for found in alone) == ("equilibrium",) * 2
    assert [r["final"] for r in long.results.values()] == [a.trajectory.final_state.tolist() for a in alone]
    assert len({found.transient for found in alone}) > 1
    with pytest.raises(ValueError, match="differs in t_max"):
        fl.bifurcation(smooth, "mu_k", values, t_max=200.0, resume=path, **options)


def test_modes_are_those_of_all_values():
    """Of modes that are derived on demand each value knows its own."""
    row = {"kind": "periodic", "period": 1.0, "onsets": 0, "intensity": 0.0, "section": [], "final": [0.0]}
    ended = {**row, "kind": "ended early", "shares": {}}
    rows = {0: row | {"shares": {"slip": 1.0}}, 1: row | {"shares": {"slip": 0.25, "stick": 0.75}}, 2: ended}
    specification = {"parameter": "p", "values": [1.0, 2.0, 3.0, 4.0], "states": ["x"]}
    shares = bifurcation_from_results(specification, rows).shares
    np.testing.assert_equal(
        shares, {"slip": [1.0, 0.25, np.nan, np.nan], "stick": [0.0, 0.75, np.nan, np.nan]}
    )
