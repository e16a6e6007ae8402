"""The explorer of all models in `frictionlab app` and in JupyterLab: menu, link, undo, files, full screen,
the moving mechanism, two scenes at once, dark pages; nothing is clipped, and nothing keeps anybody out."""

import json
import re
from importlib.util import find_spec
from types import SimpleNamespace

import pytest

from tests.browser.screen import PATIENCE, come_to, cut_off, faults, press, settled
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

pytestmark = [pytest.mark.browser, pytest.mark.slow]

ROOT = ".fl-explorer"
SIZES = {390: 844, 1280: 800, 1920: 1080}
READS = "([name, text]) => document.querySelector(`.fl-control.fl-${name} .fl-field`)?.value === text"
SAYS = "([of, text]) => document.querySelector(of)?.innerText.includes(text)"


def lab(folder, port):
    write_notebook(folder, SCENES)
    return in_lab(folder, port)


@pytest.fixture(scope="module", params=["app", "lab"])
def shown(request, browser, tmp_path_factory):
    """A page with the explorer, at rest, and what went wrong on it."""
    module = {"app": "voila", "lab": "jupyterlab"}[request.param]
    if find_spec(module) is None:
        pytest.skip(f"{module} shows the explorer; it is not installed")
    folder, port = tmp_path_factory.mktemp(request.param), free_port()
    with serving((app if request.param == "app" else lab)(folder, port), port, folder) as address:
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        context.grant_permissions(["clipboard-read", "clipboard-write"])
        page, failures = context.new_page(), []
        page.on("pageerror", lambda error: failures.append(str(error)))
        page.set_default_timeout(PATIENCE)
        path = printed_path(folder) if request.param == "app" else "/doc/tree/page.ipynb"
        page.goto(address + path, wait_until="commit")
        if request.param == "lab":
            run_all(page)
        page.wait_for_selector(f"{ROOT} .fl-words:not(:empty)", timeout=3 * PATIENCE)
        settled(page, ROOT)
        yield SimpleNamespace(page=page, name=request.param, failures=failures)
        assert failures == []
        context.close()


@pytest.fixture
def page(shown):
    """The page with the first scene as it opens."""
    found = shown.page
    found.set_viewport_size({"width": 1280, "height": 800})
    choose(found, "two fates")
    if found.locator("button.fl-reset").is_enabled():
        press_button(found, "reset")
    found.wait_for_function(READS, arg=["mu_k", "1.4"])
    settled(found, ROOT)
    return found


def press_button(page, name):
    page.get_by_role("button", name=name, exact=True).first.click()


def choose(page, scene):
    """A scene of the menu, from its name."""
    page.locator(".fl-scene select").select_option(label=scene)
    page.wait_for_function(
        "(name) => document.querySelector('.fl-scene option:checked').text === name", arg=scene
    )
    page.wait_for_selector(f"{ROOT} .fl-words:not(:empty)")
    settled(page, ROOT)


def open_all(page):
    """Open what is folded."""
    page.locator(f"{ROOT} details.fl-group").evaluate_all(
        "(all) => all.forEach((each) => { each.open = true })"
    )
    page.wait_for_timeout(300)


def test_the_menu_opens_scenes_and_models(page):
    choose(page, "stick-slip")
    page.wait_for_function(READS, arg=["mu_k", "0.5"])
    page.wait_for_function(SAYS, arg=[".fl-about", "Friction that falls with speed"])
    choose(page, "model: BouncingBall()")
    page.wait_for_function(READS, arg=["e", "0.5"])
    page.wait_for_function(SAYS, arg=[".fl-words", "From rest this run is over after 1.35 s"])


def test_undo_and_redo(page):
    press(page, ROOT, "mu_k")
    page.wait_for_function(READS, arg=["mu_k", "1.41"])
    settled(page, ROOT)
    for button, value in (("undo", "1.4"), ("redo", "1.41"), ("undo", "1.4")):
        press_button(page, button)
        page.wait_for_function(READS, arg=["mu_k", value])
        settled(page, ROOT)


def test_a_saved_state_is_loaded_again(page, tmp_path):
    press(page, ROOT, "mu_k")
    page.wait_for_function(READS, arg=["mu_k", "1.41"])
    settled(page, ROOT)
    page.locator(".fl-files > summary").click()
    with page.expect_download() as waiting:
        press_button(page, "save state")
    saved = tmp_path / "state.json"
    waiting.value.save_as(saved)
    assert json.loads(saved.read_text())["changed"] == {"mu_k": 1.41}
    choose(page, "stick-slip")
    page.locator(".fl-files > summary").click()
    with page.expect_file_chooser() as choosing:
        press_button(page, "load state or lesson")
    choosing.value.set_files(saved)
    page.wait_for_function(READS, arg=["mu_k", "1.41"])
    settled(page, ROOT)


