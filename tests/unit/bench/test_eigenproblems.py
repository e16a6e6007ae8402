"""The stability benchmark compares like with like; nothing here looks at a clock."""

from frictionlab.bench import stability_costs


def test_all_at_once_and_one_by_one_agree():
    at_once, loop, _ = rows = stability_costs.eigenproblem_times(count=60, repeats=1)
    assert at_once.difference < 1e-9
    assert loop.seconds > 0
    lines = stability_costs.eigenproblem_table(rows).splitlines()
    assert len(lines) == 2 + len(rows)
    assert all(line.count("|") == 5 for line in lines)
