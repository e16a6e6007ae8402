"""The benchmark of sweeps runs what it says; nothing here looks at a clock."""

import numpy as np

from frictionlab.bench import many_runs


def test_the_whole_sweep_and_a_share_of_it(monkeypatch):
    monkeypatch.setattr(many_runs, "MU_K", np.array([0.2, 1.4]))
    monkeypatch.setattr(many_runs, "FIXED_STEP_STRIDE", 2)
    rows = many_runs.sweep_times(t_end=0.05, repeats=1)
    assert [row.runs for row in rows] == [4, 4, 2, 2]
    assert len(many_runs.sweep_table(rows).splitlines()) == 6


def test_results_do_not_depend_on_the_workers():
    values = np.array([0.2, 1.4])
    one, two = (many_runs.run_sweep(values, 1.0, many_runs.Taylor(), workers) for workers in (1, 2))
    assert one.results.tolist() == two.results.tolist()
