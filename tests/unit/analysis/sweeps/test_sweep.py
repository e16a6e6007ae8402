"""Sweeps of any function, and ablations."""

import re
import threading
import time
from dataclasses import dataclass, field
from functools import cached_property, partial
from threading import RLock
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import frictionlab as fl
from frictionlab.analysis.sweeps.function_name import function_name

MODEL = fl.SliderOnBelt()
QUIET = {"progress": False}


def product(model):
    return model.F * model.mu_k


def test_a_grid_of_two_parameters():
    found = fl.sweep(MODEL, product, {"F": [100.0, 200.0], "mu_k": [0.1, 0.2, 0.3]}, **QUIET)
    assert found.results.shape == (2, 3)
    assert np.allclose(found.to_array(), np.outer([100.0, 200.0], [0.1, 0.2, 0.3]))


def test_initial_states_are_the_last_axis():
    def first(model, start):
        return float(fl.simulate(model, 0.01, x0=start, progress=False).q[0, 0])

    state = np.full(10, 1e-3)
    found = fl.sweep(MODEL, first, {"mu_k": [0.1, 0.2]}, x0=("rest", "near", state), **QUIET)
    assert found.results.shape == (2, 3)
    near = [1.01 * fl.equilibrium(MODEL.replace(mu_k=v)).q[0] for v in (0.1, 0.2)]
    assert np.allclose(found.to_array(), [[0.0, near[0], 1e-3], [0.0, near[1], 1e-3]])
    assert found.to_dataframe().loc[(0.2, "state 2"), "result"] == 1e-3


def test_the_number_of_workers_changes_nothing():
    def wait_and_see(model):
        time.sleep(0.02 * (model.mu_k < 0.15))  # so that the first ends last
        return model.mu_k

    values = {"mu_k": np.linspace(0.1, 1.0, 10)}
    one, five = (fl.sweep(MODEL, wait_and_see, values, workers=n, **QUIET) for n in (1, 5))
    assert one.results.tolist() == five.results.tolist()


def test_tables():
    def several(model):
        return {"work": product(model), "large": model.F > 150}

    found = fl.sweep(MODEL, several, {"F": [100.0, 200.0], "mu_k": [0.1, 0.2]}, **QUIET)
    frame = found.to_dataframe()
    assert list(frame.columns) == ["work", "large"]
    assert frame.loc[(200.0, 0.1), "work"] == 20.0
    pytest.importorskip("xarray", reason="the extra data is not installed")
    table = found.to_xarray()
    assert dict(table.sizes) == {"F": 2, "mu_k": 2}
    assert float(table.work.sel(F=100.0, mu_k=0.2)) == 20.0
    assert fl.sweep(MODEL, product, {"F": [1.0]}, **QUIET).to_xarray()["result"].dims == ("F",)


def test_a_failure_names_its_values_and_loses_nothing(tmp_path):
    def fails_late(model):
        if model.mu_k == 0.5:
            raise ZeroDivisionError("oops")
        time.sleep(0.05)
        return model.mu_k

    path, values = tmp_path / "sweep.jsonl", {"F": [200.0], "mu_k": [0.1, 0.2, 0.5, 0.6, 0.7, 0.8]}
    with pytest.raises(
        RuntimeError, match=r"F = 200, mu_k = 0.5 failed with ZeroDivisionError: oops"
    ) as info:
        fl.sweep(MODEL, fails_late, values, workers=2, resume=path, **QUIET)
    assert isinstance(info.value.__cause__, ZeroDivisionError)
    kept = path.read_text().count('"task"')
    assert 2 <= kept < 6


def test_a_failure_of_a_bifurcation_names_the_value(monkeypatch):
    def broken(model, *args, **options):
        raise ValueError(f"no {model.mu_k}")

    for name in ("find_steady_state", "settle"):  # the latter for values whose transients run in a group
        monkeypatch.setattr(f"frictionlab.analysis.sweeps.bifurcation.{name}", broken)
    for x0 in ("rest", "continue"):
        with pytest.raises(RuntimeError, match=r"mu_k = 0.5 failed with ValueError: no 0.5"):
            fl.bifurcation(MODEL, "mu_k", [0.5, 0.6], x0, workers=1, **QUIET)


def test_what_a_file_cannot_hold_is_told(tmp_path):
    path = tmp_path / "sweep.jsonl"
    with pytest.raises(TypeError, match="results that resume keeps must be numbers"):
        fl.sweep(MODEL, fl.equilibrium, {"F": [200.0]}, resume=path, **QUIET)
    assert fl.sweep(MODEL, fl.equilibrium, {"F": [200.0]}, **QUIET).results[0].normal_force > 0
    numbers = fl.sweep(MODEL, lambda m: np.array([m.F]), {"F": [200.0]}, resume=tmp_path / "b", **QUIET)
    assert numbers.results.tolist() == [[200.0]]


def test_work_is_done_in_several_threads():
    def thread(model):
        time.sleep(0.05)
        return threading.get_ident()

    found = fl.sweep(MODEL, thread, {"mu_k": np.linspace(0.1, 1.0, 8)}, workers=4, **QUIET)
    assert 2 <= len(set(found.results)) <= 4


def normal_force(model):
    return fl.equilibrium(model).normal_force


@pytest.fixture(scope="module")
def forces():
    return fl.ablation(MODEL, normal_force, **QUIET)


def test_an_ablation_has_eight_scenes(forces):
    assert len(set(forces.without)) == len(list(forces)) == 8
    for left_out, model in zip(forces.without, forces.models, strict=True):
        assert model == MODEL.without(*left_out)
    assert forces.without[0] == ()
    assert set(forces.without[-1]) == {"cubic", "nonsmooth", "geometry"}


