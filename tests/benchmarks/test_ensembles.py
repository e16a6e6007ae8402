"""The table of many runs at once; times are not asserted."""

from frictionlab.bench.ensembles import LEFT_OUT, Row, ensembles, table


def test_a_row_for_each_scene_and_number_of_runs():
    rows = ensembles(t_end=0.2, runs=(4,), repeats=1)
    assert [(row.without, row.runs) for row in rows] == [(names, 4) for names in LEFT_OUT]
    assert all(row.one_by_one > 0 and row.side_by_side > 0 for row in rows)


def test_the_table_gives_ratios():
    assert table([Row((), 8, 0.3, 0.1)]).splitlines()[-1] == "| - | 8 | 300 ms | 100 ms | 3.00 |"
