"""Lines are painted with few points, and with all their corners."""

import json

import pytest

from frictionlab.pages.export import text_of
from tests.unit.pages.test_javascript import run_in_node


@pytest.mark.parametrize(
    ("points", "corners"),
    [
        ([(0, 5), (30, 5), (60, 5), (40, 5), (20, 5)], [(0, 5), (60, 5), (20, 5)]),  # there and back
        ([(0, 5), (60, 5), (0, 5), (0, 9)], [(0, 5), (60, 5), (0, 5), (0, 9)]),
        ([(0, 5), (60, 5), (0.5, 5.5), (9, 9)], [(0, 5), (60, 5), (9, 9)]),
        ([(0, 5), (0.5, 5.5), (30, 5), (60, 9)], [(0, 5), (30, 5), (60, 9)]),  # a level after a near point
        ([(0, 5), (0.5, 5.5), (9, 5), (30, 5), (60, 5)], [(0, 5), (60, 5)]),
    ],
)
def test_a_level_keeps_its_extent(points, corners):
    x, y = zip(*points, strict=True)
    painted = run_in_node(
        f"""{text_of("plot.js")}
        const painted = [], add = (...point) => painted.push(point), nothing = () => {{}};
        const same = new Axis([0, 100], [0, 100]);
        const c = {{ moveTo: add, lineTo: add, beginPath: nothing, stroke: nothing }};
        paintLine(c, {json.dumps(x)}, {json.dumps(y)}, same, same);
        console.log(JSON.stringify(painted));"""
    )
    assert [p for p in map(tuple, painted) if p != (0.5, 5.5)] == corners
