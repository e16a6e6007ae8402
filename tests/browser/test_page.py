"""An exported page in Chromium, from a file, without a network: results, controls, pictures."""

import json
import re
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.pages.export import SolverNotBuiltError
from tests.browser.screen import come_to, cut_off, faults, wait_until
from tests.helpers import automata

pytestmark = pytest.mark.browser

SWITCHES = ("cubic", "nonsmooth", "geometry")
EIGHT = [some for k in range(4) for some in combinations(SWITCHES, k)]
TEN = [
    {"mu_k": 0.3},
    {"mu_k": 0.55, "v": 2.0},
    {"mu_k": 1.0, "v": 2.0},
    {"mu_k": 1.4},
    {"mu_k": 1.7, "F": 300.0},
    {"mu_k": 2.0, "k_nl": 2e4},
    {"mu_k": 2.5, "F": 1000.0},
    {"mu_k": 0.8, "c1": 20.0},
    {"M": 2.0, "k1": 2e4},
    {"v": 0.1, "mu_s": 1.0, "mu_k": 0.9},
]
SECONDS = 1.0
PANELS = ("mechanism", "response", "phase", "forces", "spectrum", "eigenvalues")
RUN = """([values, without, start, duration]) => {
  const off = Object.fromEntries(without.map((name) => [`switch-${name}`, false]));
  explorer.state = { ...SCENE.initial, ...values, ...off, start, duration };
  explorer.showState();
  explorer.compute(false);
  const { engine: { run }, result } = explorer;
  return { state: run.state, times: Array.from(run.eventTimes), eigenvalues: result.eigenvalues,
           status: explorer.status.textContent };
}"""


def exported(model, path, **options):
    try:
        return fl.export_page(model, path, **options)
    except SolverNotBuiltError as error:
        pytest.skip(str(error))


def opened(browser, path, width=1280, fragment=""):
    context = browser.new_context(viewport={"width": width, "height": 900}, offline=True)
    page = context.new_page()
    page.problems = []
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.on("console", lambda said: page.problems.append(said.text) if said.type == "error" else None)
    page.goto(path.resolve().as_uri() + fragment)
    page.wait_for_selector("body[data-ready]")
    return page


@pytest.fixture(scope="module")
def slider(tmp_path_factory):
    presets = {"strong": {"mu_k": 2.5, "F": 1000.0, "without": ["geometry"]}}
    path = tmp_path_factory.mktemp("pages") / "slider.html"
    return exported(fl.SliderOnBelt(mu_k=1.4), path, presets=presets, t_end=SECONDS)


@pytest.fixture(scope="module")
def page(browser, slider):
    found = opened(browser, slider)
    yield found
    assert not found.problems


def check_same_bits(page, model, values, without=(), start="rest", end=SECONDS, x0=None):
    found = page.evaluate(RUN, [values, list(without), start, end])
    assert "The end was reached" in found["status"]
    run = fl.simulate(model, end, x0=start if x0 is None else x0)
    assert found["state"] == run.final_state.tolist()
    assert found["times"] == run.events.t.tolist()
    return found


@pytest.mark.parametrize("values", TEN, ids=str)
def test_ten_settings_have_the_bits_of_simulate(page, values):
    check_same_bits(page, fl.SliderOnBelt(**{"mu_k": 1.4} | values), values)


@pytest.mark.parametrize("n", [10, 40])
def test_a_structure_has_the_bits_of_simulate(n, browser, tmp_path):
    """Two contacts, with the eigenvalues at the equilibrium that the page finds; the rows of matrices of many
    freedoms are summed side by side.
    """
    rng = np.random.default_rng(3)
    pads = fl.SlidingContacts(
        rng.standard_normal((2, n)), rng.standard_normal((2, n)), fl.LinearContact(k2=50.0),
        fl.Stribeck(mu_k=0.3, mu_s=0.6, v_s=0.3), v=0.5, penetration=0.05,
    )  # fmt: skip
    springs = 200 * np.eye(n) - 100 * np.eye(n, k=1) - 100 * np.eye(n, k=-1)
    structure = fl.Structure(np.eye(n), springs, fl.RayleighDamping(0.01, 1e-4), contacts=pads)
    page = opened(browser, exported(structure, tmp_path / "structure.html", t_end=3.0))
    assert page.title() == "Structure"
    check_same_bits(page, structure, {}, end=3.0)
    found = check_same_bits(page, structure.replace(mu_k=0.1), {"mu_k": 0.1}, end=3.0)
    assert found["times"]
    assert ("and 28 more" in page.inner_text("body")) == (n == 40)
    values = np.array([complex(*pair) for pair in found["eigenvalues"]])
    known = fl.eigenvalues(structure.replace(mu_k=0.1)).values
    assert max(abs(values - value).min() for value in known) < 1e-9 * abs(known).max()
    assert not page.problems


