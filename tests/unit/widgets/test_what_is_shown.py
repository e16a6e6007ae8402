"""The window shows what moves, and the words say what the run does."""

import numpy as np
import pytest

import frictionlab as fl
from tests.helpers.explorers import columns, said, words


def test_a_ball_that_comes_to_rest_is_shown_while_it_moves():
    explorer = fl.explore(fl.BouncingBall(), panels=("response",))
    t, y = (columns(explorer.widget)[name] for name in ("t", "y"))
    over = 3 * np.sqrt(2 / 9.81)  # closed form: e = 0.5 takes three times the first fall
    assert t[0] == 0.0
    assert over < t[-1] < 1.3 * over
    assert np.ptp(y) == pytest.approx(1.0, rel=1e-3)
    explorer.controls["window"].value = 5.0
    t, y = (columns(explorer.widget)[name] for name in ("t", "y"))
    assert (t[0], t[-1], np.ptp(y)) == (95.0, 100.0, 0.0)


def test_a_mass_that_dry_friction_stops_is_shown_until_it_stops():
    explorer = fl.explore(fl.FreeCoulomb(), panels=("response",))
    stop = explorer.run.events.t[-1]
    t = columns(explorer.widget)["t"]
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
    assert {"stick", "separation"} <= set(columns(explorer.widget)["mode"])
    explorer.controls["start"].value = "near"
    does = "Steady sliding is stable, and from near the equilibrium this run dies away."
    assert words(explorer) == does


def test_a_run_that_decays_to_a_stable_equilibrium_dies_away():
    explorer = fl.explore(fl.SliderOnBelt(), panels=("response",))
    assert words(explorer) == "Steady sliding is stable, and from rest this run dies away."
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
    shown = {curve["label"] for curve in said(explorer.widget, "phase(result).curves")} - {"equilibrium"}
    assert shown == {explorer.run.mode_names[mode] for mode in explorer.result.samples()[2]}
    assert len(shown) < len(explorer.run.mode_names)  # those before had more


def test_rates_that_are_rounding_do_not_set_the_axis():
    explorer = fl.explore(fl.MassOnBelt(), panels=("eigenvalues",))
    assert said(explorer.widget, "eigenvaluePanel(result).xlim") == [-1, 1]


def test_where_nothing_slides_there_is_no_panel_of_eigenvalues():
    explorer = fl.explore(fl.BouncingBall(), panels=("eigenvalues", "spectrum"))
    assert said(explorer.widget, "eigenvaluePanel(result)") is None
    assert words(explorer).startswith("Nothing in this model slides while its coordinates rest")
    assert said(explorer.widget, "spectrum(result).note") == "at rest"


def test_a_panel_of_moments_is_called_so():
    titles = [
        said(fl.explore(model, panels=("forces",)).widget, "forces(result).title")
        for model in (fl.DrillString(), fl.MassOnBelt())
    ]
    assert titles == ["contact moments", "contact forces"]


def test_a_model_without_a_mechanism_is_explored_without():
    class Bare(fl.MassOnBelt):
        mechanism = None

    explorer = fl.explore(Bare())
    assert explorer.error is None
    assert "mechanism" not in explorer.widget.scene["panels"]


def test_the_mechanism_follows_the_parameters_that_it_depends_on():
    explorer = fl.explore(panels=("mechanism",))
    [belt] = [part for part in explorer.widget.picture["mechanism"] if part["part"] == "Belt"]
    explorer.controls["l1"].value = 0.1
    [moved] = [part for part in explorer.widget.picture["mechanism"] if part["part"] == "Belt"]
    radii = [one["start"]["turn"]["right"] for one in (belt, moved)]
    np.testing.assert_allclose(radii, [np.hypot(1.0, 0.2), np.hypot(0.5, 0.2)])


def test_the_slope_of_the_friction_curve_is_said_as_a_damper():
    model = fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.1, v=0.3, N=2.0)
    explorer = fl.explore(model, panels=["friction"])
    speed, mu, slope, damper = explorer.widget.picture["friction"]["at"]
    fall = 0.5 * np.exp(-((0.3 / 0.5) ** 2))
    assert (speed, damper) == (0.3, 2 * slope)
    np.testing.assert_allclose([mu, slope], [0.5 + fall, -2 * 0.3 / 0.5**2 * fall], rtol=1e-14)


def test_a_switch_names_the_regimes_that_the_model_has():
    models = fl.SliderOnBelt(), fl.MassOnBelt(), fl.ImpactOscillator()
    texts = [
        fl.explore(model, panels=["friction"]).controls["switch-nonsmooth"].about["text"] for model in models
    ]
    assert texts == ["stick, slip, separation", "stick, slip", "impacts"]
