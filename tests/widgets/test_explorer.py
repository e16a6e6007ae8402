"""Set a control's value; look at the data of the lines and at the words."""

import dataclasses
import json
import re
from dataclasses import dataclass
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import frictionlab as fl
from frictionlab.widgets.drawing import Curve, Drawing
from frictionlab.widgets.settings import QUICK

SHORT = ("response", "phase", "forces", "spectrum")


@dataclass(frozen=True)
class Hertz(fl.ContactLaw):
    k_h: float = fl.parameter(
        8e4, unit="N/m^1.5", symbol="k_H", meaning="Hertz stiffness", minimum=0.0, range=(1e4, 1e6), log=True
    )

    def force(self, gap):
        return self.k_h * gap**2


@dataclass(frozen=True)
class Stribeck(fl.Coulomb):
    fall: float = 0.05

    def kinetic(self, normal_force, speed):
        return (self.mu_k + self.fall / (1 + speed)) * normal_force


@dataclass(frozen=True)
class Softening(fl.LinearContact):
    def force(self, gap):
        return self.k2 * gap * (1 - (gap / 0.05) ** 2)


def made(model=None, panels=SHORT, seconds=1.0):
    explorer = fl.explore(model, panels)
    explorer.controls["duration"].value = seconds
    assert explorer.error is None
    return explorer


def lines(explorer, panel):
    return explorer.picture.tiles[panel].lines


def pixels(explorer, panel):
    return np.asarray(Image.open(BytesIO(explorer.picture.images[panel].value)).convert("RGB"))


@pytest.fixture(scope="module")
def shared():
    return fl.explore(panels=SHORT)


@pytest.fixture
def explorer(shared):
    shared.reset()
    return shared


def test_the_lines_are_those_of_the_run(explorer):
    explorer.controls["mu_k"].value = 1.4
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 20.0, method=QUICK, progress=False)
    for label, name in {"$x_{1}$": "x1", r"$\varphi$": "phi"}.items():
        t, x = lines(explorer, "response")[label].get_data()
        assert (t[0], t[-1]) == (19.0, 20.0)
        assert np.array_equal(x, run(t)[:, run.names.index(name)])
    t, force = lines(explorer, "forces")["$F_N$"].get_data()
    assert np.array_equal(force, run.output("normal_force", t))


def test_the_quick_method_is_as_exact_as_a_picture(explorer):
    explorer.controls["mu_k"].value = 1.4
    t = explorer.result.times()
    shown = explorer.run(t)
    explorer.controls["method"].value = fl.Taylor()
    exact = explorer.run(t)
    assert explorer.run.stats["events"] > 3 * len(explorer.result.times())
    error = np.abs(shown - exact).max(axis=0) / np.ptp(exact, axis=0)
    pixels = explorer.picture.tiles["phase"].ax.get_window_extent().height
    assert (error[:5] < 1e-4).all()
    assert (error < 1 / pixels).all()  # rates zigzag in the flights left out


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
    text = explorer.face.equilibrium.value
    for number in (*point.q, point.gap, point.normal_force, point.friction_force):
        assert f" = {number:.5g} " in text
    assert "is stable" in text
    assert lines(explorer, "phase")["equilibrium"].get_xdata() == [point.q[0]]


def test_an_unstable_equilibrium_is_said_to_be_so_with_rate_and_frequency(explorer):
    explorer.controls["mu_k"].value = 1.6
    found = fl.eigenvalues(fl.SliderOnBelt(mu_k=1.6))
    worst = found.values[np.argmax(found.growth_rates)]
    text = explorer.face.equilibrium.value
    assert f"unstable: 1 mode grows, at {worst.real:.4g} 1/s" in text
    assert f"{abs(worst.imag) / (2 * np.pi):.4g} Hz" in text


def test_a_browser_that_rounds_the_sliders_changes_nothing(explorer):
    updates, settings = explorer.updates, explorer.settings
    for name in ("duration", "k1", "M", "step"):
        explorer.controls[name].value *= 1 - 3e-12
    assert explorer.updates == updates
    explorer.controls["method"].value = "rk4"
    assert explorer.settings == dataclasses.replace(settings, method=fl.RK4(step=2e-4))


@pytest.mark.parametrize("name", ["cubic", "nonsmooth", "geometry"])
def test_a_switch_swaps_the_component(explorer, name):
    explorer.controls[f"switch-{name}"].value = False
    assert explorer.model == fl.SliderOnBelt().without(name)
    assert explorer.error is None
    explorer.controls[f"switch-{name}"].value = True
    assert explorer.model == fl.SliderOnBelt()


def test_what_a_switch_takes_away_goes_from_the_picture_and_the_controls(explorer):
    before = pixels(explorer, "response")
    explorer.controls["switch-geometry"].value = False
    explorer.controls["switch-cubic"].value = False
    assert len(lines(explorer, "response")[r"$\varphi$"].get_xdata()) == 0
    assert not np.array_equal(before, pixels(explorer, "response"))
    shown = {c.tooltip.split("(")[-1].split(",")[0] for c in explorer.parameters._used.children}
    assert "k_nl" not in shown
    assert "k2" in shown
    assert all(name not in explorer.face.equilibrium.value for name in ("phi", "rad"))


