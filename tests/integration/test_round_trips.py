"""Results are the same after a copy, a pickle, and a way through another process."""

import copy
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from enum import Enum
from functools import cache

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.presentation import FrozenMapping
from tests.helpers import results
from tests.helpers.cases import slow_but
from tests.helpers.own_models import Chain, Fitted

MODEL = fl.MassOnBelt(c=0.05, mu_k=0.5, mu_s=1.0)
LISTED = [
    eval(row.call, {name: getattr(fl, name) for name in fl.__all__ if name[0].isupper()} | {"fl": fl})
    for row in fl.list_models("classics")
]
OWN = [Chain(masses=3, friction=Fitted()), fl.MassOnBelt(friction=Fitted(shares=(0.3,), pairs=(("x", 2),)))]
MODELS = {f"{type(model).__name__} {i}": model for i, model in enumerate([*LISTED, *OWN])}
WAYS = {
    "pickle": lambda result: pickle.loads(pickle.dumps(result)),
    "deepcopy": copy.deepcopy,
    "copy": copy.copy,
}
QUIET = {"progress": False}


def run_with_riders(t_eval=None):
    x, rate = MODEL.automaton().states
    more = {"sections": {"turns": rate}, "quadratures": {"square": x**2}}
    return fl.simulate(MODEL, 20.0, t_eval=t_eval, **more, **QUIET)


MORE = {
    "run with riders": run_with_riders,
    "run at times": lambda: run_with_riders(np.linspace(0.0, 20.0, 11)),
    "run of an automaton": lambda: fl.solve(MODEL.automaton(), 20.0, x0=[0.0, 0.0], **QUIET),
    "estimate": lambda: result("uncertainty").mean,
    "quantity": lambda: fl.CriticalValue("mu_k", (0.0, 4.0)),
    "fold": lambda: fl.FoldValue("F", (100.0, 6000.0)),
    "amplitude": lambda: fl.OrbitAmplitude("x"),
    "record": lambda: fl.TimeRecord([0.5, 1.0], {"x": [0.1, 0.2]}, error=0.1),
    "spectrum record": lambda: fl.SpectrumRecord([0.5, 1.0], [0.5], {"x": [0.1]}, error=0.1),
    "event times": lambda: fl.EventTimes([0.5, 1.0], "stick", 0.1),
    "frequencies": lambda: fl.Frequencies({0: 13.0}, 0.1),
    "switch": lambda: result("ablation").factors[0],
    "table of parameters": lambda: fl.SliderOnBelt().describe(),
    "table of models": fl.list_models,
    "status": lambda: result("run").status,
    "equations": lambda: MODEL.equations("stick"),
    "automaton": lambda: MODEL.automaton().derived(),  # that of the cache is copied as this one
    "automaton with a period": lambda: replace(MODEL.automaton().derived(), period=2.0).replace(v=0.5),
    "method": lambda: fl.Taylor(tol=1e-12),
}
BUILDERS = {name: make for name, make in results.BUILDERS.items() if "automaton" not in name} | MORE
# What is drawn, played or shown, and what others derive from; special orbits are tested where they are found.
NO_RESULTS = {"FrontEnd", "Explorer", "Result", "Sound", "Drawing", "Curve", "SpecialOrbit"}


@cache
def result(name):
    """The result of that name, computed once."""
    return MORE[name]() if name in MORE else results.result(name)


def public(result):
    """All public attributes that are data, in numbers and texts, those of results within too."""
    if isinstance(result, np.ndarray):
        return result.dtype.str, result.shape, result.tobytes() if result.dtype != object else result.tolist()
    if isinstance(result, (list, tuple)):
        return [public(item) for item in result]
    if isinstance(result, (dict, FrozenMapping)):
        return {name: public(value) for name, value in result.items()}
    names = [name for name in dir(result) if not name.startswith("_")]
    module = type(result).__module__ or ""  # classes that sympy makes have none
    if module.startswith("frictionlab.") and not isinstance(result, (fl.Model, Enum)):
        values = {name: getattr(result, name, None) for name in names if name not in SKIPPED}
        data = {name: value for name, value in values.items() if not callable(value) and value is not result}
        return {name: public(value) for name, value in data.items()}
    return repr(result)


# Expressions and compiled functions; how long it took.
SKIPPED = {"problem", "automaton", "normal_form", "stats", "wall_time"}


@pytest.mark.parametrize("way", slow_but(["pickle"], WAYS))  # the others go the same way
@pytest.mark.parametrize("name", BUILDERS)
def test_a_copy_is_the_same(name, way):
    given = result(name)
    other = WAYS[way](given)
    assert type(other) is type(given)
    if "at 0x" not in repr(given):
        assert repr(other) == repr(given)
    np.testing.assert_equal(public(other), public(given))