def test_full_screen_fills_the_window_and_is_left(page):
    page.set_viewport_size({"width": 1920, "height": 1080})
    press_button(page, "full screen")
    page.wait_for_function("document.fullscreenElement?.matches('.fl-explorer')")
    settled(page, ROOT)
    assert come_to(page, [], lambda: cut_off(page, ROOT)) == []
    letters = page.evaluate("parseFloat(getComputedStyle(document.querySelector('.fl-words')).fontSize)")
    assert letters >= 16
    seen = page.evaluate(
        "[...document.querySelectorAll('.fl-panel')].map((e) => e.getBoundingClientRect()).map((b) =>"
        " b.top >= 0 && b.bottom <= innerHeight + 40)"
    )
    assert all(seen)  # all six panels at once
    press_button(page, "full screen")
    page.wait_for_function("!document.fullscreenElement")


def time_of(page):
    return float(re.search(r"t = (\S+) s", page.inner_text(".fl-now"))[1])


def test_the_mechanism_moves_pauses_and_is_heard(page):
    first = page.inner_text(".fl-now")
    page.wait_for_function("(text) => document.querySelector('.fl-now').innerText !== text", arg=first)
    press_button(page, "pause")
    stopped = time_of(page)
    page.wait_for_timeout(300)
    assert time_of(page) == stopped
    page.locator(".fl-scrub").focus()
    page.keyboard.press("Home")
    page.wait_for_function("document.querySelector('.fl-now').innerText.includes('t = 19.0000 s')")
    press_button(page, "sound")
    page.wait_for_function(SAYS, arg=[".fl-heard", "relative_velocity, 20 times as high as it is"])
    press_button(page, "play")


def test_the_slider_is_taken_and_the_motion_starts_where_it_is_let_go(page):
    over = page.locator(".fl-panel-mechanism .fl-over")
    over.focus()
    for key in ("ArrowRight", "ArrowUp"):
        page.keyboard.press(key)
    page.wait_for_function(SAYS, arg=[".fl-now", "y1 = "])
    page.keyboard.press("Enter")
    page.wait_for_function(SAYS, arg=[".fl-words", "from your own state"])
    assert page.locator(".fl-window select").input_value() == "how it begins"


def test_two_scenes_at_once(page):
    press_button(page, "compare")
    page.wait_for_function(SAYS, arg=[".fl-comparison", "move a control"])
    press(page, ROOT, "mu_k", "PageUp")
    page.wait_for_function(SAYS, arg=[".fl-comparison", "dotted, kept: mu_k = 1.4"])
    now = page.locator(".fl-control.fl-mu_k .fl-field").input_value()
    page.wait_for_function(SAYS, arg=[".fl-comparison", f"solid, now: mu_k = {now}"])
    settled(page, ROOT)
    press_button(page, "swap")
    page.wait_for_function(READS, arg=["mu_k", "1.4"])
    page.wait_for_function(SAYS, arg=[".fl-comparison", f"dotted, kept: mu_k = {now}"])
    assert come_to(page, [], lambda: cut_off(page, ROOT)) == []
    press_button(page, "compare")
    assert page.inner_text(".fl-comparison") == ""


@pytest.mark.parametrize("width", SIZES)
@pytest.mark.parametrize("scene", ["two fates", "chaos", "model: ModeCoupling()", "model: TwoBlocks()"])
def test_nothing_is_clipped(page, scene, width):
    choose(page, scene)
    page.set_viewport_size({"width": width, "height": SIZES[width]})
    settled(page, ROOT)
    open_all(page)
    assert come_to(page, [], lambda: cut_off(page, ROOT)) == []


def test_a_slider_and_its_number_are_in_one_row(page):
    slider, field = (
        page.locator(f".fl-control.fl-mu_k {of}").bounding_box() for of in ("input[type=range]", ".fl-field")
    )
    assert slider["x"] + slider["width"] <= field["x"]
    assert field["y"] <= slider["y"] + slider["height"] / 2 <= field["y"] + field["height"]


PAPER = "getComputedStyle(document.querySelector('.fl-explorer')).backgroundColor"


def test_on_a_dark_page_everything_is_dark_and_legible(shown, page, axe):
    make_dark(shown, True)
    try:
        assert come_to(page, "rgb(17, 17, 17)", lambda: page.evaluate(PAPER)) == "rgb(17, 17, 17)"
        assert faults(page, axe, ROOT) == []
    finally:
        make_dark(shown, False)


def make_dark(shown, dark):
    """The app has a button, JupyterLab its own setting."""
    if shown.name == "app":
        press_button(shown.page, "dark" if dark else "light")
        return
    shown.page.locator(".lm-MenuBar-item").get_by_text("Settings", exact=True).click()
    shown.page.locator(".lm-Menu-item").get_by_text("Theme", exact=True).click()
    name = "JupyterLab Dark" if dark else "JupyterLab Light"
    shown.page.locator(".lm-Menu-item").get_by_text(name, exact=True).click()
    shown.page.wait_for_function(
        "(light) => document.body.dataset.jpThemeLight === light", arg=str(not dark).lower()
    )


@pytest.mark.parametrize("scene", ["two fates", "model: BouncingBall()"])
def test_axe_finds_no_serious_fault(shown, page, axe, scene):
    choose(page, scene)
    open_all(page)
    press_button(page, "compare")
    settled(page, ROOT)
    # The rest of JupyterLab's page is its own.
    assert faults(page, axe, "html" if shown.name == "app" else ROOT) == []
    press_button(page, "compare")
