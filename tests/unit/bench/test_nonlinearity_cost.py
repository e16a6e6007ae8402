"""The table of switches is complete; nothing here looks at a clock."""

import subprocess

import pytest

from frictionlab.bench import single_costs


def test_each_switch_pays():
    found = {row.without: row for row in single_costs.nonlinearity_costs(t_end=0.1, repeats=1)}
    full = found[()]
    assert len(found) == 8
    assert found[("geometry",)].states == 8 < full.states
    assert (found[("nonsmooth",)].modes, found[("nonsmooth",)].guards) == (1, 0)
    assert found[("cubic",)].products < full.products
    assert found[single_costs.NONLINEARITIES].products == 0
    assert all(row.operations < full.operations for names, row in found.items() if names)
    lines = single_costs.nonlinearity_table(list(found.values()), [0.5] * 8, 0.01).splitlines()
    assert len(lines) == 11
    assert all(line.count("|") == 9 for line in lines)
    assert lines[-1].endswith("| 0.010 s |")


def test_the_starts_are_those_of_processes_that_end(monkeypatch):
    quick = {"nothing": ("import frictionlab", "", "Python")}
    monkeypatch.setattr(single_costs, "STARTS", quick)
    (row,) = single_costs.start_times(repeats=1)
    assert min(row.first, row.later, row.floor) > 0
    head, _, line = single_costs.start_table([row]).splitlines()
    assert head.count("|") == line.count("|")
    assert line.startswith("| nothing | ")


def test_a_start_that_fails_is_an_error(monkeypatch):
    monkeypatch.setattr(single_costs, "STARTS", {"wrong": ("raise SystemExit(1)", "", "Python")})
    with pytest.raises(subprocess.CalledProcessError):
        single_costs.start_times(repeats=1)