def test_settings_of_a_linear_scene_in_turns_have_affine_maps_of_their_own(page):
    linear = fl.SliderOnBelt(mu_k=1.4).without("cubic", "nonsmooth", "geometry")
    for mu_k in (1.4, 0.3, 1.4):
        check_same_bits(page, linear.replace(mu_k=mu_k), {"mu_k": mu_k}, ("cubic", "nonsmooth", "geometry"))


@pytest.mark.parametrize("without", EIGHT, ids=str)
def test_all_eight_structures_have_the_bits_of_simulate(page, without):
    model = fl.SliderOnBelt(mu_k=1.4).without(*without) if without else fl.SliderOnBelt(mu_k=1.4)
    found = check_same_bits(page, model, {}, without)
    known = fl.eigenvalues(model).values
    values = np.array([complex(*pair) for pair in found["eigenvalues"]])
    assert len(values) == len(known)
    assert max(abs(values - value).min() for value in known) < 1e-9 * abs(known).max()


def test_a_scene_that_is_kept_has_the_colours_of_now(page):
    inks = "[explorer.picture, explorer.kept.picture].map(({ scene }) => scene.ink)"
    page.click("button.fl-compare")
    light = page.evaluate(inks)
    page.click("button.fl-theme")
    dark = page.evaluate(inks)
    for button in ("theme", "compare"):
        page.click(f"button.fl-{button}")
    assert light[0] == light[1] != dark[0] == dark[1]


PLACES = """(l1) => {
  explorer.state = { ...SCENE.initial, l1 };
  explorer.compute(false);
  const [samples] = explorer.shownSample();
  return Array.from(explorer.picture.row(samples, 0).all);
}"""


def test_the_wheels_of_the_belt_are_where_their_parameters_say(page):
    far, near = (page.evaluate(PLACES, l1) for l1 in (0.2, 0.1))
    assert [far[16], near[16]] == pytest.approx([-1.0, -0.5], abs=0.1)
    assert page.evaluate(PLACES, 0.2) == far


AUTOMATA = {
    "ball": (automata.ball(), [1.0, 0.0], "e", 0.7, "floor"),
    "belt": (automata.coulomb(0.2, 1.0, 0.5), [0.0, 0.0], "mu_k", 0.4, "v_r"),
    "thermostat": (automata.thermostat(), [15.0], "heat", 7.0, "limit"),
    "named": (automata.named(), [0.4, 1.0], "limit of spring", 0.2, "ünder & <i>"),
}


@pytest.mark.parametrize("name", AUTOMATA)
def test_automata_have_the_bits_of_simulate_and_their_own_words(browser, tmp_path, axe, name):
    automaton, start, parameter, value, event = AUTOMATA[name]
    page = opened(browser, exported(automaton, tmp_path / "page.html", x0=start))
    for changes in ({}, {parameter: value}):
        model = automaton.replace(**changes)
        found = check_same_bits(page, model, changes, start="own", end=20.0, x0=start)
        assert f" {event}" in found["status"]
        try:
            known = fl.eigenvalues(model).values
        except ValueError:
            assert found["eigenvalues"] is None
        else:
            values = np.array([complex(*pair) for pair in found["eigenvalues"]])
            assert np.abs(np.sort_complex(values) - np.sort_complex(known)).max() < 1e-9
    text = page.inner_text("body")
    assert not [word for word in ("sliding", "displacement", "velocit", "vibrates", "()") if word in text]
    for width in (390, 1280):
        page.set_viewport_size({"width": width, "height": 844})
        assert come_to(page, [], lambda: cut_off(page, "#explorer")) == []
    assert faults(page, axe, "html") == []
    assert not page.problems
    page.context.close()


BOTH_WAYS = """async ([without, mu]) => {
  const { solver } = explorer.engine, structure = STRUCTURES[without];
  const value = (name) => name === "mu_k" ? mu : explorer.state[name] ?? structure.fixed[name];
  const values = structure.parameters.map(value);
  const run = () => {
    const { state, steps, events, eventTimes } = solver.run(structure, values, structure.release(values), 1);
    return [state, steps, events, Array.from(eventTimes)];
  };
  solver.load(structure);
  await solver.useJets(structure);
  const native = run();
  solver.arrays["code.native"].view.fill(0n);
  const interpreted = run();
  solver.arrays["code.native"].view.set(structure.jets);
  return [native, interpreted, structure.jets.every((place) => place > 0n)];
}"""