def test_an_automaton_from_the_cache_is_pickled_with_its_period():
    given = MODEL.replace(k=2.0).automaton()
    object.__setattr__(given.derived(), "period", 2.0)  # as a derivation may state it
    assert pickle.loads(pickle.dumps(given)).period == 2.0


def test_every_public_result_is_tested():
    """Each class of the package's names that can be drawn."""
    drawable = {name for name in fl.__all__ if hasattr(getattr(fl, name), "drawn_by")} - NO_RESULTS
    assert len(drawable) > 15
    assert drawable <= {type(result(name)).__name__ for name in BUILDERS}


@pytest.mark.parametrize(
    "name", ["run with riders", "run at times", "run of two contacts", "run of an automaton"]
)
def test_a_saved_run_is_the_same(name, tmp_path):
    given = result(name)
    other = fl.load(given.save(tmp_path / "run"))
    # a file may know of modes that were not derived elsewhere
    np.testing.assert_equal(public(other), public(given))
    assert other.save(tmp_path / "again").read_bytes() == given.save(tmp_path / "again").read_bytes()


SAVED = {"bifurcation": fl.load_bifurcation, "basins": fl.load_basins, "shares of basins": fl.load_basins}


@pytest.mark.parametrize("name", SAVED)
def test_a_saved_study_is_the_same(name, tmp_path):
    given = result(name)
    other = SAVED[name](given.save(tmp_path / "study"))
    assert type(other) is type(given)
    np.testing.assert_equal(public(other), public(given))
    assert other.save(tmp_path / "again").read_bytes() == (tmp_path / "study").read_bytes()


# --- models


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", MODELS)
def test_a_copied_model_is_the_same(name, way):
    model = MODELS[name]
    other = WAYS[way](model)
    assert (other, hash(other), repr(other)) == (model, hash(model), repr(model))
    assert other.automaton().modes is model.automaton().modes


@pytest.mark.parametrize("name", slow_but(["SliderOnBelt 0"], MODELS))
def test_the_run_of_a_model_is_the_same_from_its_file_and_from_a_pickle(name, tmp_path):
    model = MODELS[name]
    run = fl.simulate(model, 5 * model.period, **QUIET)
    for other in (fl.load(run.save(tmp_path / "run")), *(way(run) for way in WAYS.values())):
        assert other.source == model
        np.testing.assert_equal(public(other), public(run))
        for output in run.automaton.outputs:
            assert other[output].tobytes() == run[output].tobytes()


def ends_of(model):
    """The end and the events of a short run, as a process gives them back."""
    run = fl.simulate(model, 5 * model.period, **QUIET)
    return run, run.final_state.tobytes(), run.events.t.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("start", multiprocessing.get_all_start_methods())
def test_models_and_runs_pass_between_processes(start):
    """Every model there and its run back, bit-equal to the same run here."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(start)) as pool:
        for model, (run, *there) in zip(MODELS.values(), pool.map(ends_of, MODELS.values()), strict=True):
            here, *numbers = ends_of(model)
            assert there == numbers
            np.testing.assert_equal(public(run), public(here))


@pytest.mark.slow
@pytest.mark.parametrize("start", multiprocessing.get_all_start_methods())
def test_every_result_passes_between_processes(start):
    """There and back again."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(start)) as pool:
        given = [result(name) for name in BUILDERS]
        for one, other in zip(given, pool.map(itself, given), strict=True):
            np.testing.assert_equal(public(other), public(one))


def itself(result):
    return result


def test_an_unlisted_law_cannot_be_made_where_it_is_not_defined(tmp_path):
    """The message names it, and the file."""
    run = fl.simulate(OWN[1], 1.0, **QUIET)
    path = run.save(tmp_path / "run")
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    arrays["about"] = np.array(str(arrays["about"]).replace("own_models:Fitted", "own_models:Gone"))
    np.savez_compressed(path, **arrays)
    with pytest.raises(
        ValueError, match=r"own_models:Gone' is loaded: import tests\.helpers\.own_models"
    ) as caught:
        fl.load(path)
    assert str(path) in str(caught.value)
    assert fl.load(path, model=OWN[1]).states.tobytes() == run.states.tobytes()


def test_a_copied_run_answers_as_the_run_does():
    run = result("run with riders")
    other = pickle.loads(pickle.dumps(run))
    np.testing.assert_array_equal(other(np.linspace(0.0, 20.0, 77)), run(np.linspace(0.0, 20.0, 77)))
    assert other.defect == run.defect
    assert other.quadratures == run.quadratures
    assert fl.energy_audit(other, progress=False).error == fl.energy_audit(run, progress=False).error


def test_events_of_a_class_in_a_function_are_copied():
    """They carried the model, which pickle finds by its name only."""
    events = fl.simulate(type("Local", (fl.DenHartog,), {})(), 5.0).events
    assert pickle.loads(pickle.dumps(events)).units == events.units == ("m", "m/s", "rad")