def test_a_parameter_keeps_its_value_while_its_law_is_switched_off(explorer):
    explorer.controls["k_nl"].value = 1e6
    explorer.controls["switch-cubic"].value = False
    explorer.controls["switch-cubic"].value = True
    assert explorer.model == fl.SliderOnBelt(k_nl=1e6)


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


def test_the_coordinate_of_phase_plane_and_spectrum(explorer):
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
    assert "numbers with commas" in explorer.face.message.value


@pytest.mark.parametrize(
    ("model", "name", "value"),
    [
        (fl.SliderOnBelt(contact=Hertz()), "k_h", 2e5),
        (fl.SliderOnBelt(friction=Stribeck()), "fall", 0.08),
    ],
    ids=["contact", "friction"],
)
def test_an_own_law_has_sliders_and_runs(model, name, value):
    explorer = made(model, ("response", "eigenvalues"))
    slider = explorer.controls[name]
    assert slider in explorer.parameters._used.children
    slider.value = value
    assert explorer.error is None
    assert getattr(explorer.model, name) == value
    t, x = lines(explorer, "response")["$x_{1}$"].get_data()
    run = fl.simulate(model.replace(**{name: value}), 1.0, method=QUICK, progress=False)
    assert np.array_equal(x, run(t)[:, 0])


def test_a_law_that_cannot_do_without_says_so():
    explorer = made(fl.SliderOnBelt(contact=Hertz()), ("eigenvalues",))
    explorer.controls["switch-cubic"].value = False
    assert "has no k2 to keep" in explorer.face.message.value
    explorer.controls["switch-cubic"].value = True
    assert explorer.error is None


def test_errors_appear_in_the_panel_and_go_when_mended(explorer):
    explorer.controls["mu_k"].value = 1.4
    before = pixels(explorer, "response")
    explorer.controls["mu_s"].value = 1.0
    assert "mu_s must be at least mu_k (1.4), got 1.0: raise mu_s" in explorer.face.message.value
    assert explorer.face.message.layout.display == ""
    assert isinstance(explorer.error, ValueError)
    assert explorer.model.mu_s == 3.0
    assert np.array_equal(before, pixels(explorer, "response"))
    explorer.controls["mu_k"].value = 0.9
    assert explorer.error is None
    assert explorer.face.message.value == ""
    assert explorer.face.message.layout.display == "none"
    assert (explorer.model.mu_k, explorer.model.mu_s) == (0.9, 1.0)


def test_no_equilibrium_is_said_and_the_run_is_shown_all_the_same(explorer):
    explorer.controls["F"].value = 0.0
    assert explorer.error is None
    assert "No steady sliding" in explorer.face.equilibrium.value
    assert "F_N &gt; 0" in explorer.face.equilibrium.value
    assert len(lines(explorer, "response")["$x_{1}$"].get_xdata()) > 100


def test_a_run_that_ends_early_says_so():
    # Beyond a gap of 0.05 m the force turns round and pushes the bodies apart, ever faster.
    explorer = made(fl.SliderOnBelt(contact=Softening(), interface=fl.SlidingOnly()), ("response",))
    explorer.controls["start"].value = "own"
    explorer.controls["own"].value = "0, 1, 0, 0, 0, 0, 0, 0, 0, 0"
    assert explorer.run.status is fl.Status.NOT_FINITE
    assert f"ended at {explorer.run.raw.t:.4g} s: not finite" in explorer.face.message.value


def test_a_motion_without_bounds_ends_soon():
    explorer = made(fl.SliderOnBelt(mu_k=3.0).without("nonsmooth", "geometry"), ("response",), 20.0)
    assert explorer.run.status is fl.Status.STEP_CAP
    assert "step cap" in explorer.face.message.value


def test_any_error_of_a_panel_is_told_with_its_kind():
    broken = [True]

    def own(result):
        if broken:
            raise ZeroDivisionError("no <such> number")
        return Drawing("a (m)", "b (m)", {"line": Curve([0.0, 1.0], [0.0, 1.0])})

    explorer = fl.explore(panels=(own,))
    assert "ZeroDivisionError: no &lt;such&gt; number" in explorer.face.message.value
    broken.clear()
    explorer.controls["mu_k"].value = 0.5
    assert explorer.face.message.value == ""


def test_the_last_value_wins():
    seen = []

    def own(result):
        seen.append(result.model.mu_k)
        if len(seen) == 2:
            for value in (0.6, 0.7, 0.8):
                explorer.controls["mu_k"].value = value
        return Drawing("x (m)", "y (m)")

    explorer = fl.explore(panels=(own,))
    explorer.controls["mu_k"].value = 0.5
    assert seen == [0.3, 0.5, 0.8]
    assert explorer.model.mu_k == 0.8


