"""What docs/performance measures compares like with like, and its tables say what the numbers say."""

import numpy as np
import pytest
import sympy as sp

import beside_heyoka
import frictionlab as fl
import many_runs
import single_costs
import stability_costs
from frictionlab.tape.packing import program_of
from growth import GrowthCurve, growth_table
from reference_scenes import scenes
from single_costs import TimeShares, operations_of_tape, time_share_table
from work_precision import WorkPrecisionRow, ratio_table


def test_eigenvalues_of_many_values_at_once_are_those_of_one_after_another():
    at_once, loop, _ = stability_costs.eigenproblem_times(count=60, repeats=1)
    assert at_once.difference < 1e-9
    assert loop.seconds > 0


def test_multipliers_of_the_tangent_tape_are_those_of_differences():
    rows = stability_costs.multiplier_times(repeats=1)
    assert [row.runs for row in rows] == [1, 16, 16, 16, 1, 20, 20, 20]
    for row in rows:
        assert max(row.known, row.other) < (1e-9 if row.runs == 1 else 1e-5)


def test_the_smooth_model_agrees_on_basins_where_it_is_narrow():
    exact, *hybrid, wide, narrow = many_runs.basin_times(samples=300, some=12, widths=(3.0, 0.1))
    error = np.sqrt(many_runs.EQUILIBRIUM_SHARE * (1 - many_runs.EQUILIBRIUM_SHARE) / 300)
    assert exact.share == pytest.approx(many_runs.EQUILIBRIUM_SHARE, abs=4 * error)
    assert (exact.wrong, narrow.wrong) == (0, 0)
    assert [row.wrong for row in hybrid] == [0] * len(hybrid)
    assert hybrid[0].name == "RK4, step 1e-3 s"
    assert wide.wrong > 0


def test_each_switch_pays():
    costs = {row.without: row for row in single_costs.nonlinearity_costs(t_end=0.1, repeats=1)}
    full = costs[()]
    assert costs[("geometry",)].states == 8 < full.states
    assert (costs[("nonsmooth",)].modes, costs[("nonsmooth",)].guards) == (1, 0)
    assert costs[("cubic",)].products < full.products
    assert costs[single_costs.NONLINEARITIES].products == 0
    assert all(row.operations < full.operations for names, row in costs.items() if names)


def row(family, seconds, error, scene="A"):
    return WorkPrecisionRow(scene, family, family, seconds, error, 0, 0, 1)


def test_a_tool_is_compared_with_our_shortest_run_of_no_larger_error():
    ours = [row("frictionlab", 4.0, 1e-13), row("frictionlab", 2.0, 1e-9)]
    rows = [*ours, row("heyoka", 8.0, 1e-12), row("heyoka", 6.0, 1e-8), row("RK4", 1.0, 1e-14)]
    table = ratio_table(rows).splitlines()
    assert table[0] == "| tool | A |"
    assert "| heyoka | 2, 3 |" in table
    assert "| RK4 | (0.25) |" in table  # none of ours is as exact: the most exact one, in brackets


def test_operations_of_a_tape_are_counted_as_they_are_done():
    x, v = sp.symbols("x v")
    modes = (fl.Mode("free", (v, -2 * x + x * v), ()),)
    program, _ = program_of(fl.HybridAutomaton((x, v), modes, coordinates=1))
    (tape,) = program.tapes
    order = 3
    products = 1 + 3 + 5 + 7  # of order 0 to 3: k + 1 multiplications, k additions
    terms = sum(b - a for kind, a, b in tape.ops if kind == 0)
    assert operations_of_tape(tape, order) == products + 2 * terms * (order + 1) + 2 * order


def test_what_is_left_of_a_scene_with_events_belongs_to_them():
    quiet = TimeShares("C", 100, 0, 1.0, 0.2, 0.5, 0.1, 0.25)  # 0.2 for 100 steps
    busy = TimeShares("B", 50, 10, 2.0, 0.2, 0.5, 0.1, 0.25)  # 1.2, of which 0.1 for 50 steps
    last = time_share_table([quiet, busy]).splitlines()[-1].split(" | ")
    assert last[4:6] == ["100000 us (5 %)", "1100000 us (55 %)"]
    assert last[7] == "110000.00 us"
    assert last[-1] == "2.0 |"


def test_the_slope_of_a_power_is_its_exponent():
    sizes = (1.0, 10.0, 100.0, 1000.0)
    growth = GrowthCurve("events", "events of a run", sizes, tuple(2.0 * np.array(sizes) ** 1.5), sizes)
    assert growth.slope(growth.seconds) == pytest.approx(1.5)
    assert "| 1.50 | 1 to 1000 MB | 1.00 |" in growth_table([growth])


def test_the_share_beside_heyoka_is_of_its_faster_way(monkeypatch):
    times = {"least": [0.002], "turns": [[1.0, 2.0, 3.0], [9.0, 8.0, 9.0], [4.0, 4.0, 5.0]]}
    monkeypatch.setattr(beside_heyoka, "least_times", lambda runs, repeats: times["least"])
    monkeypatch.setattr(beside_heyoka, "times_in_turns", lambda runs, repeats: times["turns"])
    measured = beside_heyoka.shares()
    assert measured == {name: [0.5, 0.5] for name in scenes()}
    table = beside_heyoka.share_table([("AVX2", measured)])
    assert table.splitlines()[-1] == "| AVX2 |" + " 0.50, 0.50 |" * len(scenes())
