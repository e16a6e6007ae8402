"""Laws of one's own, errors in plain words, what an explorer keeps and gives."""

import re
from dataclasses import dataclass

import ipywidgets
import numpy as np
import pytest

import frictionlab as fl
from frictionlab.pages.export import text_of
from frictionlab.plotting.figure import Curve, Drawing
from frictionlab.widgets.result import QUICK_METHOD
from tests.helpers.cases import slow_but
from tests.helpers.explorers import columns, curve, made, words
from tests.unit.pages.test_javascript import run_in_node


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
    assert slider.about["group"] == "main"
    slider.value = value
    assert explorer.error is None
    assert getattr(explorer.model, name) == value
    found = columns(explorer.widget)
    run = fl.simulate(model.replace(**{name: value}), 1.0, method=QUICK_METHOD, progress=False)
    assert found["x1"][-1] == run(1.0)[0]


def test_errors_are_told_and_go_when_mended(explorer):
    explorer.controls["mu_k"].value = 1.4
    before = explorer.widget.picture
    explorer.controls["mu_s"].value = 1.0
    assert "mu_s must be at least mu_k (1.4), got 1.0: raise mu_s" in explorer.widget.error
    assert isinstance(explorer.error, ValueError)
    assert explorer.model.mu_s == 3.0
    assert explorer.widget.picture is before
    explorer.controls["mu_k"].value = 0.9
    assert explorer.error is None
    assert explorer.widget.error == ""
    assert (explorer.model.mu_k, explorer.model.mu_s) == (0.9, 1.0)


def test_what_a_browser_sends_is_taken_or_refused_in_words(explorer):
    state = explorer.values()
    explorer.widget.set_state({"state": state | {"mu_k": 1.3, "start": "near"}})
    assert (explorer.model.mu_k, explorer.result.settings.x0) == (1.3, "near")
    explorer.widget.set_state({"state": state | {"mu_k": -1.0}})
    assert "mu_k must be at least 0, got -1.0" in explorer.widget.error
    assert explorer.model.mu_k == 1.3
    explorer.widget.set_state({"state": state | {"mu_k": 1.3, "start": "near"}})
    assert (explorer.error, explorer.widget.error) == (None, "")


def test_a_control_is_linked_to_any_widget(explorer):
    slider = ipywidgets.FloatSlider(0.3, min=0.0, max=2.0)
    link = ipywidgets.link((slider, "value"), (explorer.controls["mu_k"], "value"))
    slider.value = 0.7
    assert explorer.model.mu_k == explorer.widget.state["mu_k"] == 0.7
    link.unlink()


def test_no_equilibrium_is_said_and_the_run_is_shown_all_the_same(explorer):
    explorer.controls["F"].value = 0.0
    assert explorer.error is None
    assert words(explorer).startswith(
        "No equilibrium in which something slides was found. From rest this run "
    )
    assert len(columns(explorer.widget)["x1"]) > 100


@pytest.mark.parametrize(("clock", "frequency"), [("t", None), ("phase", 1.0)])
def test_why_a_driven_model_has_no_steady_sliding_is_said(clock, frequency):
    @fl.model
    class Driven(fl.MechanicalModel):
        coordinates = ("x",)

        def mechanics(self, q, v):
            contact, load = fl.Friction(0.3 - v.x, 1.0, fl.Coulomb()), fl.functions.cos(getattr(q, clock))
            energies = v.x**2 / 2, q.x**2 / 2
            return fl.Mechanics(*energies, contacts=(contact,), loads={"x": load}, frequency=frequency)

    said = words(fl.explore(Driven(), panels=("eigenvalues",)))
    assert said == "There is no steady sliding, as what moves the bodies changes with time."


def test_a_quotient_without_a_value_is_named():
    @fl.model
    class Heated(fl.MechanicalModel):
        m: float = 1.0
        capacity: float = 5.0
        friction: fl.FrictionLaw = fl.Stribeck(mu_k=0.3, mu_s=0.6, v_s=0.1)
        coordinates = ("x",)
        states = ("T",)

        def mechanics(self, q, v, others):
            contact = fl.Friction(0.2 - v.x, 10 - others.T, self.friction)
            warmed = {"T": (2 - others.T) / self.capacity}
            return fl.Mechanics(self.m * v.x**2 / 2, 50 * q.x**2, contacts=(contact,), rates=warmed)

    explorer = fl.explore(Heated(), panels=("response",))
    explorer.controls["capacity"].value = 0.0
    assert "1/capacity, which has no real value at capacity = 0" in explorer.widget.error
    explorer = fl.explore(Heated(), panels=("eigenvalues",))
    explorer.controls["capacity"].value = 0.0
    assert "division by zero" in explorer.widget.error


def test_a_run_that_ends_early_says_so():
    # Beyond a gap of 0.05 m the force turns round and pushes the bodies apart, ever faster.
    explorer = made(fl.SliderOnBelt(contact=Softening(), interface=fl.SlidingOnly()), ("response",))
    explorer.controls["start"].value = "own"
    explorer.controls["own"].value = "0, 1, 0, 0, 0, 0, 0, 0, 0, 0"
    assert explorer.run.status is fl.Status.NOT_FINITE
    assert f"ended at {explorer.run.raw.t:.4g} s: not finite" in explorer.widget.picture["status"]


