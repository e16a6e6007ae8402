"""Laws of one's own, errors in plain words, what an explorer keeps and gives."""

import json
import re
from dataclasses import dataclass

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.plotting.figure import Curve, Drawing
from frictionlab.widgets.result import QUICK_METHOD
from tests.helpers.cases import slow_but
from tests.helpers.explorers import lines, made, pixels


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


@pytest.mark.parametrize(
    ("model", "name", "value"),
    [
        pytest.param(fl.SliderOnBelt(contact=Hertz()), "k_h", 2e5, marks=pytest.mark.slow),
        (fl.SliderOnBelt(friction=Stribeck()), "fall", 0.08),
    ],
    ids=["contact", "friction"],
)
def test_an_own_law_has_sliders_and_runs(model, name, value):
    explorer = made(model, ("response", "eigenvalues"))
    slider = explorer.controls[name]
    assert slider in explorer.parameters.main.children
    slider.value = value
    assert explorer.error is None
    assert getattr(explorer.model, name) == value
    t, x = lines(explorer, "response")["$x_{1}$"].get_data()
    run = fl.simulate(model.replace(**{name: value}), 1.0, method=QUICK_METHOD, progress=False)
    assert np.array_equal(x, run(t)[:, 0])


def test_errors_appear_in_the_panel_and_go_when_mended(explorer):
    explorer.controls["mu_k"].value = 1.4
    before = pixels(explorer, "response")
    explorer.controls["mu_s"].value = 1.0
    assert "mu_s must be at least mu_k (1.4), got 1.0: raise mu_s" in explorer.layout.message.value
    assert explorer.layout.message.layout.display == ""
    assert isinstance(explorer.error, ValueError)
    assert explorer.model.mu_s == 3.0
    assert np.array_equal(before, pixels(explorer, "response"))
    explorer.controls["mu_k"].value = 0.9
    assert explorer.error is None
    assert explorer.layout.message.value == ""
    assert explorer.layout.message.layout.display == "none"
    assert (explorer.model.mu_k, explorer.model.mu_s) == (0.9, 1.0)


def test_no_equilibrium_is_said_and_the_run_is_shown_all_the_same(explorer):
    explorer.controls["F"].value = 0.0
    assert explorer.error is None
    assert "No steady sliding" in explorer.layout.equilibrium.value
    assert "F_N &gt; 0" in explorer.layout.equilibrium.value
    assert len(lines(explorer, "response")["$x_{1}$"].get_xdata()) > 100


def test_a_run_that_ends_early_says_so():
    # Beyond a gap of 0.05 m the force turns round and pushes the bodies apart, ever faster.
    explorer = made(fl.SliderOnBelt(contact=Softening(), interface=fl.SlidingOnly()), ("response",))
    explorer.controls["start"].value = "own"
    explorer.controls["own"].value = "0, 1, 0, 0, 0, 0, 0, 0, 0, 0"
    assert explorer.run.status is fl.Status.NOT_FINITE
    assert f"ended at {explorer.run.raw.t:.4g} s: not finite" in explorer.layout.message.value


def test_a_motion_without_bounds_ends_soon():
    explorer = made(fl.SliderOnBelt(mu_k=3.0).without("nonsmooth", "geometry"), ("response",), 20.0)
    assert explorer.run.status is fl.Status.STEP_CAP
    assert "step cap" in explorer.layout.message.value


def test_any_error_of_a_panel_is_told_with_its_kind():
    broken = [True]

    def own(result):
        if broken:
            raise ZeroDivisionError("no <such> number")
        return Drawing("a (m)", "b (m)", {"line": Curve([0.0, 1.0], [0.0, 1.0])})

    explorer = fl.explore(panels=(own,))
    assert "ZeroDivisionError: no &lt;such&gt; number" in explorer.layout.message.value
    broken.clear()
    explorer.controls["mu_k"].value = 0.5
    assert explorer.layout.message.value == ""


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
        return Drawing("time (s)", "gap (m)", {"gap": Curve(t, result.run.output("penetration", t))})

    explorer = made(panels=("response", gap))
    t, y = lines(explorer, "gap")["gap"].get_data()
    assert np.array_equal(y, explorer.run.output("penetration", t))
    assert "fl-panel-gap" in explorer.picture.images["gap"]._dom_classes


@pytest.mark.slow
def test_nothing_is_computed_that_no_panel_asks_for():
    explorer = fl.explore(panels=("eigenvalues",))
    assert not explorer.result.has_run
    assert explorer.running.widget.layout.display == "none"
    assert explorer.run.raw.t == 20.0
    explorer = made(panels=("response",))
    assert "spectrum" not in explorer.result.__dict__


@pytest.mark.slow
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


@pytest.mark.parametrize("scene", slow_but(["own law"], SCENES))
def test_the_snippet_gives_the_model_and_the_run_again(scene):
    model = SCENES[scene]
    explorer = made(model, ("response",))
    names = {"Hertz": Hertz}
    code = re.sub(
        r"^from \S*test_explorer import Hertz$", "", explorer.layout.python.value, flags=re.MULTILINE
    )
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
    exec(explorer.layout.python.value, names)
    assert np.array_equal(names["run"].final_state, explorer.run.final_state)


def test_the_json_gives_the_model_again(explorer):
    explorer.controls["mu_k"].value = 1.4
    explorer.controls["switch-geometry"].value = False
    data = json.loads(explorer.layout.json.value)
    assert fl.SliderOnBelt.from_dict(data["model"]) == explorer.model
    assert (data["t_end"], data["x0"]) == (20.0, "rest")
