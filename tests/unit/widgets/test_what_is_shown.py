"""The window shows what moves, the words say what the run does, and legends fit into their tiles."""

import re

import numpy as np
import pytest

import frictionlab as fl
from tests.helpers.explorers import lines


def words(explorer):
    """What stands beside the picture about the equilibrium, without its numbers."""
    return re.sub("<br>.*|<[^>]*>", "", explorer.layout.equilibrium.value)


def test_a_ball_that_comes_to_rest_is_shown_while_it_moves():
    explorer = fl.explore(fl.BouncingBall(), panels=("response",))
    t, y = lines(explorer, "response")["$y$"].get_data()
    over = 3 * np.sqrt(2 / 9.81)  # closed form: e = 0.5 takes three times the first fall
    assert t[0] == 0.0
    assert over < t[-1] < 1.3 * over
    assert np.ptp(y) == pytest.approx(1.0, rel=1e-3)
    explorer.controls["window"].value = 5.0
    t, y = lines(explorer, "response")["$y$"].get_data()
    assert (t[0], t[-1], np.ptp(y)) == (95.0, 100.0, 0.0)


def test_a_mass_that_dry_friction_stops_is_shown_until_it_stops():
    explorer = fl.explore(fl.FreeCoulomb(), panels=("response",))
    stop = explorer.run.events.t[-1]
    t = lines(explorer, "response")["$x$"].get_xdata()
    assert (t[0], t[-1]) == (0.0, pytest.approx(1.15 * stop))


@pytest.mark.slow
def test_beside_a_stable_equilibrium_stands_what_this_run_does():
    explorer = fl.explore(fl.SliderOnBelt(mu_k=1.4), panels=("response", "spectrum"))
    assert explorer.result.eigenvalues.stable
    strongest = fl.amplitude_spectrum(explorer.run, "x1").strongest
    does = (
        f"Steady sliding is stable, but from rest this run sticks, slips and separates at {strongest:.3g} Hz."
    )
    assert words(explorer) == does
    assert {"stick", "separation"} <= set(explorer.result.modes)
    explorer.controls["start"].value = "near"
    assert words(explorer) == "Steady sliding is stable."


def test_a_run_that_decays_to_a_stable_equilibrium_needs_no_word():
    explorer = fl.explore(fl.SliderOnBelt(), panels=("response",))
    assert words(explorer) == "Steady sliding is stable."
    rate = fl.eigenvalues(fl.SliderOnBelt()).growth_rates.max()
    assert rate < 0
    assert explorer.result.decays


def test_an_unstable_equilibrium_and_its_run():
    explorer = fl.explore(
        fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.1), panels=("spectrum",)
    )
    assert "unstable: 1 mode grows" in words(explorer)
    assert words(explorer).endswith(", and from rest this run sticks and slips at 0.112 Hz.")


def test_a_legend_has_no_modes_of_runs_before():
    model = fl.TwoBlocks()
    for start in ([3.0, -2.0, 5.0, -4.0], [-3.0, 2.0, -5.0, 4.0]):
        fl.simulate(model, 50.0, x0=start, progress=False)
    explorer = fl.explore(model, panels=("phase",))
    legend = explorer.picture.tiles["phase"].ax.get_legend()
    shown = {text.get_text() for text in legend.get_texts()} - {"equilibrium"}
    assert shown == set(explorer.run.time_in_mode)
    assert len(shown) < len(explorer.run.mode_names)  # those before had more


def test_what_is_kept_for_comparison_is_dotted_and_of_no_modes_colour():
    explorer = fl.explore(fl.SliderOnBelt(mu_k=1.4), panels=("phase",))
    explorer.controls["compare"].value = True
    tile = explorer.picture.tiles["phase"]
    kept, now = tile.frozen["slip+"], tile.lines["slip+"]
    assert kept.get_color() not in {
        line.get_color() for label, line in tile.lines.items() if label != "equilibrium"
    }
    assert (kept.is_dashed(), now.is_dashed()) == (True, False)


def test_rates_that_are_rounding_do_not_set_the_axis():
    explorer = fl.explore(fl.MassOnBelt(), panels=("eigenvalues",))
    assert explorer.picture.tiles["eigenvalues"].ax.get_xlim() == (-1.0, 1.0)
