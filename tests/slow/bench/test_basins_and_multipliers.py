"""The benchmarks of basins and of multipliers compare like with like; nothing here looks at a clock."""

import numpy as np
import pytest

from frictionlab.bench import many_runs, stability_costs


def test_the_smooth_model_agrees_where_it_is_narrow():
    rows = many_runs.basin_times(samples=300, some=12, widths=(3.0, 0.1))
    exact, *hybrid, wide, narrow = rows
    error = np.sqrt(many_runs.EQUILIBRIUM_SHARE * (1 - many_runs.EQUILIBRIUM_SHARE) / 300)
    assert exact.share == pytest.approx(many_runs.EQUILIBRIUM_SHARE, abs=4 * error)
    assert (exact.wrong, narrow.wrong) == (0, 0)
    assert [row.wrong for row in hybrid] == [0] * len(hybrid)
    assert hybrid[0].name == "RK4, step 1e-3 s"
    assert wide.wrong > 0
    lines = many_runs.basin_table(rows).splitlines()
    assert len(lines) == 2 + len(rows)
    assert all(line.count("|") == 8 for line in lines)


def test_multipliers_of_all_ways_agree():
    rows = stability_costs.multiplier_times(repeats=1)
    assert [row.runs for row in rows] == [1, 16, 16, 16, 1, 20, 20, 20]
    for row in rows:
        assert max(row.known, row.other) < (1e-9 if row.runs == 1 else 1e-5)
    assert len(stability_costs.multiplier_table(rows).splitlines()) == 10
