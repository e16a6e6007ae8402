"""Tables of the benchmark from numbers that are known: ratios, shares of time, growth."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.bench.growth import Growth, growth_table
from frictionlab.bench.harness import WorkPrecisionRow, ratio_table
from frictionlab.bench.single_costs import TimeShares, operations_of_tape, time_share_table
from frictionlab.hybrid.tape.packing import program_of


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
    growth = Growth("events", "events of a run", sizes, tuple(2.0 * np.array(sizes) ** 1.5), sizes)
    assert growth.slope(growth.seconds) == pytest.approx(1.5)
    assert "| 1.50 | 1 to 1000 MB | 1.00 |" in growth_table([growth])