@pytest.mark.parametrize("without", ["", "cubic", "geometry", "nonsmooth"])
def test_machine_code_of_the_modes_and_the_interpreter_have_the_same_bits(page, without):
    native, interpreted, all_modes = page.evaluate(BOTH_WAYS, [without, 1.4])
    assert all_modes
    assert native == interpreted
    assert native[1] > 50


def test_machine_code_of_functions_and_quotients_has_the_bits_of_the_interpreter(browser, tmp_path):
    model = fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.1)
    page = opened(browser, exported(model, tmp_path / "page.html", t_end=5.0))
    native, interpreted, all_modes = page.evaluate(BOTH_WAYS, ["", 0.5])
    assert all_modes
    assert native == interpreted
    page.context.close()


@pytest.mark.slow
@pytest.mark.parametrize("law", [fl.HertzContact(), fl.PressureDependent(n=0.9)], ids=str)
def test_machine_code_of_powers_has_the_bits_of_the_interpreter_and_of_simulate(browser, tmp_path, law):
    """Fractional powers, whose series end early where the contact begins and ends."""
    role = {"contact": law} if isinstance(law, fl.ContactLaw) else {"friction": law}
    model = fl.SliderOnBelt(**role).replace(mu_k=1.4)
    page = opened(browser, exported(model, tmp_path / "page.html", t_end=SECONDS))
    native, interpreted, all_modes = page.evaluate(BOTH_WAYS, ["", 1.4])
    assert all_modes
    assert native == interpreted
    assert native[2] > 20
    check_same_bits(page, model, {})
    page.context.close()


def test_the_file_is_below_a_megabyte(slider):
    assert 1e5 < Path(slider).stat().st_size < 1e6


def picture(page, name):
    return page.evaluate("(name) => explorer.panels[name].canvas.toDataURL()", name)


def final(page):
    return page.evaluate("explorer.result.final")


DRAGS = """async (count) => {
  const slider = explorer.root.querySelector("[data-name=mu_k] input[type=range]"), painted = {};
  const { paint } = explorer;
  explorer.paint = (panel, look) => { painted[panel.name] = true; paint.call(explorer, panel, look); };
  for (let i = 0; i < count; i++) {
    slider.value = 20 + i;
    slider.oninput();
    await new Promise(requestAnimationFrame);
  }
  const followed = Object.keys(painted);
  while (!explorer.result.complete) await new Promise((done) => setTimeout(done, 50));
  return { followed, shown: explorer.state.mu_k, settled: explorer.result.parameters.mu_k };
}"""


def test_all_plots_follow_a_slider_and_are_whole_when_it_stops(browser, slider):
    page = opened(browser, slider)
    found = page.evaluate(DRAGS, 20)
    assert set(found["followed"]) >= {"response", "phase", "forces", "eigenvalues"}
    assert found["shown"] == found["settled"]
    assert not page.problems
    page.context.close()


PAINTED = """() => {
  const c = new SvgContext(300, 200, "#fff"), X = new Axis([0, 1], [0, 300]), Y = new Axis([-1, 1], [200, 0]);
  const x = Float64Array.from({ length: 10001 }, (_, i) => i / 1e4), y = x.map((v) => Math.sin(40 * v) / 2);
  y[5000] = 1; // a peak of one sample
  y.fill(0.3, 7000, 8000); // a level
  y[9000] = NaN; // a gap
  paintLine(c, x, y, X, Y);
  const parts = c.nodes.at(-1).match(/[ML][^ML"]+/g);
  return parts.map((part) => [part[0], ...part.slice(1).split(" ").map(Number)]);
}"""


def test_a_line_is_painted_to_a_pixel_with_few_points(page):
    points = page.evaluate(PAINTED)
    kinds, x, y = zip(*points, strict=True)
    assert len(points) < 1500
    assert [i for i, kind in enumerate(kinds) if kind == "M"] == [0, kinds.index("M", 1)]
    assert (150.0, 0.0) in zip(x, y, strict=True)
    level = [(a, b) for a, b in zip(x, y, strict=True) if abs(b - 70) < 1e-9]
    assert level[0][0] == pytest.approx(210, abs=0.02)
    assert level[-1][0] == pytest.approx(240, abs=0.05)
    smooth = [(a, b) for a, b in zip(x, y, strict=True) if a < 149 or 151 < a < 209]
    assert max(abs(100 - 50 * np.sin(40 * a / 300) - b) for a, b in smooth) < 0.1  # as the text is rounded
    assert max(np.diff([a for a, _ in smooth if a < 149])) < 1.1


