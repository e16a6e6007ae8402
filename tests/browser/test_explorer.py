"""The explorer as an exported page, in `frictionlab app` and in JupyterLab, by what is on the screen.

What only pages have is in test_page.py, what only Python's engine has in test_python_engine.py.
"""

import csv
import json
import re
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import frictionlab as fl
from frictionlab.analysis.period_of_motion import oscillation_period
from frictionlab.pages.export import SolverNotBuiltError
from frictionlab.pages.gallery import export_gallery, library_scenes
from frictionlab.presentation import unit_of_state
from tests.browser.screen import (
    PATIENCE,
    changed,
    come_to,
    cut_off,
    faults,
    flip,
    press,
    settled,
    wait_until,
)
from tests.browser.servers import (
    SCENES,
    app,
    free_port,
    in_lab,
    printed_path,
    run_all,
    serving,
    write_notebook,
)
from tests.helpers.cases import slow_but

pytestmark = pytest.mark.browser

ROOT = ".fl-explorer"
SIZES = {390: 844, 1280: 800, 1920: 1080}
LIBRARY = {each.name: each for each in library_scenes()}
AT_ONCE = "two fates", "BouncingBall()"
READS = "([name, text]) => document.querySelector(`[data-name='${name}'] .fl-field`)?.value === text"
SAYS = "([of, text]) => document.querySelector(of)?.innerText.includes(text)"


@dataclass
class Place:
    """Where the explorer is shown, at rest; `folder` holds the exported pages, None where Python answers."""

    name: str
    page: Any
    folder: Path | None = None
    failures: list[str] = field(default_factory=list)

    def choose(self, scene):
        """A scene of the library as it opens."""
        if self.folder is not None:
            file = self.folder / LIBRARY[scene].file
            if not file.exists():
                export_gallery(self.folder, [LIBRARY[scene]])
            self.page.goto("about:blank")
            self.page.goto(file.as_uri())
            self.page.wait_for_selector("body[data-ready]")
        elif (menu := self.page.locator(".fl-scene select")).input_value() != scene:
            menu.select_option(scene)
        self.says(".fl-about", LIBRARY[scene].about)
        self.page.wait_for_selector(f"{ROOT} .fl-words:not(:empty)")
        settled(self.page, ROOT)

    def press_button(self, name):
        self.page.get_by_role("button", name=name, exact=True).first.click()

    def type_into(self, name, value):
        self.page.locator(f".fl-control[data-name={name}] .fl-field").fill(repr(value))
        self.page.keyboard.press("Enter")

    def select(self, name, option):
        self.page.locator(f".fl-control[data-name={name}] select").select_option(option)

    def reads(self, name, text):
        wait_until(self.page, READS, [name, text])

    def says(self, part, text):
        wait_until(self.page, SAYS, [part, text])

    def file_of(self, button, path):
        """What a button of the menu of files writes."""
        self.page.locator(".fl-files > summary").click()
        with self.page.expect_download() as waiting:
            self.press_button(button)
        waiting.value.save_as(path)
        assert self.page.locator(".fl-files[open]").count() == 0
        return path.read_text(encoding="utf-8")

    def make_dark(self, dark):
        """Pages and the app have a button, JupyterLab its own setting."""
        if self.name != "notebook":
            return self.press_button("dark" if dark else "light")
        self.page.locator(".lm-MenuBar-item").get_by_text("Settings", exact=True).click()
        self.page.locator(".lm-Menu-item").get_by_text("Theme", exact=True).click()
        name = "JupyterLab Dark" if dark else "JupyterLab Light"
        self.page.locator(".lm-Menu-item").get_by_text(name, exact=True).click()
        light = str(not dark).lower()
        wait_until(self.page, "(light) => document.body.dataset.jpThemeLight === light", light)


@pytest.fixture(scope="module")
def place(request, browser, tmp_path_factory):
    """One of the three places, and at its end that nothing went wrong there."""
    folder = tmp_path_factory.mktemp(request.param)
    context = browser.new_context(viewport={"width": 1280, "height": 800}, color_scheme="light")
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    shown = Place(request.param, page)
    page.on("pageerror", lambda error: shown.failures.append(str(error)))
    if request.param == "page":
        context.set_offline(True)
        shown.folder = folder
        try:
            export_gallery(folder, [LIBRARY["two fates"]])
        except SolverNotBuiltError as error:
            pytest.skip(str(error))
        yield shown
    else:
        yield from served(shown, folder)
    context.close()
    assert shown.failures == []


