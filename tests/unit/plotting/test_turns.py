"""Angles that turn are drawn modulo a turn, in matplotlib's pictures and in the page's panels alike."""

import json

import numpy as np
import pytest

import frictionlab as fl
from frictionlab import plotting
from frictionlab.pages.export import text_of
from frictionlab.plotting.turns import cut_at_turns
from tests.unit.pages.test_javascript import run_in_node

T = np.linspace(0.0, 9.0, 401)
ANGLES = {"forth": 5.0 * T, "back and forth": 9.0 * np.sin(T), "at rest": 7.0 + 0.0 * T}


@pytest.mark.parametrize("angle", ANGLES.values(), ids=ANGLES)
def test_an_angle_is_cut_where_it_comes_to_half_a_turn(angle):
    shown, time = cut_at_turns(angle, T)
    exact, seen = np.interp(time, T, angle), ~np.isnan(shown)
    assert np.abs(shown[seen]).max() <= np.pi
    assert np.allclose(np.exp(1j * shown[seen]), np.exp(1j * exact[seen]), rtol=0, atol=1e-12)
    assert np.nanmax(np.abs(np.diff(shown))) < np.pi / 4  # no line across
    assert (~seen).sum() == np.count_nonzero(np.diff(np.floor(angle / (2 * np.pi) + 0.5)))
    script = f"""{text_of("turns.js")}
        const found = cutAtTurns({json.dumps(angle.tolist())}, {json.dumps(T.tolist())});
        console.log(JSON.stringify(found.map((values) => Array.from(values))));"""
    in_page = np.array([[np.nan if v is None else v for v in column] for column in run_in_node(script)])
    assert np.array_equal(in_page, [shown, time], equal_nan=True)


def test_a_drill_string_turns_and_a_pendulum_that_swings_does_not():
    for model, turns in ((fl.DrillString(), True), (fl.FroudePendulum(), False)):
        run = fl.simulate(model, 60.0, progress=False)
        for lines, axis in (
            (plotting.plot_phase_plane(run), "x"),
            (plotting.plot_displacements(run), "y"),
        ):
            drawn = np.concatenate([getattr(line, f"get_{axis}data")() for line in lines])
            assert np.nanmax(np.abs(drawn)) <= np.pi
            ticks = [text.get_text() for text in getattr(lines[0].axes, f"get_{axis}ticklabels")()]
            assert (r"$\pi/2$" in ticks) == turns
