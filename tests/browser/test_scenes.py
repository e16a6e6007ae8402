"""The explorer of all models in `frictionlab app` and in JupyterLab: menu, link, undo, files, full screen,
the moving mechanism, two scenes at once, dark pages; nothing is clipped, and nothing keeps anybody out."""

import re
from importlib.util import find_spec
from io import BytesIO
from types import SimpleNamespace

import pytest
from matplotlib.colors import to_rgb
from PIL import Image

import frictionlab as fl
from frictionlab.plotting.appearance import DARK, contrast
from frictionlab.widgets.panels.picture import PANEL_WIDTH
from frictionlab.widgets.panels.tile import FONT_SIZE
from frictionlab.widgets.scenes import Scenes
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
READS = "([name, text]) => document.querySelector(`.fl-${name} .widget-readout`)?.value === text"
SAYS = "([of, text]) => document.querySelector(of)?.innerText.replaceAll('\\u00a0', ' ').includes(text)"


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
        page.wait_for_selector(f"{ROOT} .fl-panel img", timeout=3 * PATIENCE)
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
    press_button(found, "reset")
    found.wait_for_function(READS, arg=["mu_k", "1.4"])
    settled(found, ROOT)
    return found


def press_button(page, name):
    page.get_by_role("button", name=name, exact=True).first.click()


def choose(page, scene):
    """A scene of the menu, from its name."""
    label = next(
        o for o in page.locator(".fl-scene option").all_inner_texts() if o.replace("\xa0", " ") == scene
    )
    page.locator(".fl-scene select").select_option(label=label)
    page.wait_for_selector(f"{ROOT} .fl-panel img")
    settled(page, ROOT)


def open_all(page):
    """Open what is folded."""
    closed = f"{ROOT} .jupyter-widget-Collapse:not(.jupyter-widget-Collapse-open)"
    headers = page.locator(f"{closed} > .jupyter-widget-Collapse-header")
    headers.evaluate_all("(all) => all.forEach((header) => header.click())")
    page.wait_for_timeout(300)


def test_the_menu_opens_scenes_and_models(page):
    choose(page, "stick-slip")
    page.wait_for_function(READS, arg=["mu_k", "0.5"])
    page.wait_for_function(SAYS, arg=[".fl-about", "Friction that falls with speed"])
    choose(page, "model: BouncingBall()")
    page.wait_for_function(READS, arg=["e", "0.5"])
    page.wait_for_function(SAYS, arg=[".fl-equilibrium", "From rest this run is over after 1.35 s"])


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
    page.locator(".fl-code").get_by_text("figure, data, state").click()
    with page.expect_download() as waiting:
        press_button(page, "save state")
    saved = tmp_path / "state.json"
    waiting.value.save_as(saved)
    press_button(page, "reset")
    page.wait_for_function(READS, arg=["mu_k", "1.4"])
    settled(page, ROOT)
    with page.expect_file_chooser() as choosing:
        page.locator(".fl-code .widget-upload").click()
    choosing.value.set_files(saved)
    page.wait_for_function(READS, arg=["mu_k", "1.41"])
    settled(page, ROOT)


def test_a_copied_link_opens_the_same_scene(shown, page):
    press(page, ROOT, "mu_k")
    page.wait_for_function(READS, arg=["mu_k", "1.41"])
    settled(page, ROOT)
    press_button(page, "copy link")
    page.get_by_text("copied", exact=True).first.wait_for()
    link = page.evaluate("navigator.clipboard.readText()")
    assert link.startswith(page.url.split("?")[0] if shown.name == "app" else "?scene=")
    again = Scenes(link, panels=("eigenvalues",))
    assert (again.menu.value, again.explorer.model) == ("two fates", fl.SliderOnBelt(mu_k=1.41))


def test_full_screen_fills_the_window_and_is_left(page):
    page.set_viewport_size({"width": 1920, "height": 1080})
    press_button(page, "full screen")
    page.wait_for_function("document.fullscreenElement?.matches('.fl-scenes')")
    settled(page, ROOT)
    assert page.evaluate("innerWidth") == page.evaluate("document.fullscreenElement.clientWidth")
    assert come_to(page, [], lambda: cut_off(page, ".fl-scenes")) == []
    letters = page.evaluate(
        "parseFloat(getComputedStyle(document.querySelector('.fl-equilibrium b')).fontSize)"
    )
    assert letters >= 18
    width = "document.querySelector('.fl-panel img').getBoundingClientRect().width"
    page.wait_for_function(f"{width} >= {20 * 72 / FONT_SIZE * PANEL_WIDTH}")  # letters of 20 pixels
    press_button(page, "leave full screen")
    page.wait_for_function("!document.fullscreenElement")
    page.get_by_role("button", name="full screen", exact=True).wait_for()


def time_of(page, at=0):
    text = page.locator(".fl-canvas").nth(at).get_by_text(re.compile("t = ")).inner_text()
    return float(re.search(r"t = (\S+) s", text)[1])