def served(shown, folder):
    """The app or JupyterLab with the explorer of all models."""
    in_app, port = shown.name == "app", free_port()
    module = "voila" if in_app else "jupyterlab"
    if find_spec(module) is None:
        pytest.skip(f"{module} shows the explorer; it is not installed")
    write_notebook(folder, SCENES)
    with serving((app if in_app else in_lab)(folder, port), port, folder) as address:
        # The tests need no network, and nothing that they see comes from there.
        here = (address, "blob:", "data:")
        shown.page.route(lambda url: not url.startswith(here), lambda route: route.abort())
        path = printed_path(folder) if in_app else "/doc/tree/page.ipynb"
        shown.page.goto(address + path, wait_until="commit")
        if not in_app:
            run_all(shown.page)
        shown.page.wait_for_selector(f"{ROOT} .fl-words:not(:empty)", timeout=3 * PATIENCE)
        settled(shown.page, ROOT)
        yield shown
        assert shown.page.get_by_text("Error displaying widget").count() == 0


@pytest.fixture
def slider(place):
    """The first scene as it opens, in a window of usual size."""
    place.page.set_viewport_size({"width": 1280, "height": 800})
    place.choose("two fates")
    if place.page.locator("button.fl-reset").is_enabled():
        place.press_button("reset")
    place.reads("mu_k", "1.4")
    settled(place.page, ROOT)
    return place


def places(*at_once):
    """Of page, app and notebook some at once; all others are slow, and show the same front end."""
    cases = slow_but(at_once, {name: name for name in ("page", "app", "notebook")})
    return pytest.mark.parametrize("place", cases, indirect=True, scope="module")


everywhere = places("page")


def open_all(page):
    """Open what is folded."""
    page.locator(f"{ROOT} details.fl-group").evaluate_all("(all) => all.forEach((e) => { e.open = true })")
    page.wait_for_timeout(300)


# Move each slider by one position, away from the end it may be at, and back; what the fields show before and
# after.
ROUND_TRIP = """async (root) => {
  const controls = [...document.querySelectorAll(root + " .fl-number:not([hidden])")].map((c) =>
    [c.querySelector("input[type=range]"), c.querySelector("input[type=text]")]);
  const fields = () => controls.map(([, field]) => field.value), before = fields();
  for (const [range] of controls) {
    const home = range.value, end = home === range.max;
    range.value = Number(home) + (end ? -1 : 1);
    range.oninput();
    range.value = home;
    range.oninput();
  }
  return { before, after: fields() };
}"""


@places("page", "app")
@pytest.mark.parametrize("name", slow_but(AT_ONCE, LIBRARY))
def test_every_scene_has_the_bits_of_simulate_and_its_units_and_nothing_is_clipped(
    place, name, axe, tmp_path
):
    model, page = LIBRARY[name].model, place.page
    end = 10 * oscillation_period(model)
    place.choose(name)
    open_all(page)
    if page.locator(".fl-control[data-name=method]").count():
        place.select("method", "exact (Taylor)")
    place.select("window", "whole run")
    place.type_into("duration", end)
    settled(page, ROOT)
    state = json.loads(place.file_of("save state", tmp_path / "state.json"))
    changed = {"duration": end, "window": "whole run"}
    assert {key: value for key, value in state["changed"].items() if key != "method"} == changed
    run = fl.simulate(model, end, progress=False)

    def end_of_data():
        text = place.file_of("data csv", tmp_path / "data.csv")
        names, *_, last = csv.reader(text.splitlines())
        assert names[: len(columns)] == list(columns)
        return [float(value) for value in last[: len(columns)]]

    # a model may have time among its states, too
    columns = {"t": run.raw.t} | dict(zip(run.names, run.final_state.tolist(), strict=True))
    ends = list(columns.values())
    assert come_to(page, ends, end_of_data) == ends
    texts = re.sub("<[^>]*>", "", place.file_of("figure svg", tmp_path / "figure.svg"))
    shown = model.automaton().shown_state
    for unit in ("s", unit_of_state(model, shown), unit_of_state(model, f"{shown}'"), "Hz"):
        assert re.search(rf"\((10\S+ )?{re.escape(unit.replace('^2', '²'))}\)", texts), unit
    page.locator(".fl-files > summary").click()
    for width, height in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        assert come_to(page, [], lambda: cut_off(page, ROOT)) == []
    page.keyboard.press("Escape")
    page.set_viewport_size({"width": 1280, "height": 800})
    fields = page.evaluate(ROUND_TRIP, ROOT)
    assert len(fields["before"]) > 1
    assert fields["after"] == fields["before"]
    for dark in (True, False):
        place.make_dark(dark)
        settled(page, ROOT)
        # The rest of JupyterLab's page is its own.
        assert faults(page, axe, ROOT if place.name == "notebook" else "html") == []