def test_a_dark_page_is_printed_on_white_paper(page):
    page.evaluate("explorer.setTheme('dark')")
    page.evaluate("addEventListener('beforeprint', () => { window.printed = explorer.look().paper; })")
    page.pdf()
    assert page.evaluate("[window.printed, explorer.look().paper]") == ["#ffffff", "#111111"]
    page.evaluate("explorer.setTheme('light')")


def test_the_link_holds_what_is_set(browser, slider):
    page = opened(browser, slider, fragment="#mu_k=2&without=geometry&t_end=0.5")
    run = fl.simulate(fl.SliderOnBelt(mu_k=2.0).without("geometry"), 0.5)
    assert final(page) == run.final_state.tolist()
    assert page.evaluate("linkText(explorer.state, SCENE)") == "mu_k=2&without=geometry&t_end=0.5"
    assert not page.is_checked("[data-name=switch-geometry] input")
    page.context.close()


INTRUDE = """async () => {
  const broken = [];
  document.addEventListener("securitypolicyviolation", (event) => broken.push(event.violatedDirective));
  const script = Object.assign(document.createElement("script"), { textContent: "window.intruded = 1" });
  document.body.append(script, Object.assign(new Image(), { src: "https://example.org/a.png" }));
  const other = '<img src="a.png" style="color: red" onerror="window.intruded = 2">';
  document.body.insertAdjacentHTML("beforeend", other);
  const answer = await fetch("https://example.org/").catch(() => "refused");
  await new Promise((done) => setTimeout(done, 200));
  return [answer, window.intruded, [...new Set(broken)].sort()];
}"""


def test_a_page_runs_nothing_but_its_own_scripts_whatever_its_title(browser, tmp_path):
    path = exported(fl.MassOnBelt(c=0.1), tmp_path / "page.html", t_end=1.0, title="a <!--<script> b")
    page = opened(browser, path)
    assert page.title() == page.inner_text("h1.fl-title") == "a <!--<script> b"
    assert not page.problems
    answer, intruded, broken = page.evaluate(INTRUDE)
    assert (answer, intruded) == ("refused", None)
    assert broken == ["connect-src", "img-src", "script-src-attr", "script-src-elem", "style-src-attr"]
    page.context.close()


def test_presets_and_switches(page):
    page.select_option(".fl-scene select", label="strong")
    wait_until(page, "explorer.result.structure === STRUCTURES.geometry")
    wait_until(page, "explorer.state.F === 1000")
    page.check("[data-name=switch-geometry] input")
    wait_until(page, "explorer.result.structure === STRUCTURES['']")


def test_copied_python_computes_the_same(page):
    found = page.evaluate(RUN, [{"mu_k": 0.7}, ["cubic"], "rest", 0.5])
    page.click("button.fl-copy")
    wait_until(page, "explorer.copied")
    scope = {}
    exec(page.evaluate("explorer.copied"), scope)
    assert scope["run"].final_state.tolist() == found["state"]


