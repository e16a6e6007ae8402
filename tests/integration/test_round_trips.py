"""Results are the same after a copy, a pickle, and a way through another process."""

import copy
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from enum import Enum

import numpy as np
import pytest

import frictionlab as fl

MODEL = fl.MassOnBelt(c=0.05, mu_k=0.5, mu_s=1.0)
COPIES = {"pickle": lambda result: pickle.loads(pickle.dumps(result)), "copy": copy.deepcopy}


@pytest.fixture(scope="module")
def results():
    """One of each kind."""
    slider = fl.SliderOnBelt()
    x, rate = MODEL.automaton().states
    run = fl.simulate(MODEL, 20.0, sections={"turns": rate}, quadratures={"square": x**2}, progress=False)
    steady = fl.steady_state(MODEL, progress=False)
    values, forces = np.linspace(1.0, 2.0, 3), np.linspace(100.0, 200.0, 3)
    return {
        "run": run,
        "run of several contacts": fl.simulate(fl.TwoBlocks(), 5.0, progress=False),
        "energy audit": fl.energy_audit(run, progress=False),
        "verification": fl.verify(MODEL, 5.0, progress=False),
        "steady state": steady,
        "periodic orbit": fl.periodic_orbit(MODEL, steady),
        "ensemble": fl.ensemble([MODEL] * 3, 5.0, progress=False),
        "exponents": fl.lyapunov(MODEL, transient=5.0, t_end=20.0, blocks=2, progress=False),
        "tangent flow": fl.tangent_flow(run, progress=False),
        "equilibrium": fl.equilibrium(slider),
        "eigenvalues": fl.eigenvalues(slider),
        "Hopf point": fl.hopf(slider, "mu_k", bounds=(1.0, 3.0)),
        "locus": fl.root_locus(slider, "mu_k", values),
        "map": fl.stability_map(slider, ("mu_k", values), ("F", forces), progress=False),
        "bifurcation": fl.bifurcation(MODEL, "v", [0.5, 0.6], progress=False),
        "sweep": fl.sweep(MODEL, speed, {"v": [1.0, 2.0]}, progress=False),
    }


NAMES = (
    "run",
    "run of several contacts",
    "energy audit",
    "verification",
    "steady state",
    "periodic orbit",
    "ensemble",
    "exponents",
    "tangent flow",
    "equilibrium",
    "eigenvalues",
    "Hopf point",
    "locus",
    "map",
    "bifurcation",
    "sweep",
)


def speed(model):
    return model.v


def public(result):
    """All public attributes that are data, in numbers and texts, those of results within too."""
    if isinstance(result, np.ndarray):
        return result.dtype.str, result.shape, result.tobytes() if result.dtype != object else result.tolist()
    if isinstance(result, (list, tuple)):
        return [public(item) for item in result]
    if isinstance(result, (dict, fl.frozen_mapping.FrozenMapping)):
        return {name: public(value) for name, value in result.items()}
    names = [name for name in dir(result) if not name.startswith("_")]
    if type(result).__module__.startswith("frictionlab.") and not isinstance(result, (fl.Model, Enum)):
        values = {name: getattr(result, name, None) for name in names if name not in SKIPPED}
        return {name: public(value) for name, value in values.items() if not callable(value)}
    return repr(result)


SKIPPED = {"problem", "automaton", "normal_form"}  # expressions and compiled functions


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("name", NAMES)
def test_a_copy_is_the_same(results, name, way):
    result = results[name]
    other = COPIES[way](result)
    assert type(other) is type(result)
    assert repr(other) == repr(result)
    np.testing.assert_equal(public(other), public(result))


def test_every_kind_of_result_is_copied(results):
    assert tuple(results) == NAMES


def test_a_copied_run_answers_as_the_run_does(results):
    run = results["run"]
    other = pickle.loads(pickle.dumps(run))
    np.testing.assert_array_equal(other(np.linspace(0.0, 20.0, 77)), run(np.linspace(0.0, 20.0, 77)))
    assert other.defect == run.defect
    assert other.quadratures == run.quadratures
    assert fl.energy_audit(other, progress=False).error == fl.energy_audit(run, progress=False).error


@pytest.mark.slow
@pytest.mark.parametrize("start", multiprocessing.get_all_start_methods())
def test_processes_give_whole_results(start):
    """A steady state made in a process of its own, however that was begun."""
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(start)) as pool:
        found = fl.sweep(MODEL, fl.steady_state, {"v": [0.3, 0.5]}, executor=pool, progress=False)
    for v, state in zip([0.3, 0.5], found.results, strict=True):
        here = fl.steady_state(MODEL.replace(v=v), progress=False)
        assert state.kind == here.kind
        np.testing.assert_array_equal(state.trajectory.states, here.trajectory.states)