def test_a_panel_of_ones_own_is_a_function():
    def gap(result):
        t = result.times()
        return Drawing("time (s)", "gap (m)", {"gap": Curve(t, result.run.output("gap", t))})

    explorer = made(panels=("response", gap))
    t, y = lines(explorer, "gap")["gap"].get_data()
    assert np.array_equal(y, explorer.run.output("gap", t))
    assert "fl-panel-gap" in explorer.picture.images["gap"]._dom_classes


def test_one_panel_may_be_asked_for_by_its_name_alone():
    assert list(fl.explore(panels="eigenvalues").picture.panels) == ["eigenvalues"]


def test_nothing_is_computed_that_no_panel_asks_for():
    explorer = fl.explore(panels=("eigenvalues",))
    assert not explorer.result.ran
    assert explorer.running.widget.layout.display == "none"
    assert explorer.run.raw.t == 20.0
    explorer = made(panels=("response",))
    assert "spectrum" not in explorer.result.__dict__


def test_compare_keeps_the_curve_in_grey(explorer):
    kept = np.array(lines(explorer, "response")["$x_{1}$"].get_ydata())
    explorer.controls["compare"].value = True
    explorer.controls["mu_k"].value = 1.4
    explorer.controls["switch-geometry"].value = False
    grey = explorer.picture.tiles["response"].kept["$x_{1}$"]
    assert np.array_equal(grey.get_ydata(), kept)
    assert not np.array_equal(lines(explorer, "response")["$x_{1}$"].get_ydata(), kept)
    explorer.controls["compare"].value = False
    assert len(grey.get_ydata()) == 0


def test_reset_takes_everything_back(explorer):
    before, updates = pixels(explorer, "phase"), explorer.updates
    for name, value in {"mu_k": 1.4, "k5": 2e4, "switch-cubic": False, "start": "near"}.items():
        explorer.controls[name].value = value
    explorer.controls["compare"].value = True
    explorer.controls["reset"].click()
    assert explorer.settings == fl.explore(panels=("eigenvalues",)).settings
    assert not explorer.controls["compare"].value
    assert explorer.updates == updates + 6
    assert np.array_equal(pixels(explorer, "phase").shape, before.shape)


SCENES = {
    "paper": fl.SliderOnBelt(),
    "changed": fl.SliderOnBelt(mu_k=1.4, k_nl=3.3e5, impact=fl.RestitutionImpact(e=0.3)),
    "full": fl.SliderOnBelt(impact=fl.PlasticImpact("full"), interface=fl.SlidingSeparation()),
    "none": fl.SliderOnBelt(F=123.4).without("cubic", "nonsmooth", "geometry"),
    "own law": fl.SliderOnBelt(contact=Hertz(k_h=3e5), mu_k=0.7),
}


@pytest.mark.parametrize("model", SCENES.values(), ids=SCENES)
def test_the_snippet_gives_the_model_and_the_run_again(model):
    explorer = made(model, ("response",))
    names = {"Hertz": Hertz}
    code = re.sub(r"^from \S*test_explorer import Hertz$", "", explorer.face.python.value, flags=re.MULTILINE)
    exec(code, names)
    assert names["model"] == explorer.model == model
    assert np.array_equal(names["run"].final_state, explorer.run.final_state)


def test_the_snippet_has_method_and_initial_state(explorer):
    explorer.controls["method"].value = "rk4"
    explorer.controls["step"].value = 1e-3
    explorer.controls["duration"].value = 2.0
    explorer.controls["start"].value = "own"
    explorer.controls["own"].value = "0.01, 0, 0, 0, 0, 0, 0, 0, 0, 0"
    names = {}
    exec(explorer.face.python.value, names)
    assert np.array_equal(names["run"].final_state, explorer.run.final_state)


def test_the_json_gives_the_model_again(explorer):
    explorer.controls["mu_k"].value = 1.4
    explorer.controls["switch-geometry"].value = False
    data = json.loads(explorer.face.json.value)
    assert fl.SliderOnBelt.from_dict(data["model"]) == explorer.model
    assert (data["t_end"], data["x0"]) == (20.0, "rest")


@pytest.mark.parametrize("model", [fl.SliderOnBelt().automaton(), "slider", 3])
def test_only_models_are_explored(model):
    with pytest.raises(TypeError, match="model must be a model such as SliderOnBelt"):
        fl.explore(model)


@pytest.mark.parametrize(
    ("panels", "message"),
    [(["respons"], "did you mean 'response'"), ([], "at least one panel"), ([3], "must be functions or")],
)
def test_unknown_panels_are_refused(panels, message):
    with pytest.raises(ValueError, match=message):
        fl.explore(panels=panels)


def test_a_notebook_shows_it(explorer):
    assert "application/vnd.jupyter.widget-view+json" in explorer._repr_mimebundle_()