@pytest.mark.parametrize("reduced", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_link_may_start_to_play_unless_motion_is_to_be_reduced(browser, slider, reduced):
    page = opened(browser, slider, fragment="#play=1&mu_k=1.5")
    if reduced:
        page.emulate_media(reduced_motion="reduce")
        page.goto("about:blank")
        page.goto(slider.resolve().as_uri() + "#play=1&mu_k=1.5")
        page.wait_for_selector("body[data-ready]")
    assert page.inner_text("button.fl-play") == ("play" if reduced else "pause")
    begin = page.evaluate("explorer.share")
    if reduced:
        page.wait_for_timeout(200)
        assert page.evaluate("explorer.share") == begin
    else:
        page.wait_for_function("(begin) => explorer.share !== begin", arg=begin)
    assert page.input_value("[data-name=mu_k] .fl-field") == "1.5"
    assert not page.problems
    page.context.close()


BROKEN = [
    {"mu_k": 2.0, "mu_s": 1.5},
    {"mu_k": 1e-5, "mu_s": 0.0},
    {"mu_k": -1.0},
    {"M": 0.0},
    {"k2": -2e16},
    {"F": -1.0, "mu_s": 0.1},
]


def words_of(model, values):
    with pytest.raises(ValueError, match="must be") as error:
        model.replace(**values)
    return str(error.value)


@pytest.mark.parametrize("values", BROKEN, ids=str)
def test_a_broken_rule_is_said_in_the_words_of_the_model(page, values):
    before = page.evaluate(RUN, [{}, [], "rest", SECONDS])["state"]
    found = page.evaluate(RUN, [values, [], "rest", SECONDS])
    assert found["status"] == words_of(fl.SliderOnBelt(mu_k=1.4), values)
    assert found["state"] == before


@pytest.mark.parametrize("end", ["low", "high"])
def test_the_ends_of_every_slider_give_a_run_or_say_why_not(page, end):
    at_ends = """(end) => SCENE.controls.filter(({ name, parameter }) =>
      parameter && explorer.engine.has(name, SCENE.initial)).map((about) => {
      explorer.state = { ...SCENE.initial, duration: 0.05, [about.name]: about[end] };
      explorer.compute(false);
      const { parameters } = explorer.result;
      return [about.name, about[end], explorer.status.textContent, parameters[about.name]];
    })"""
    found = page.evaluate(at_ends, end)
    model = fl.SliderOnBelt(mu_k=1.4)
    assert len(found) == len(model.parameters)
    for name, value, status, computed in found:
        if status.startswith("The end was reached"):
            assert computed == value == model.replace(**{name: value}).parameters[name]
        else:
            assert status == words_of(model, {name: value})


@dataclass(frozen=True)
class Softening(fl.FrictionLaw):
    """A law that no model of the package has."""

    mu_k: float = fl.parameter(0.5, symbol="mu_k", meaning="friction coefficient", minimum=0.0)
    mu_s: float = fl.parameter(1.0, symbol="mu_s", meaning="static friction coefficient", minimum=0.0)
    rate: float = fl.parameter(2.0, symbol="a", meaning="rate of the decay", maximum=50.0, unit="s/m")

    def check(self):
        if self.rate <= 0 or not 2 * self.mu_k < 3 + abs(self.mu_s):
            least = f"{(3 + self.mu_s) / 2:g}"
            raise ValueError(f"mu_k must be below {least} and rate above 0, got {self.mu_k}, {self.rate!r}")

    def kinetic(self, normal_force, speed):
        return (self.mu_k + (self.mu_s - self.mu_k) * fl.functions.exp(-self.rate * speed)) * normal_force

    def static_limit(self, normal_force):
        return self.mu_s * normal_force


def test_a_law_of_the_menu_has_the_bits_of_simulate_and_its_own_parameters(page):
    page.evaluate("explorer.set(SCENE.initial)")
    page.get_by_label("friction law").select_option("Stribeck")
    wait_until(page, "explorer.request === null && 'v_s' in (explorer.result?.parameters ?? {})")
    assert page.locator(".fl-panel-friction").is_visible()
    assert "friction=Stribeck" in page.evaluate("explorer.link()")
    law, scope = fl.Stribeck(mu_k=1.4, mu_s=3.0, v_s=0.7), {}
    check_same_bits(page, fl.SliderOnBelt(friction=law), {"v_s": 0.7, "friction": "Stribeck"})
    exec(page.evaluate("explorer.engine.python(explorer.state)"), scope)
    assert scope["model"].friction == law
    page.get_by_role("checkbox", name="cubic contact").uncheck()
    wait_until(page, "explorer.error.includes('only with all nonlinearities on')")
    page.evaluate("explorer.set(SCENE.initial)")
    wait_until(page, "explorer.request === null && !explorer.error")
    assert page.locator(".fl-panel-friction").is_hidden()


LONG_RUN = """([end]) => {
  const { engine, engine: { solver } } = explorer, structure = engine.structureOf(explorer.state);
  const values = engine.parametersOf(structure, explorer.state);
  const run = solver.run(structure, values, structure.release(values), end);
  const first = Array.from(sample(solver, run, Float64Array.of(0.25 * end, 0.75 * end)).column("x1"));
  return { state: run.state, steps: run.steps, times: Array.from(run.eventTimes), first };
}"""


@pytest.mark.slow
def test_a_run_goes_on_where_its_records_are_full(browser, tmp_path):
    """Under Hertz's law 20 s have more steps than there is room for at first."""
    model = fl.SliderOnBelt(mu_k=1.4, contact=fl.HertzContact())
    page = opened(browser, exported(model, tmp_path / "page.html", switches=(), t_end=1.0))
    first = page.evaluate(LONG_RUN, [1.0])
    found, room = page.evaluate(LONG_RUN, [20.0]), page.evaluate("2048 * RECORDS")
    run = fl.simulate(model, 20.0, t_eval=[5.0, 15.0])
    assert found["steps"] == run.stats["steps"] > room > first["steps"]
    assert found["state"] == run.final_state.tolist()
    assert found["times"] == run.events.t.tolist()
    assert found["first"] == run["x1"].tolist()
    assert page.evaluate(LONG_RUN, [1.0]) == first
    assert not page.problems
    page.context.close()


def test_a_law_of_ones_own_is_exported(browser, tmp_path):
    model = fl.MassOnBelt(friction=Softening(), c=0.1)
    page = opened(browser, exported(model, tmp_path / "page.html", t_end=5.0), fragment="#rate=3.5")
    run = fl.simulate(model.replace(rate=3.5), 5.0)
    assert final(page) == run.final_state.tolist()
    for values in ({"rate": -1.0}, {"mu_k": 2.5}, {"mu_k": 1234567.0, "mu_s": 2e6}, {"rate": 51.0}):
        page.evaluate(
            "(values) => { Object.assign(explorer.state, values); explorer.compute(false); }", values
        )
        assert page.inner_text(".fl-status") == words_of(model, {"rate": 3.5} | values)
        page.evaluate("explorer.state = readLink('#rate=3.5', SCENE).state")
    assert not page.problems
    page.context.close()


@fl.model
class HeatedMass(fl.MechanicalModel):
    """A further state, names of several words, and a number without a range."""

    m: float = 1.0
    k_spring: float = 100.0
    F_pre_load: float = 10.0
    heat_capacity: float = 5.0
    mu_gap: float = 0.0
    friction: fl.FrictionLaw = fl.Stribeck(mu_k=0.3, mu_s=0.6, v_s=0.1)

    coordinates = ("x",)
    states = ("T_hot",)

    def mechanics(self, q, v, others):
        pressed = self.F_pre_load * (1 - others.T_hot / 100)
        warmed = {"T_hot": (0.2 * self.F_pre_load - others.T_hot) / self.heat_capacity}
        contact = fl.Friction(0.2 - v.x, pressed, self.friction)
        energies = self.m * v.x**2 / 2, self.k_spring * (q.x - self.mu_gap) ** 2 / 2
        return fl.Mechanics(*energies, contacts=(contact,), rates=warmed)


def test_a_further_state_and_names_of_several_words(browser, tmp_path):
    page = opened(browser, exported(HeatedMass(), tmp_path / "page.html", t_end=5.0))
    names = {"F_pre_load": "Fpre load", "heat_capacity": "heat capacity", "mu_gap": "μgap"}
    for name, text in names.items():
        assert page.locator(f"[data-name={name}] .fl-label").text_content() == text
    assert "Thot = 2" in page.inner_text(".fl-numbers").replace("\n", "")
    page.select_option("[data-name=start] select", "own")
    wait_until(page, "explorer.result.from === 'own' && explorer.request === null")
    assert final(page) == fl.simulate(HeatedMass(), 5.0, x0=[0.0, 0.0], progress=False).final_state.tolist()
    page.evaluate("explorer.startAt({ x: 0.1 }, 'x')")
    assert page.evaluate("explorer.state.own") == "0.1, 0, 2"
    zeros = {
        "m": "the mass of 'x' is 0 at m = 0",
        "heat_capacity": "none with heat_capacity = 0, mu_gap = 0",
    }
    for name, rule in zeros.items():
        page.evaluate("(zero) => explorer.set({ ...SCENE.initial, ...zero })", {name: 0})
        wait_until(page, "(rule) => explorer.error.includes(rule)", rule)
    assert not page.problems
    page.context.close()


@pytest.fixture
def mass(browser, tmp_path):
    page = opened(browser, exported(fl.MassOnBelt(mu_k=0.5), tmp_path / "mass.html", t_end=20.0))
    yield page
    assert page.problems == []
    page.context.close()


def started(page):
    """The state in which the run begins, once it has the bits of `simulate` from there; it is shown."""
    wait_until(page, "explorer.state.start === 'own' && explorer.request === null")
    assert page.evaluate("[explorer.result.start, explorer.result.from]") == [0.0, "own"]
    own = [float(one) for one in page.evaluate("explorer.state.own").split(",")]
    state = page.evaluate("explorer.engine.run.state")
    assert state == fl.simulate(fl.MassOnBelt(mu_k=0.5), 20.0, x0=own, progress=False).final_state.tolist()
    return own


def test_a_click_into_the_phase_plane_starts_the_motion_there(mass):
    box = mass.locator(".fl-panel-phase .fl-over").bounding_box()
    mass.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.4 * box["height"])
    assert all(started(mass))