def test_a_motion_without_bounds_ends_soon():
    explorer = made(fl.SliderOnBelt(mu_k=3.0).without("nonsmooth", "geometry"), ("response",), 20.0)
    assert explorer.run.status is fl.Status.STEP_CAP
    assert "step cap" in explorer.widget.picture["status"]


def test_any_error_of_a_panel_is_told_with_its_kind():
    broken = [True]

    def own(result):
        if broken:
            raise ZeroDivisionError("no <such> number")
        return Drawing("a (m)", "b (m)", {"line": Curve([0.0, 1.0], [0.0, 1.0])})

    explorer = fl.explore(panels=(own,))
    assert explorer.widget.error == "ZeroDivisionError: no <such> number"
    broken.clear()
    explorer.controls["mu_k"].value = 0.5
    assert explorer.widget.error == ""


def test_interrupting_a_script_ends_it_and_is_told():
    def slow(result):
        if result.model.c != 0.1:
            raise KeyboardInterrupt
        return Drawing("x", "y", {})

    explorer = fl.explore(fl.MassOnBelt(c=0.1), panels=[slow])
    with pytest.raises(KeyboardInterrupt):
        explorer.controls["c"].value = 0.2
    assert explorer.widget.error.startswith("The computation was stopped")
    explorer.controls["c"].value = 0.1
    assert explorer.widget.error == ""


def test_the_stop_button_interrupts_the_kernel_only_while_the_widget_computes():
    def seen(result):
        stops.append(explorer.widget.computing if explorer else None)
        if result.model.c == 0.3:
            raise ValueError("broken")
        return Drawing("x", "y", {})

    stops, explorer = [], None
    explorer = fl.explore(fl.MassOnBelt(c=0.1), panels=[seen])
    for c in (0.2, 0.3):
        explorer.controls["c"].value = c
        assert stops.pop() is True
        assert explorer.widget.computing is False
    assert run_in_node(
        f"""{text_of("python_engine.js").replace("export default", "void")}
        const counts = [[false, true], [true, true], [true, false]].map(([computing, has_kernel]) => {{
          let count = 0, said = 0;
          const manager = {{ kernel: {{ interrupt: () => {{ count += 1; }} }} }};
          const widget_manager = has_kernel ? manager : undefined;
          const engine = new PythonEngine({{ get: () => computing, send: () => {{}}, widget_manager }});
          engine.stop({{ say: (text) => {{ said += text.startsWith("This server"); }} }});
          return [count, said];
        }});
        console.log(JSON.stringify(counts));"""
    ) == [[0, 0], [1, 0], [0, 1]]


def test_one_answer_of_python_is_for_all_who_wait():
    assert run_in_node(
        f"""{text_of("python_engine.js").replace("export default", "void")}
        const engine = new PythonEngine({{ send: () => {{}} }});
        const heard = [engine.hear(), engine.hear()].map((sound) => sound.catch((error) => error.message));
        engine.answered({{ text: "silent" }}, []);
        Promise.all(heard).then((texts) => {{
          console.log(JSON.stringify(texts));
          process.exit(0);
        }});"""
    ) == ["silent", "silent"]


def test_what_takes_long_waits_until_a_slider_stops():
    explorer = fl.explore(fl.MassOnBelt(c=0.1), panels=("response", "spectrum"))
    for sliding, c in ((True, 0.2), (False, 0.2)):
        explorer.widget.set_state({"sliding": sliding, "state": {**explorer.values(), "c": c}})
        picture = explorer.widget.picture
        assert picture["parameters"]["c"] == c
        assert picture["complete"] == ("spectrum" in picture) == (not sliding)


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
    t, y = curve(explorer, "gap", "gap")
    assert np.array_equal(y, explorer.run.output("penetration", t))
    sent = explorer.widget.picture["drawings"]["gap"]
    assert sent["ylabel"] == "gap (m)"
    assert np.array_equal(np.frombuffer(sent["curves"][0]["y"]), y)


def test_a_panel_draws_with_matplotlib_too():
    def section(run, ax):
        ax.plot(run.t, run["x1"], color="#123456")

    explorer = made(panels=("response", section))
    image = explorer.widget.picture["drawings"]["section"]["image"]
    assert image.startswith(b"<?xml")
    assert b"#123456" in image


@pytest.mark.slow
def test_nothing_is_computed_that_no_panel_asks_for():
    explorer = fl.explore(panels=("eigenvalues",))
    assert "run" not in vars(explorer.result)
    assert "samples" not in explorer.widget.picture
    assert explorer.run.raw.t == 20.0
    explorer = made(panels=("response",))
    assert "spectrum" not in explorer.result.__dict__


def test_reset_takes_everything_back(explorer):
    updates = explorer.updates
    for name, value in {"mu_k": 1.4, "k5": 2e4, "switch-cubic": False, "start": "near"}.items():
        explorer.controls[name].value = value
    explorer.reset()
    assert explorer.result.settings == fl.explore(panels=("eigenvalues",)).result.settings
    assert explorer.updates == updates + 5


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
        r"^from \S*test_explorer import Hertz$", "", explorer.widget.picture["python"], flags=re.MULTILINE
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
    exec(explorer.widget.picture["python"], names)
    assert np.array_equal(names["run"].final_state, explorer.run.final_state)