@everywhere
def test_a_key_on_a_slider_changes_pictures_and_equilibrium_and_is_undone(slider):
    before = settled(slider.page, ROOT)
    press(slider.page, ROOT, "F")
    after = changed(slider.page, ROOT, before, pictures=2)
    point = fl.equilibrium(fl.SliderOnBelt(F=205.0, mu_k=1.4))
    assert f"x1 = {point.q[0]:.5g} m" in after["words"].replace("\n", "")
    assert f"FN = {point.normal_force:.5g} N" in after["words"].replace("\n", "")
    for button, value in (("undo", "200"), ("redo", "205"), ("undo", "200")):
        slider.press_button(button)
        slider.reads("F", value)
        settled(slider.page, ROOT)
    assert settled(slider.page, ROOT)["words"] == before["words"]


@everywhere
@pytest.mark.parametrize("name", ["cubic", "nonsmooth", "geometry"])
def test_a_switch_changes_pictures_and_equilibrium(slider, name):
    before = settled(slider.page, ROOT)
    flip(slider.page, ROOT, name)
    after = changed(slider.page, ROOT, before, words=name != "nonsmooth")
    # Steady sliding neither sticks nor lifts off: without those it is the same.
    assert (after["words"] == before["words"]) == (name == "nonsmooth")
    assert ("φ" in after["words"]) == (name != "geometry")


@everywhere
def test_it_opens_with_a_scene_that_moves_and_says_what_it_does(slider):
    said = slider.page.locator(".fl-words").inner_text()
    assert "is stable, but from rest this run sticks, slips and separates at 10.7 Hz" in said
    labels = {"mu_k": "μk", "F": "FN", "v": "vm/s", "k2": "k2N/m", "k_nl": "knlN/m³"}
    for name, text in labels.items():
        label = slider.page.locator(f"{ROOT} .fl-control[data-name={name}] .fl-label")
        assert re.sub(r"\s", "", label.text_content()) == text
    range_, number = (
        slider.page.locator(f".fl-control[data-name=mu_k] {of}").bounding_box()
        for of in ("input[type=range]", ".fl-field")
    )
    assert range_["x"] + range_["width"] <= number["x"]
    assert number["y"] <= range_["y"] + range_["height"] / 2 <= number["y"] + number["height"]


@everywhere
def test_an_error_is_in_sight_and_undone(slider):
    slider.type_into("mu_k", -1)
    slider.page.wait_for_selector(".fl-status.fl-bad")
    assert slider.page.inner_text(".fl-status").startswith("mu_k must be at least 0, got -1.0")
    assert slider.page.inner_text("[data-name=mu_k] .fl-message").startswith("mu_k must be at least 0")
    number = slider.page.locator(".fl-control[data-name=mu_k] .fl-field")
    assert number.get_attribute("aria-invalid") == "true"
    slider.press_button("undo")
    slider.page.wait_for_selector(".fl-status:not(.fl-bad)")
    assert number.input_value() == "1.4"


@everywhere
def test_a_slider_stops_where_a_rule_does(slider):
    press(slider.page, ROOT, "mu_s", "Home")  # mu_s must be at least mu_k
    slider.says("[data-name=mu_s] .fl-message", "mu_s stays at 1.4: mu_s")
    slider.reads("mu_s", "1.4")
    slider.page.wait_for_selector(".fl-status:not(.fl-bad)")