WHERE_THE_MASS_IS = """() => {
  const { drag } = explorer, { k, x, y } = drag.scale, [{ box }] = drag.bodies;
  const { left, top } = drag.over.getBoundingClientRect();
  return [left + x + k * box[0], top + y - k * box[1]];
}"""


def test_the_mass_is_taken_by_mouse_finger_and_keys_and_the_motion_starts_where_it_is_let_go(mass):
    x, y = mass.evaluate(WHERE_THE_MASS_IS)
    before = picture(mass, "mechanism")
    mass.mouse.move(x, y)
    mass.mouse.down()
    mass.mouse.move(x + 40, y, steps=3)
    assert picture(mass, "mechanism") != before
    assert "x = " in mass.inner_text(".fl-now")
    mass.mouse.up()
    (first, rate) = started(mass)
    assert first > 0.0 == rate
    assert mass.inner_text("button.fl-play") == "pause"
    mass.click("button.fl-play")

    x, y = mass.evaluate(WHERE_THE_MASS_IS)
    touch = mass.context.new_cdp_session(mass)
    for kind, at in (("Start", x), ("Move", x - 30), ("Move", x - 60), ("End", None)):
        points = [] if at is None else [{"x": at, "y": y}]
        touch.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})
    wait_until(mass, "(first) => Number(explorer.state.own.split(',')[0]) < first", first)
    second = started(mass)
    mass.click("button.fl-play")

    mass.locator(".fl-panel-mechanism .fl-over").focus()
    for key in ("ArrowRight", "ArrowRight", "Enter"):
        mass.keyboard.press(key)
    assert started(mass) != second


