"""The benchmark's tables are complete and its errors real; nothing here looks at a clock."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.analysis import benchmark


@pytest.fixture(scope="module")
def rows():
    among = [pair for pair in benchmark.METHODS if not isinstance(pair[1], fl.Scipy)]
    return {row.name: row for row in benchmark.methods(t_end=0.1, repeats=1, among=among)}


def test_taylor_reaches_the_reference_of_40_digits():
    run = fl.simulate(benchmark.SCENE, 20.0)
    assert np.abs(run.final_state - np.array(benchmark.REFERENCE)).max() < 1e-10


def test_errors_rank_the_methods(rows):
    exact, loose = rows["Taylor, tol 1e-15"].error, rows["Taylor, tol 1e-8"].error
    fine, coarse = rows["RK4, step 1e-4 s"].error, rows["RK4, step 2e-4 s"].error
    assert exact < 1e-10
    assert 1e4 * exact < fine
    assert 8 * fine < coarse < 32 * fine  # fourth order: sixteen times
    assert exact < loose < coarse


def test_every_method_finds_every_event(rows):
    assert {row.events for row in rows.values()} == {886}


def test_table_states_ratios(rows):
    lines = benchmark.table(list(rows.values())).splitlines()
    assert len(lines) == 2 + len(rows)
    assert all(line.count("|") == 8 for line in lines)
    assert "| 1.0 |" in lines[2]


def test_each_switch_pays():
    found = {row.without: row for row in benchmark.switches(t_end=0.1, repeats=1)}
    full = found[()]
    assert len(found) == 8
    assert found[("geometry",)].states == 8 < full.states
    assert (found[("nonsmooth",)].modes, found[("nonsmooth",)].guards) == (1, 0)
    assert found[("cubic",)].products < full.products
    assert found[benchmark.SWITCHES].products == 0
    assert all(row.operations < full.operations for names, row in found.items() if names)
    assert len(benchmark.switch_table(list(found.values())).splitlines()) == 10