@everywhere
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1,234", "a comma of two meanings"),
        ("abc", "must be one number"),
        ("1e400", "must be a finite number"),
    ],
)
def test_what_is_no_number_is_refused_beside_the_control(slider, text, words):
    number = slider.page.locator(".fl-control[data-name=mu_k] .fl-field")
    number.fill(text)
    number.press("Enter")
    slider.says("[data-name=mu_k] .fl-message", words)
    assert number.input_value() == "1.4"
    assert number.get_attribute("aria-invalid") == "true"
    number.fill("0,5")  # a decimal comma is one
    number.press("Enter")
    slider.reads("mu_k", "0.5")
    assert slider.page.locator("[data-name=mu_k] .fl-message").is_hidden()


@everywhere
def test_a_saved_state_is_loaded_again_and_code_is_copied(slider, tmp_path):
    press(slider.page, ROOT, "mu_k")
    slider.reads("mu_k", "1.41")
    settled(slider.page, ROOT)
    text = slider.file_of("save state", tmp_path / "state.json")
    assert json.loads(text)["changed"] == {"mu_k": 1.41}
    focus = "document.activeElement.textContent"
    assert slider.page.evaluate(focus) == "save"
    for key in ("Enter", "Tab", "Escape"):
        slider.page.keyboard.press(key)
    assert slider.page.evaluate(focus) == "save"
    slider.press_button("copy as Python")
    slider.says(".fl-status", "copied as Python")
    slider.press_button("reset")
    slider.reads("mu_k", "1.4")
    settled(slider.page, ROOT)
    slider.page.locator(".fl-files input").set_input_files(tmp_path / "state.json")
    slider.reads("mu_k", "1.41")


@everywhere
def test_full_screen_shows_all_panels_at_once(slider):
    page = slider.page
    page.set_viewport_size({"width": 1920, "height": 1080})
    slider.press_button("full screen")
    wait_until(page, "document.fullscreenElement?.matches('.fl-explorer')")
    settled(page, ROOT)
    assert come_to(page, [], lambda: cut_off(page, ROOT)) == []
    assert page.evaluate("parseFloat(getComputedStyle(document.querySelector('.fl-words')).fontSize)") >= 16
    boxes = [box for panel in page.locator(".fl-panel").all() if (box := panel.bounding_box())]
    assert all(box["y"] >= 0 and box["y"] + box["height"] <= 1080 + 40 for box in boxes)
    slider.press_button("full screen")
    wait_until(page, "!document.fullscreenElement")


@everywhere
def test_the_mechanism_moves_pauses_and_is_heard(slider):
    page = slider.page
    if page.locator("button.fl-play").inner_text() == "play":
        slider.press_button("play")
    first = page.inner_text(".fl-now")
    wait_until(page, "(text) => document.querySelector('.fl-now').innerText !== text", first)
    slider.press_button("pause")
    stopped = page.inner_text(".fl-now")
    page.wait_for_timeout(300)
    assert page.inner_text(".fl-now") == stopped
    page.locator(".fl-scrub").focus()
    page.keyboard.press("Home")
    slider.says(".fl-now", "t = 19.0000 s")
    slider.press_button("sound")
    slider.says(".fl-heard", "relative velocity, 20 times as high as it is")


@everywhere
def test_the_slider_is_taken_and_the_motion_starts_where_it_is_let_go(slider):
    slider.page.locator(".fl-panel-mechanism .fl-over").focus()
    for key in ("ArrowRight", "ArrowUp"):
        slider.page.keyboard.press(key)
    slider.says(".fl-now", "y1 = ")
    slider.page.keyboard.press("Enter")
    slider.says(".fl-words", "from your own state")
    assert slider.page.locator("[data-name=window] select").input_value() == "how it begins"


@everywhere
def test_two_scenes_at_once(slider, axe):
    page = slider.page
    slider.press_button("compare")
    slider.says(".fl-comparison", "move a control")
    press(page, ROOT, "mu_k", "PageUp")
    slider.says(".fl-comparison", "dotted, kept: mu_k = 1.4")
    now = page.locator(".fl-control[data-name=mu_k] .fl-field").input_value()
    slider.says(".fl-comparison", f"solid, now: mu_k = {now}")
    settled(page, ROOT)
    slider.press_button("swap")
    slider.reads("mu_k", "1.4")
    slider.says(".fl-comparison", f"dotted, kept: mu_k = {now}")
    assert come_to(page, [], lambda: cut_off(page, ROOT)) == []
    assert faults(page, axe, ROOT) == []
    slider.press_button("compare")
    assert page.inner_text(".fl-comparison") == ""
