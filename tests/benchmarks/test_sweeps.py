"""The benchmark of sweeps runs what it says; nothing here looks at a clock."""

import numpy as np

from frictionlab.bench import sweeps


def test_the_whole_sweep_and_a_share_of_it(monkeypatch):
    monkeypatch.setattr(sweeps, "MU_K", np.array([0.2, 1.4]))
    monkeypatch.setattr(sweeps, "SPARSE", 2)
    rows = sweeps.sweeps(t_end=0.05, repeats=1)
    assert [row.runs for row in rows] == [4, 4, 2, 2]
    assert len(sweeps.table(rows).splitlines()) == 6


def test_results_do_not_depend_on_the_workers():
    values = np.array([0.2, 1.4])
    one, two = (sweeps._sweep(values, 1.0, sweeps.Taylor(), workers) for workers in (1, 2))
    assert one.results.tolist() == two.results.tolist()