def test_of_an_angle_that_turns_for_ever_the_rate_is_heard(browser, tmp_path):
    page = opened(browser, exported(fl.DrillString(), tmp_path / "drill.html", laws=()))
    run = fl.simulate(fl.DrillString(), page.evaluate("explorer.state.duration"), progress=False)
    strongest = fl.amplitude_spectrum(run, "phi1'").strongest
    assert f"sticks and slips at {strongest:.3g} Hz" in page.inner_text(".fl-words")
    assert not page.problems
    page.context.close()


PLACE_AND_PIXELS = """() => { // the mass in metres, and pixels for a metre
  const { drag } = explorer, [samples, i] = explorer.shownSample();
  return [samples.column("x")[i], drag.scale.k / drag.bodies[0].along.x(1)];
}"""


def test_one_drag_of_the_front_page_gives_the_other_fate(browser, tmp_path):
    front = (Path(__file__).parents[2] / "docs/index.md").read_text(encoding="utf-8")
    model = eval("fl." + re.search(r":model: (.*)", front)[1])
    page = opened(browser, exported(model, tmp_path / "front.html"))
    assert "stable, but from rest this run sticks and slips" in page.inner_text(".fl-words")
    rest = fl.equilibrium(model).q[0]
    for distance, fate in ((0.3, "falls silent"), (0.9, "sticks and slips"), (-0.3, "falls silent")):
        x, y = page.evaluate(WHERE_THE_MASS_IS)
        now, pixels = page.evaluate(PLACE_AND_PIXELS)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + pixels * (rest + distance - now), y, steps=3)
        page.mouse.up()
        wait_until(
            page, "(fate) => explorer.request === null && explorer.words.innerText.includes(fate)", fate
        )
        assert f"from your own state this run {fate}" in page.inner_text(".fl-words")
        page.click("button.fl-play")
    assert not page.problems
    page.context.close()


WHERE_A_POINT_IS = """(i) => {
  const { drawing, axes: { X, Y }, over } = explorer.panels.friction, { x, y } = drawing.handles[i];
  const { left, top } = over.getBoundingClientRect();
  return [left + X.at(x), top + Y.at(y)];
}"""


FORMULAS = {
    "0.3 + alert(1)": "no name but v, pi, e, exp",
    "constructor": "got 'constructor'",
    "2*(v": "close a bracket where it has its end",
    "0.3 v": "have an operation where it has 'v'",
    "sqrt(-1 - v)": "a number at each point",
}


def test_a_point_of_a_friction_curve_is_dragged_and_motion_and_stability_follow(browser, tmp_path):
    model = fl.MassOnBelt(friction=fl.FrictionCurve(), c=0.1, v=0.5)
    page = opened(browser, exported(model, tmp_path / "curve.html", t_end=20.0))
    assert "stable" in page.inner_text(".fl-words")
    x, y = page.evaluate(WHERE_A_POINT_IS, 2)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y - 60, steps=3)
    page.mouse.up()
    wait_until(page, "explorer.request === null && explorer.result.complete")
    values = page.evaluate("explorer.result.parameters")
    assert values["mu_2"] > model.mu_2
    assert values["v_2"] > model.v_2
    moved = model.replace(**{name: values[name] for name in ("mu_2", "v_2")})
    assert final(page) == fl.simulate(moved, 20.0, progress=False).final_state.tolist()
    speed, _, slope, damper = page.evaluate("explorer.result.friction.at")
    growth = fl.eigenvalues(moved).values[0].real
    assert (speed, slope) == (0.5, damper)
    assert -(0.1 + damper) / 2 == pytest.approx(growth, rel=1e-12)
    assert "unstable" in page.inner_text(".fl-words")
    field = page.get_by_label("μ(v) =")
    field.fill("0.3 + 0.1*exp(-abs(v)/0.2)")
    field.press("Enter")
    wait_until(page, "explorer.request === null && explorer.panels.friction.drawing.note.includes('formula')")
    speeds = [0.0, *(page.evaluate(f"explorer.state.v_{i}") for i in range(1, 5))]
    expected = [0.3 + 0.1 * np.exp(-v / 0.2) for v in speeds]
    values = page.evaluate("[0, 1, 2, 3, 4].map((i) => explorer.state[`mu_${i}`])")
    assert values == pytest.approx(expected, rel=1e-3)
    slope = -0.5 * np.exp(-0.5 / 0.2)
    assert f"formula: slope −{-slope:.3g} s/m" in page.evaluate("explorer.panels.friction.drawing.note")
    for text, words in FORMULAS.items():
        field.fill(text)
        field.press("Enter")
        assert words in page.inner_text("[data-name=formula] .fl-message")
    assert page.evaluate("explorer.state.formula").startswith("0.3 + ")
    assert not page.problems
    page.context.close()


