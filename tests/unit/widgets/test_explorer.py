"""Set a control's value; look at the data of the lines and at the words."""

import dataclasses

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.widgets.result import QUICK_METHOD
from tests.helpers.explorers import lines, made, pixels


def test_the_lines_are_those_of_the_run():
    explorer = fl.explore(panels=("response", "forces"))
    explorer.controls["mu_k"].value = 1.4
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 20.0, method=QUICK_METHOD, progress=False)
    for label, name in {"$x_{1}$": "x1", r"$\varphi$": "phi"}.items():
        t, x = lines(explorer, "response")[label].get_data()
        assert (t[0], t[-1]) == (19.0, 20.0)
        assert np.array_equal(x, run(t)[:, run.names.index(name)])
    t, force = lines(explorer, "forces")["$F_N$"].get_data()
    assert np.array_equal(force, run.output("normal_force", t))


def test_the_phase_plane_shows_each_mode_where_the_run_is_in_it(explorer):
    explorer.controls["mu_k"].value = 1.4
    t = explorer.result.times()
    after = np.searchsorted(explorer.run.events.t, t, side="right")
    modes = np.append(explorer.run.events.source[:1], explorer.run.events.target)[after]
    states = explorer.run(t)
    for mode in ("stick", "slip+", "separation"):
        x, rate = lines(explorer, "phase")[mode].get_data()
        own = modes == mode
        assert own.any()
        assert np.array_equal(x[own], states[own, 0])
        assert np.array_equal(rate[own], states[own, 5])
        assert np.isnan(x).any()


def test_the_equilibrium_is_printed_and_marked(explorer):
    explorer.controls["F"].value = 300.0
    point = fl.equilibrium(fl.SliderOnBelt(F=300.0))
    text = explorer.layout.equilibrium.value
    for number in (*point.q, point.penetration, point.normal_force, point.friction_force):
        assert f" = {number:.5g} " in text
    assert "is stable" in text
    assert lines(explorer, "phase")["equilibrium"].get_xdata() == [point.q[0]]


def test_a_browser_that_rounds_the_sliders_changes_nothing(explorer):
    updates, settings = explorer.updates, explorer.settings
    for name in ("duration", "k1", "M", "step"):
        explorer.controls[name].value *= 1 - 3e-12
    assert explorer.updates == updates
    explorer.controls["method"].value = "rk4"
    assert explorer.settings == dataclasses.replace(settings, method=fl.RK4(step=2e-4))


def test_what_a_switch_takes_away_goes_from_the_picture_and_the_controls(explorer):
    before = pixels(explorer, "response")
    explorer.controls["switch-geometry"].value = False
    explorer.controls["switch-cubic"].value = False
    assert len(lines(explorer, "response")[r"$\varphi$"].get_xdata()) == 0
    assert not np.array_equal(before, pixels(explorer, "response"))
    shown = {c.tooltip.split("(")[-1].split(",")[0] for c in explorer.parameters.main.children}
    assert "k_nl" not in shown
    assert "k2" in shown
    assert all(name not in explorer.layout.equilibrium.value for name in ("phi", "rad"))


def test_a_parameter_keeps_its_value_while_its_law_is_switched_off(explorer):
    explorer.controls["k_nl"].value = 1e6
    explorer.controls["switch-cubic"].value = False
    explorer.controls["switch-cubic"].value = True
    assert explorer.model == fl.SliderOnBelt(k_nl=1e6)


@pytest.mark.slow
def test_a_switch_brings_back_what_the_model_was_given_without():
    explorer = made(fl.SliderOnBelt().without("cubic", "nonsmooth", "geometry"))
    assert not any(switch.value for switch in explorer.components.switches.values())
    for name in ("cubic", "nonsmooth", "geometry"):
        explorer.controls[f"switch-{name}"].value = True
    assert explorer.model == fl.SliderOnBelt()


def test_impact_laws(explorer):
    explorer.controls["impact"].value = fl.RestitutionImpact()
    assert "e" in explorer.controls
    explorer.controls["e"].value = 0.25
    assert explorer.model.impact == fl.RestitutionImpact(e=0.25)
    explorer.controls["impact"].value = fl.PlasticImpact("full")
    assert explorer.model == fl.SliderOnBelt(impact=fl.PlasticImpact("full"))


def test_method_start_duration_and_window(explorer):
    explorer.controls["method"].value = "rk4"
    explorer.controls["step"].value = 1e-3
    explorer.controls["start"].value = "near"
    explorer.controls["duration"].value = 2.0
    explorer.controls["window"].value = None
    expected = fl.simulate(fl.SliderOnBelt(), 2.0, x0="near", method=fl.RK4(step=1e-3), progress=False)
    assert np.array_equal(explorer.run.final_state, expected.final_state)
    t = lines(explorer, "response")["$x_{1}$"].get_xdata()
    assert (t[0], t[-1]) == (0.0, 2.0)


def test_the_coordinate_of_phase_plane_and_spectrum():
    explorer = fl.explore(panels=("phase", "spectrum"))
    explorer.controls["coordinate"].value = "phi"
    x = lines(explorer, "phase")["slip+"].get_xdata()
    assert np.nanmax(np.abs(x)) == pytest.approx(np.abs(explorer.result.state("phi")).max(), rel=1e-9)
    assert "rad" in explorer.picture.tiles["spectrum"].ax.get_ylabel()
    explorer.controls["switch-geometry"].value = False
    assert explorer.settings.coordinate == "x1"


def test_own_numbers_as_initial_state(explorer):
    explorer.controls["start"].value = "own"
    explorer.controls["own"].value = "0.01, 0, 0, 0, 0, 0, 0, 0, 0, 0"
    assert explorer.error is None
    assert explorer.run(0.0)[0] == 0.01
    explorer.controls["own"].value = "0.01, much"
    assert "numbers with commas" in explorer.layout.message.value


@pytest.mark.parametrize(
    "model",
    [
        fl.SliderOnBelt(mu_k=1.4),
        fl.SliderOnBelt(mu_k=2.5),
        fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")),
        fl.SliderOnBelt(),
    ],
    ids=["chatter", "more friction", "full gap rate", "sliding"],
)
def test_the_quick_method_differs_from_the_exact_one_by_less_than_a_pixel(model):
    """Where the motion is not chaotic: of a pixel's height, a panel has two hundred."""
    t = np.linspace(19.0, 20.0, 801)
    exact, quick = (
        fl.simulate(model, 20.0, method=m, progress=False)(t) for m in (fl.Taylor(), QUICK_METHOD)
    )
    difference = np.abs(quick - exact).max(axis=0) / np.ptp(exact, axis=0)
    n = len(model.coordinates)
    assert difference[:n].max() < 1e-4
    assert difference[n:].max() < 1 / 200
