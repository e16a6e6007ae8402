"""Explorers, pages, films and sounds of automata, whose periods and ranges are found or stated."""

import pickle
from dataclasses import replace
from math import atan, log, pi

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.orbits.pseudo_arclength import with_parameter_as_state
from frictionlab.analysis.period_of_motion import with_period
from frictionlab.pages.cases import rule_data
from frictionlab.pages.export import script_text
from frictionlab.pages.scene import usual_duration
from frictionlab.widgets.front_end import quantities_of
from tests.helpers.automata import V, X, automaton, ball, coulomb, named, oscillator, thermostat
from tests.helpers.explorers import words
from tests.unit.pages.test_javascript import run_in_node

BELT = coulomb(0.2, 1.0, 0.5)
DECAY = automaton(fl.Mode("on", (-sp.Symbol("rate") * X,)), states=(X,), coordinates=0, rate=2.0)
PERIODS = {
    "stick and slip": (BELT, [0.0, 0.0], 5 + 2 * pi - 2 * atan(2.5)),
    "two temperatures": (thermostat(), [0.0], 10 * log(11 / 9) + 10 * log(41 / 39)),
    "at rest": (oscillator(), [0.0, 0.0], 2 * pi),
    "seconds of 1e-6": (automaton(fl.Mode("on", (V, -1e12 * X))), [1.0, 0.0], 2e-6 * pi),
    "no oscillation": (DECAY, [1.0], log(1e3) / 2 / 10),
    "nothing": (automaton(fl.Mode("on", (sp.S.One,)), states=(X,), coordinates=0), [0.0], 1.0),
    "drift": (automaton(fl.Mode("on", (V, sp.S.Zero))), [0.0, 1.0], 1.0),
    "no mode": (automaton(fl.Mode("on", (V, -X), (), (X - 1,))), [0.0, 0.0], 1.0),
    "an end in 1e-6": (automaton(fl.Mode("on", (1e6 * X**2,)), states=(X,), coordinates=0), [1.0], 1e-6),
}


@pytest.mark.parametrize("name", PERIODS)
def test_a_period_is_found_in_the_motion(name):
    given, start, period = PERIODS[name]
    assert with_period(given, np.array(start)).period == pytest.approx(period, rel=0.1)


def test_a_model_that_states_no_period_is_shown_with_that_of_its_motion():
    @fl.model
    class Slow(fl.MechanicalModel):
        k: float = 1e-6
        coordinates = ("x",)

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, self.k * q.x**2 / 2, loads={"x": self.k})

    explorer = fl.explore(Slow(), ["response"])
    assert explorer.widget.scene["period"] == 5000.0  # 2 pi 1000 s
    assert explorer.widget.scene["sound"]["pitch"] == pytest.approx(200 * 2e3 * pi, rel=0.01)
    assert explorer.run.t[-1] == 200 * 5000.0


def test_the_period_of_a_model_is_found_from_where_its_explorer_starts_and_is_kept():
    @fl.model
    class Held(fl.MechanicalModel):  # at rest its coefficient breaks a rule; and it would not move there
        k: float = 1e6
        mu: float = -0.1
        coordinates = ("x",)

        def mechanics(self, q, v):
            rubbing = fl.Friction(-v.x, 1.0, fl.Coulomb(mu_k=self.mu + q.x, mu_s=1.0))
            return fl.Mechanics(v.x**2 / 2, self.k * q.x**2 / 2, contacts=(rubbing,))

    with pytest.raises(ValueError, match="mu_k must be at least 0"):
        fl.explore(Held())
    explorer = fl.explore(Held(), ["response"], x0=[0.5, 0.0])
    assert explorer.widget.scene["period"] == 5e-3  # 2 pi / 1000 s
    assert explorer.run.t[-1] == 200 * 5e-3
    shown = explorer.result.times()[-1] - explorer.result.times()[0]
    explorer.controls["k"].value = 1e4
    assert explorer.result.times()[-1] - explorer.result.times()[0] == pytest.approx(shown)


def test_a_period_that_is_stated_follows_the_parameters():
    explorer = fl.explore(fl.DenHartog(Omega=0.5), ["response"])
    shown = explorer.result.times()[-1] - explorer.result.times()[0]
    explorer.controls["Omega"].value = 0.05
    assert explorer.result.times()[-1] - explorer.result.times()[0] == pytest.approx(10 * shown)