def test_the_mechanism_moves_pauses_and_is_heard(page):
    first = time_of(page)
    page.wait_for_function(
        "(t) => !document.querySelector('.fl-canvas').innerText.includes(`t = ${t.toFixed(3)} s`)", arg=first
    )
    press_button(page, "pause")
    stopped = time_of(page)
    page.wait_for_timeout(300)
    assert time_of(page) == stopped
    page.locator(".fl-canvas input[type=range]").first.focus()
    page.keyboard.press("Home")
    page.wait_for_function("document.querySelector('.fl-canvas').innerText.includes('t = 19.000 s')")
    press_button(page, "sound")
    page.wait_for_function(
        SAYS, arg=[".fl-canvas [role=status]", "relative_velocity, 20 times as high as it is"]
    )
    press_button(page, "play")


def test_the_mechanism_is_that_of_the_values_now(page):
    assert "up to 293 N" in page.locator(".fl-canvas").inner_text()
    press(page, ROOT, "mu_k", "PageUp")
    page.wait_for_function("!document.querySelector('.fl-canvas').innerText.includes('up to 293 N')")


def test_two_scenes_at_once(page):
    press_button(page, "compare")
    page.wait_for_function(SAYS, arg=[".fl-comparison", "move a control"])
    press(page, ROOT, "mu_k", "PageUp")
    page.wait_for_function(SAYS, arg=[".fl-comparison", "dotted, kept: mu_k = 1.4"])
    now = page.locator(".fl-mu_k .widget-readout").input_value()
    page.wait_for_function(SAYS, arg=[".fl-comparison", f"solid, now: mu_k = {now}"])
    assert page.locator(".fl-canvas").count() == 2
    assert "kept: t = " in page.locator(".fl-canvas").nth(1).inner_text()
    assert page.locator(".fl-canvas input[type=range]").count() == 1
    press_button(page, "pause")
    for key, time in (("Home", 19.0), ("ArrowRight", 19.001)):
        page.locator(".fl-canvas input[type=range]").focus()
        page.keyboard.press(key)
        assert come_to(page, [time, time], lambda: [time_of(page), time_of(page, 1)]) == [time, time]
    press_button(page, "play")
    press_button(page, "swap")
    page.wait_for_function(READS, arg=["mu_k", "1.4"])
    page.wait_for_function(SAYS, arg=[".fl-comparison", f"dotted, kept: mu_k = {now}"])
    assert come_to(page, [], lambda: cut_off(page, ".fl-scenes")) == []
    press_button(page, "compare")
    page.wait_for_function("document.querySelectorAll('.fl-canvas').length === 1")


@pytest.mark.parametrize("width", SIZES)
@pytest.mark.parametrize("scene", ["two fates", "chaos", "model: ModeCoupling()", "model: TwoBlocks()"])
def test_nothing_is_clipped(page, scene, width):
    choose(page, scene)
    page.set_viewport_size({"width": width, "height": SIZES[width]})
    settled(page, ROOT)
    open_all(page)
    assert come_to(page, [], lambda: cut_off(page, ".fl-scenes")) == []


def test_a_slider_and_its_number_are_in_one_row(page):
    slider, field = (
        page.locator(f".fl-mu_k {of}").bounding_box() for of in ("[role=slider]", ".widget-readout")
    )
    assert slider["x"] + slider["width"] <= field["x"]
    assert field["y"] <= slider["y"] + slider["height"] / 2 <= field["y"] + field["height"]


def corner(page, panel):
    """The colour of a panel's paper, as the browser shows it."""
    found = page.locator(f".fl-panel-{panel} img").evaluate(
        "async (image) => [...new Uint8Array(await (await fetch(image.src)).arrayBuffer())]"
    )
    return Image.open(BytesIO(bytes(found))).convert("RGB").getpixel((1, 1))


def test_on_a_dark_page_everything_is_dark_and_legible(shown, page, axe):
    make_dark(shown, True)
    try:
        dark = tuple(round(255 * part) for part in to_rgb(DARK))
        for _ in range(100):
            if corner(page, "response") == dark:
                break
            page.wait_for_timeout(100)
        settled(page, ROOT)
        assert corner(page, "response") == dark
        paper = page.evaluate("getComputedStyle(document.querySelector('.fl-canvas')).backgroundColor")
        assert paper == f"rgb{dark}"
        edge, behind = page.evaluate(
            "[getComputedStyle(document.querySelector('.fl-mu_k .widget-readout')).borderColor,"
            " getComputedStyle(document.querySelector('.fl-picture')).backgroundColor]"
        )
        assert contrast(colour(edge), colour(behind)) >= 3
        assert faults(page, axe, ".fl-scenes") == []
    finally:
        make_dark(shown, False)


def colour(text):
    return tuple(float(part) / 255 for part in re.findall(r"[\d.]+", text)[:3])


def make_dark(shown, dark):
    """The app follows the system, JupyterLab its own setting."""
    if shown.name == "app":
        shown.page.emulate_media(color_scheme="dark" if dark else "light")
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
    assert faults(page, axe, "html" if shown.name == "app" else ".fl-scenes") == []
    press_button(page, "compare")
