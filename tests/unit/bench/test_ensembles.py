"""The table of many runs at once; times are not asserted."""

from frictionlab.bench.many_runs import ENSEMBLE_SCENES, EnsembleRow, ensemble_table, ensemble_times


def test_a_row_for_each_scene_and_number_of_runs():
    rows = ensemble_times(runs=(4,), repeats=1, share=0.01)
    assert [(row.scene, row.runs) for row in rows] == [(scene.name, 4) for scene in ENSEMBLE_SCENES]
    assert all(row.one_by_one > 0 and row.side_by_side > 0 for row in rows)


def test_the_table_gives_ratios():
    assert (
        ensemble_table([EnsembleRow("B", 8, 0.3, 0.1)]).splitlines()[-1]
        == "| B | 8 | 300 ms | 100 ms | 3.00 |"
    )