def test_a_period_that_is_stated_is_kept():
    stated = fl.HybridAutomaton(BELT.states, BELT.modes, BELT.parameters, 1, period=3.0)
    explorer = fl.explore(stated.replace(belt=0.1), ["response"])
    assert explorer.widget.scene["period"] == 2.0
    assert with_parameter_as_state(stated, "belt").period == 3.0
    with pytest.raises(ValueError, match="period must be a finite number, above 0, got 0"):
        fl.HybridAutomaton(BELT.states, BELT.modes, BELT.parameters, 1, period=0)


def test_an_explorer_of_an_automaton_is_what_solve_computes():
    explorer = fl.explore(ball(), x0=[1.0, 0.0], t_end=20.0)
    explorer.controls["e"].value = 0.7
    explorer.controls["method"].label = "exact (Taylor)"
    run = fl.solve(ball().replace(e=0.7), 20.0, x0=[1.0, 0.0], progress=False)
    np.testing.assert_array_equal(explorer.run.final_state, run.final_state)
    assert explorer.model.values == {"g": 9.81, "e": 0.7}
    assert f"({len(run.events)} floor)" in explorer.widget.picture["status"]
    assert words(explorer) == "No equilibrium was found. From your own state this run is over after 2.56 s."
    known = {"automaton": ball()}
    exec(explorer.widget.picture["python"], known)
    np.testing.assert_array_equal(known["run"].final_state, run.final_state)


def test_signs_of_symbols_are_bounds_and_sliders_go_to_twice_the_value():
    control = fl.explore(named(), ["response"]).controls["x0"]
    assert 0.0 < control.min < 0.01
    assert control.max == pytest.approx(1.0, rel=0.01)
    with pytest.raises(ValueError, match="x0 must be greater than 0"):
        control.set_data(-1.0)


def test_a_bifurcation_and_a_stability_explorer_of_an_automaton():
    explorer = fl.explore_bifurcation(thermostat(), "heat")
    drawn = explorer.drawings["bifurcation"].curves["periodic"]
    assert len(set(drawn.x[drawn.x > 2.0])) > 10  # with less heat it never gets warm enough
    assert set(np.round(drawn.y, 9)) <= {19.0, 21.0}
    k, c = sp.symbols("k c")
    damped = automaton(fl.Mode("on", (V, -k * X - (c - 0.05) * V)), k=1.0, c=0.1)
    explorer = fl.explore_stability(damped, "c", "k")
    explorer.controls["c"].value = 0.02
    assert not explorer.result.eigenvalues.stable
    critical = explorer.drawings["critical"].curves["critical"].y
    np.testing.assert_allclose(critical, 0.05, rtol=1e-9)


def test_a_plane_of_parameters_needs_two():
    with pytest.raises(ValueError, match=r"model must have two parameters, got 1 parameter \(rate\)"):
        fl.explore_stability(DECAY)


def test_what_is_told_of_states_has_the_automatons_own_names():
    mode = fl.Mode("on", (sp.S.One, sp.S.Zero))
    for names in ((X, V), sp.symbols("a b")):
        given = fl.HybridAutomaton(names, (mode,), {}, 1)
        assert quantities_of(given)["states"] == [each.name for each in names]


def test_a_film_of_an_automaton_shows_its_history():
    run = fl.solve(BELT, 20.0, x0=[0.0, 0.0], progress=False)
    assert fl.animate(run, window=None, speed=10.0, fps=2).to_jshtml().count("data:image/png") == 5
    widget = fl.watch(run, window=None)
    assert widget.scene["panels"] == ["response", "phase"]
    assert widget.picture["structure"]["modes"] == ["stick", "+", "-"]
    assert fl.listen(run).signal == "v"


@pytest.mark.parametrize("name", ["duration", "own", "scene", "switch-k"])
def test_a_parameter_named_like_a_control_is_refused_in_words(name, tmp_path):
    taken = automaton(fl.Mode("on", (V, -sp.Symbol(name) * X)), **{name: 1.0})
    for show in (fl.explore, lambda given: fl.export_page(given, tmp_path / "page.html")):
        with pytest.raises(ValueError, match=f"named like the explorer's control '{name}'.*rename it"):
            show(taken)


def test_a_parameter_named_friction_is_no_law_in_a_page():
    scene = """{ switches: [], initial: { friction: 0.3 },
      controls: [{ name: "friction", kind: "number", value: 0.3 }] }"""
    found = run_in_node(
        f"""const STRUCTURES = {{ "": "the only one" }}, SCENE = {scene};
        {script_text(("words", "state", "browser_engine"))}
        console.log(JSON.stringify(new BrowserEngine(null).structureOf({{ friction: 0.4 }})));"""
    )
    assert found == "the only one"


