"""Set a control's value; look at what the front end gets and says."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.widgets.result import QUICK_METHOD
from tests.helpers.explorers import columns, made, said, words


def test_the_samples_are_those_of_the_run_with_both_sides_of_each_event():
    explorer = fl.explore(panels=("response", "forces"))
    explorer.controls["mu_k"].value = 1.4
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 20.0, method=QUICK_METHOD, progress=False)
    found, t = columns(explorer.widget), explorer.result.times()
    assert (found["t"][0], found["t"][-1]) == (19.0, 20.0)
    uniform = np.searchsorted(found["t"], t, side="right") - 1
    assert np.array_equal(found["t"][uniform], t)
    for i, name in enumerate(run.names):
        assert np.array_equal(found[name][uniform], run(t)[:, i])
    assert np.array_equal(found["normal_force"][uniform], run.output("normal_force", t))
    events = run.events
    inside = np.flatnonzero((events.t > 19.0) & (np.diff(events.t, prepend=0.0) > 0))
    first = np.searchsorted(found["t"], events.t[inside])
    assert np.array_equal(found["t"][first], events.t[inside])
    assert found["mode"][first].tolist() == events.source[inside].tolist()
    assert np.array_equal(found["x1'"][first], events.before[inside, 5])


def test_a_jump_is_drawn_where_it_is(explorer):
    ball = fl.explore(fl.BouncingBall(), panels=("phase",))
    found = columns(ball.widget)
    i = int(np.flatnonzero(np.diff(found["t"]) == 0.0)[0])
    assert found["y"][i : i + 2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert found["y'"][i + 1] == pytest.approx(-0.5 * found["y'"][i], rel=1e-12)  # e = 0.5


def test_the_phase_plane_shows_each_mode_where_the_run_is_in_it(explorer):
    explorer.controls["mu_k"].value = 1.4
    found = columns(explorer.widget)
    drawn = said(explorer.widget, "phase(result)")
    curves = {each["label"]: each for each in drawn["curves"]}
    assert drawn["xlabel"] == "$x_{1}$ (m)"
    for mode in ("stick", "slip+", "separation"):
        own = found["mode"] == mode
        assert own.any()
        assert np.array_equal(np.array(curves[mode]["y"], dtype=float)[own], found["x1'"][own])
        assert None in curves[mode]["y"]


def test_angles_have_an_axis_of_their_own(explorer):
    drawn = said(explorer.widget, "response(result)")
    axes = {each["label"]: each["axis"] for each in drawn["curves"]}
    assert (axes["$x_{1}$"], axes[r"$\varphi$"]) == ("left", "right")
    assert (drawn["ylabel"], drawn["right"]) == ("displacement (m)", "angle (rad), dashed")


def test_the_equilibrium_is_said_and_marked(explorer):
    explorer.controls["F"].value = 300.0
    point = fl.equilibrium(fl.SliderOnBelt(F=300.0))
    texts = said(explorer.widget, "equilibriumTexts(result)")
    for number in (*point.q, point.penetration, point.normal_force, point.friction_force):
        assert any(f" = {number:.5g} " in text for text in texts)
    assert "is stable" in words(explorer)
    assert said(explorer.widget, "phase(result).curves.at(-1).x") == [point.q[0]]


def test_what_a_switch_takes_away_goes_from_the_pictures(explorer):
    explorer.controls["switch-geometry"].value = False
    explorer.controls["switch-cubic"].value = False
    assert "phi" not in columns(explorer.widget)
    assert "k_nl" not in explorer.widget.picture["parameters"]
    assert "k2" in explorer.widget.picture["parameters"]
    assert not any("rad" in text for text in said(explorer.widget, "equilibriumTexts(result)"))


def test_a_parameter_keeps_its_value_while_its_law_is_switched_off(explorer):
    explorer.controls["k_nl"].value = 1e6
    explorer.controls["switch-cubic"].value = False
    explorer.controls["switch-cubic"].value = True
    assert explorer.model == fl.SliderOnBelt(k_nl=1e6)


@pytest.mark.slow
def test_a_switch_brings_back_what_the_model_was_given_without():
    explorer = made(fl.SliderOnBelt().without("cubic", "nonsmooth", "geometry"))
    assert not any(explorer.controls[f"switch-{name}"].value for name in ("cubic", "nonsmooth", "geometry"))
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
    t = columns(explorer.widget)["t"]
    assert (t[0], t[-1]) == (0.0, 2.0)


def test_the_coordinate_of_phase_plane_and_spectrum():
    explorer = fl.explore(panels=("phase", "spectrum"))
    explorer.controls["coordinate"].value = "phi"
    assert said(explorer.widget, "phase(result).xlabel") == r"$\varphi$ (rad)"
    assert said(explorer.widget, "spectrum(result).ylabel") == r"amplitude of $\varphi$ (rad)"
    explorer.controls["switch-geometry"].value = False
    assert explorer.result.settings.coordinate == "x1"


def test_own_numbers_as_initial_state(explorer):
    explorer.controls["start"].value = "own"
    explorer.controls["own"].value = "0.01, 0, 0, 0, 0, 0, 0, 0, 0, 0"
    assert explorer.error is None
    assert explorer.run(0.0)[0] == 0.01
    explorer.controls["own"].value = "0.01, much"
    assert "numbers with commas" in explorer.widget.error


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