def test_results_by_what_is_left_out(forces):
    expected = normal_force(MODEL.without("cubic", "geometry"))
    assert forces["cubic", "geometry"] == forces["geometry", "cubic"] == expected
    assert forces["geometry"] == normal_force(MODEL.without("geometry")) != expected
    assert forces[()] == normal_force(MODEL) != expected
    with pytest.raises(KeyError, match="no switch 'geomtry': name one of cubic, nonsmooth, geometry"):
        forces["geomtry"]


def test_a_study_that_fails_names_its_scene():
    def no_geometry(model):
        if "phi" not in model.coordinates:
            raise ZeroDivisionError("oops")

    with pytest.raises(RuntimeError, match=r"the scene without geometry failed with ZeroDivisionError: oops"):
        fl.ablation(MODEL, no_geometry, workers=1, **QUIET)


def times(model, factor):
    return factor * model.F


def scaled(factor):
    return lambda model: factor * model.F


def at_key(factor):
    def force(model, *, factor=factor):
        return factor * model.F

    return force


def written(docstring):
    found = {}
    exec(f"def force(model): '{docstring}'; return model.F", found)
    return found["force"]


def calls_itself(factor):
    def force(model, again=True):
        return force(model, False) if again else factor * model.F

    return force


@dataclass(frozen=True)
class Force:
    factor: Any = field(repr=False)

    def __call__(self, model):
        return 1.0

    def method(self, model):
        return 1.0


@dataclass
class Weighted:
    weight: Any

    def __call__(self, model):
        return 1.0


class Ordinary:
    def __init__(self, factor=1.0):
        self.factor, self.whole = factor, self

    @cached_property
    def total(self):
        return 1.0


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (lambda m: m.F, lambda m: 2 * m.F),
        (partial(times, factor=1), partial(times, factor=2)),
        (scaled(1), scaled(2)),
        (fl.ModeFrequency(0), fl.ModeFrequency(1)),
        (at_key(1), at_key(2)),
        (calls_itself(1), calls_itself(2)),
        (Force(1).method, Force(2).method),
        (Force(lambda m: m.F), Force(lambda m: 2 * m.F)),
        (Force(np.arange(5000)), Force(np.arange(5000) // 4999)),
        *(
            (Force(one), Force(other))
            for one, other in [((1,), (2,)), (b"1", b"2"), (1, True), (np.sin, np.cos)]
        ),
        *(
            (Weighted(one), Weighted(other))
            for one, other in [(1.0, 5.0), ([1], [2]), ({0: 1}, {0: 2}), ({"a"}, {"b"})]
        ),
        tuple(Force(partial(times, factor={"a": weight})) for weight in (1.0, 5.0)),
        (Force(Ordinary(1.0)), Force(Ordinary(2.0))),
        (Force(re.compile("a")), Force(re.compile("b"))),
        tuple(Force(CubicSpline([0.0, 1.0, 2.0], [0.0, 1.0, end])) for end in (1.0, 2.0)),
        (Force(frozenset("a")), Force(frozenset("b"))),
        (Force(MODEL), Force(MODEL.replace(F=1.0))),
        (Force(RLock()), Force(None)),
    ],
)
def test_a_file_of_another_function_of_that_name_is_refused(one, other, tmp_path):
    path = tmp_path / "results"
    first = fl.sweep(MODEL, one, {"F": [200.0]}, resume=path, **QUIET).results
    assert fl.sweep(MODEL, one, {"F": [200.0]}, resume=path, **QUIET).results == first
    with pytest.raises(ValueError, match="differs in function: give another path"):
        fl.sweep(MODEL, other, {"F": [200.0]}, resume=path, **QUIET)


def test_equal_functions_have_equal_names():
    """Wherever what they hold is in memory, and in whatever order a set holds it."""
    one, other = (
        scaled([set(some), lambda m: m.F, np.ones(3), MODEL, Force(RLock()), Ordinary()])
        for some in ([0, 8], [8, 0])
    )
    assert function_name(one) == function_name(other)
    assert function_name(written("the force")) == function_name(written("the preload"))


@pytest.mark.parametrize(
    ("held", "change"),
    [
        (np.random.default_rng(1), lambda held: held.random()),
        (Ordinary(), lambda held: held.total),
    ],
)
def test_random_numbers_and_cached_properties_do_not_count(held, change):
    before = function_name(scaled(held))
    change(held)
    assert function_name(scaled(held)) == before


@pytest.mark.parametrize(
    ("held", "change"),
    [([1], lambda held: held.append(2)), ({0: 1}, lambda held: held.update({0: 2}))],
)
def test_a_function_that_changes_what_it_holds_is_refused_with_the_cure(held, change, tmp_path):
    def force(model):
        change(held)
        return model.F

    fl.sweep(MODEL, force, {"F": [200.0]}, resume=tmp_path / "results", **QUIET)
    text = "or what it holds has changed, such as a list or a cache: make these anew before each call"
    with pytest.raises(ValueError, match=text):
        fl.sweep(MODEL, force, {"F": [200.0]}, resume=tmp_path / "results", **QUIET)


def test_runs_count_without_the_time_that_they_took():
    one, again, other = (
        function_name(scaled(fl.simulate(MODEL.replace(F=F), 0.01, progress=False))) for F in (1.0, 1.0, 2.0)
    )
    assert one == again != other


def test_a_function_whose_closure_is_not_complete_has_a_name():
    def force(model):
        return later(model)

    name = function_name(force)
    later = product
    assert name != function_name(force)