def test_a_run_of_a_stiff_automaton_has_ten_periods():
    y, rate = sp.symbols("y w")
    both = fl.Mode("both", (V, rate, -((2 * sp.pi) ** 2) * X, -1e12 * y))
    assert usual_duration(fl.HybridAutomaton((X, y, V, rate), (both,), {}, 2), 1.0) == 10.0


def test_a_structure_is_shown_by_its_automaton():
    pads = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]], fl.LinearContact(k2=2.0), fl.Coulomb(0.3, 0.4))
    structure = fl.Structure(np.eye(2), [[2.0, 0.5], [0.5, 2.0]], contacts=pads, load=[0.0, 1.0])
    structure = structure.replace(units=("mm", "kN"))
    explorer = fl.explore(structure, x0=[0.1, 0.5, 0.0, 0.0], t_end=3.0)
    explorer.controls["mu_k"].value = 0.2
    run = fl.simulate(structure.replace(mu_k=0.2), 3.0, x0=[0.1, 0.5, 0.0, 0.0], progress=False)
    np.testing.assert_allclose(explorer.run.final_state, run.final_state, atol=1e-6)
    said = explorer.widget.picture["structure"]
    assert (said["units"]["q1'"], said["axis_of_forces"]) == ("mm/s", "contact force (kN)")
    assert [unit for _, unit in said["at_contact"].values()] == ["mm", "kN", "kN"]
    large = structure.replace(M=np.eye(101), K=np.eye(101), contacts=None, load=None)
    many = structure.replace(contacts=[replace(pads, name=name) for name in "abcd"])
    for refused, message in (
        (large, "at most 100 freedoms to be shown, got 101"),
        (many, "at most 64 modes"),
    ):
        with pytest.raises(ValueError, match=message):
            fl.explore(refused)


@pytest.mark.parametrize("name", [None, "inner"])
def test_an_explorer_of_a_structure_has_its_rules_and_studies_take_its_model(name, tmp_path):
    pads = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]], friction=fl.Coulomb(0.3, 0.4), name=name)
    parts = {"load": [0.0, 1.0], "units": ("mm", "kN"), "window": (0.0, 9.0)}
    structure = fl.Structure(np.eye(2), [[2.0, 0.5], [0.5, 2.0]], np.eye(2), contacts=pads, **parts)
    explorer = fl.explore(structure, t_end=3.0)
    mu_k, mu_s = map(pads.parameter, ("mu_k", "mu_s"))
    explorer.controls[mu_k].value = 0.5
    assert str(explorer.error) == "mu_s must be at least mu_k (0.5), got 0.4: raise mu_s or lower mu_k"
    assert explorer.widget.limits == {mu_k: 0.4}
    explorer.controls[mu_s].value = 0.6
    assert explorer.error is None
    said = [case["message"] for case in rule_data(explorer.model, tuple(explorer.model.parameters))["cases"]]
    assert [text[0] for text in said if "mu_s" in text[0]][-1] == "mu_s must be at least mu_k ("
    labels = [axes.get_ylabel() for axes in fl.plot_run(explorer.run).axes]
    assert "contact force (kN)" in labels
    assert "displacement (mm)" in labels
    sweep = {"transient": 5, "window": 5, "progress": False}
    found, direct = (
        fl.bifurcation(one, mu_k, [0.2, 0.5], resume=tmp_path / file, **sweep)
        for one, file in ((explorer.model, "a.json"), (structure.replace(**{mu_s: 0.6}), "b.json"))
    )
    assert found.kinds == direct.kinds
    assert fl.load_bifurcation(tmp_path / "a.json").kinds == found.kinds
    with pytest.raises(ValueError, match=r"mu_s must be at least mu_k \(0.7\)"):
        pickle.loads(pickle.dumps(explorer.model)).replace(**{mu_k: 0.7})


def test_a_diagram_begins_within_the_rules():
    shown = fl.explore_bifurcation(fl.MassOnBelt(mu_k=0.3, mu_s=0.35)).controls["range"].value
    assert shown == (0.0, 0.35)


def test_films_of_a_structure_are_refused_with_the_cure():
    run = fl.simulate(fl.Structure(np.eye(1), np.eye(1)), 1.0, x0=[1.0, 0.0], progress=False)
    for show in (fl.animate, fl.watch):
        with pytest.raises(ValueError, match=r"got one of a Structure.*take fl.plot_run\(run\)"):
            show(run)
