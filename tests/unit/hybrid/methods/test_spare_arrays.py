"""Runs that take the arrays of a run before: what that has left in them does not matter."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.hybrid.methods.base import SPARE_RUNS
from tests.helpers.explorers import MODELS

SLOW = pytest.mark.slow
METHODS = [fl.Taylor(), fl.Taylor(tol=1e-6), fl.RK4(step=1e-3), pytest.param(fl.Scipy("RK45"), marks=SLOW)]
POWER = fl.SliderOnBelt(contact=fl.HertzContact(), mu_k=1.4)
ON_DEMAND = fl.SliderOnBelt(mu_k=1.4, k_nl=1e9)


def arrays(run):
    return [np.asarray(each) for each in run.raw if not isinstance(each, fl.Status)]


def same(first, second):
    return all(a.tobytes() == b.tobytes() for a, b in zip(arrays(first), arrays(second), strict=True))


def spoil(run, order):
    """Fill what the run gave back with NaN; tables and columns above the order are never written."""
    arrays = SPARE_RUNS.take((run.problem.program, order), lambda: None)
    assert arrays is not None
    scratch = arrays.scratch
    for each in (scratch.jets, scratch.bounds):
        each[:, : order + 1] = np.nan
    for each in (
        scratch.values[:, :1],
        scratch.states,
        scratch.roots.stack,
        scratch.roots.scaled,
        scratch.roots.places,
    ):
        each[...] = np.nan
    for each in (scratch.structural_zeros, scratch.leading_zeros, scratch.ended, scratch.roots.multiplicity):
        each[...] = 77
    SPARE_RUNS.give((run.problem.program, order), arrays)


@pytest.mark.parametrize("method", METHODS, ids=repr)
@pytest.mark.parametrize("model", [*MODELS.values(), POWER, ON_DEMAND], ids=repr)
def test_what_a_run_leaves_changes_no_other(model, method):
    first = fl.simulate(model, 0.3, method=method, progress=False)
    spoil(first, first.samples.order)
    assert same(first, fl.simulate(model, 0.3, method=method, progress=False))


def test_runs_at_once_share_nothing():
    model = fl.SliderOnBelt(mu_k=1.4)
    alone = fl.simulate(model, 2.0, progress=False)
    with ThreadPoolExecutor(2) as pool:
        runs = list(pool.map(lambda _: fl.simulate(model, 2.0, progress=False), range(8)))
    assert all(same(alone, run) for run in runs)


def test_a_run_keeps_its_steps_when_another_follows():
    model = fl.SliderOnBelt(mu_k=1.4)
    first = fl.simulate(model, 0.3, progress=False)
    before = [each.copy() for each in arrays(first)]
    fl.simulate(model.replace(mu_k=0.9), 0.3, progress=False)
    assert all((a == b).all() for a, b in zip(before, arrays(first), strict=True))


def test_few_are_kept():
    kept = type(SPARE_RUNS)()
    for i in range(20):
        kept.give(i, [i])
    assert kept.take(19, lambda: None) == [19]
    assert kept.take(19, list) == []  # each is given once
    assert kept.take(0, list) == []