def test_a_lesson_is_recorded_and_replayed_from_its_link_and_its_file(browser, tmp_path):
    model = fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.2)
    path = exported(model, tmp_path / "mass.html", laws=())
    page = opened(browser, path)
    page.evaluate("explorer.lesson.record()")
    for speed, text in (("0.5", "It sticks & slips."), ("1.5", "<b>Faster</b>: it is silent.")):
        page.fill(".fl-control[data-name=v] .fl-field", speed)
        page.keyboard.press("Enter")
        wait_until(page, f"explorer.result?.parameters.v === {speed} && explorer.request === null")
        page.get_by_label("text of the step").fill(text)
        page.get_by_role("button", name="add step").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="finish").click()
    download.value.save_as(tmp_path / "lesson.json")
    steps = json.loads((tmp_path / "lesson.json").read_text(encoding="utf-8"))["steps"]
    assert [(step["control"], step["changed"]) for step in steps] == [("v", {"v": 0.5}), ("v", {"v": 1.5})]
    link = page.evaluate("explorer.link()")
    assert not page.problems
    page.context.close()
    learner = opened(browser, path, fragment="#" + link.partition("#")[2])
    replay(learner)
    learner.get_by_role("button", name="end the lesson").click()
    assert learner.locator(".fl-lesson").is_hidden()
    assert learner.url.partition("#")[2] == "v=1.5"
    learner.set_input_files("input[type=file]", tmp_path / "lesson.json")
    replay(learner)
    assert not learner.problems
    learner.context.close()


def replay(page):
    """Its first step, then the second, each with the control that it is about."""
    wait_until(page, "explorer.state.v === 0.5")
    assert page.inner_text(".fl-step") == "It sticks & slips."
    page.get_by_role("button", name="next").click()
    wait_until(page, "explorer.state.v === 1.5")
    assert page.inner_text(".fl-step") == "<b>Faster</b>: it is silent."
    assert page.locator("[data-name=v].fl-marked").is_visible()
    assert page.get_by_role("button", name="next").is_disabled()


def test_a_challenge_is_solved_and_its_link_is_the_proof(browser, tmp_path):
    path = exported(fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.2), tmp_path / "mass.html")
    page = opened(browser, path)
    page.select_option("select[aria-label=challenge]", label="faster")
    wait_until(page, "explorer.challengeBox.innerText.includes('Not yet.') && explorer.state.c === 0.1")
    page.fill(".fl-control[data-name=v] .fl-field", "1.5")
    page.keyboard.press("Enter")
    wait_until(page, "explorer.challengeBox.innerText.includes('Solved: v = 1.5.')")
    link = page.evaluate("explorer.link()")
    assert not page.problems
    page.context.close()
    proof = opened(browser, path, fragment="#" + link.partition("#")[2])
    assert "End the stick-slip by the belt's speed alone.\n\nSolved: v = 1.5." in proof.inner_text(
        ".fl-challenge"
    )
    assert not proof.problems
    proof.context.close()


def test_keys_of_a_player_do_nothing_where_there_is_none(browser, tmp_path, monkeypatch):
    monkeypatch.setattr("frictionlab.pages.export.panels_of", lambda _: ["eigenvalues"])
    page = opened(browser, exported(fl.MassOnBelt(), tmp_path / "page.html"))
    page.evaluate("() => { explorer.engine.hear = () => { throw new Error('it is heard'); }; }")
    page.keyboard.press("s")
    assert not page.evaluate("explorer.heard.textContent")
    assert not page.problems
