"""The explorer in a browser, in Voila, in JupyterLab and as `frictionlab app`: keys, clicks, pictures."""

import re
from importlib.util import find_spec
from itertools import combinations
from types import SimpleNamespace

import pytest

import frictionlab as fl
from frictionlab.widgets.panels.tile import AXES_RECTANGLE
from tests.browser.screen import PATIENCE, changed, come_to, flip, press, seen, settled
from tests.browser.servers import (
    CLICKED,
    app,
    free_port,
    in_lab,
    printed_path,
    run_all,
    running_kernels,
    serving,
    write_notebook,
)

pytestmark = pytest.mark.browser

SWITCHES = "cubic", "nonsmooth", "geometry"
LABELS = {"mu_k": "μ", "F": "F", "v": "v", "k2": "k", "k_nl": "k"}


def voila(folder, port):
    return ["voila", str(write_notebook(folder)), "--no-browser", f"--port={port}"]


def voila_clicked(folder, port):
    return ["voila", str(write_notebook(folder, CLICKED)), "--no-browser", f"--port={port}"]


def lab(folder, port):
    write_notebook(folder)
    return in_lab(folder, port)


def lab_clicked(folder, port):
    write_notebook(folder, CLICKED)
    return in_lab(folder, port)


FRONT_ENDS = {
    "voila": (voila, "voila", "/", ".live"),
    "lab": (lab, "jupyterlab", "/doc/tree/page.ipynb", ".live"),
    "app": (app, "voila", None, ".fl-explorer"),  # it prints its path
    "voila-clicked": (voila_clicked, "voila", "/", ".plane"),
    "lab-clicked": (lab_clicked, "jupyterlab", "/doc/tree/page.ipynb", ".plane"),
}
CLICKS = "voila-clicked", "lab-clicked"


def shown_in(*front_ends):
    """A test that is shown in these; in the app at once, in others with the slow tests."""
    each = [pytest.param(name, marks=() if name == "app" else pytest.mark.slow) for name in front_ends]
    return pytest.mark.parametrize("shown", each, indirect=True, scope="module")


EVERYWHERE, COMMAND = shown_in("voila", "lab", "app"), shown_in("app")
NOTEBOOKS, CLICKABLE = shown_in("voila", "lab"), shown_in(*CLICKS)


@pytest.fixture(scope="module")
def shown(request, browser, tmp_path_factory):
    """A page with an explorer: its page, front end and CSS selector, and what went wrong or abroad."""
    command, module, path, root = FRONT_ENDS[request.param]
    if find_spec(module) is None:
        pytest.skip(f"{module} shows the explorer; it is not installed")
    folder, port = tmp_path_factory.mktemp(request.param), free_port()
    with serving(command(folder, port), port, folder) as address:
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        failures = []
        page.on("pageerror", lambda error: failures.append(str(error)))
        # The tests need no network, and nothing that they see comes from there.
        page.route(lambda url: not url.startswith((address, "blob:", "data:")), lambda route: route.abort())
        page.set_default_timeout(PATIENCE)
        page.goto(
            address + (path or printed_path(folder)), wait_until="commit"
        )  # Voila sends the rest when the cells have run
        if module == "jupyterlab":
            run_all(page)
        page.wait_for_selector(f"{root} .fl-panel img", timeout=3 * PATIENCE)
        if request.param == "lab":  # what follows in the cell still runs
            page.wait_for_selector("canvas", timeout=3 * PATIENCE)
            page.get_by_text("| Idle").wait_for(timeout=PATIENCE)
        settled(page, root)
        yield SimpleNamespace(page=page, name=request.param, root=root, failures=failures)
        page.close()


@EVERYWHERE
def test_a_key_on_a_slider_changes_pictures_and_equilibrium(shown):
    before = settled(shown.page, shown.root)
    press(shown.page, shown.root, "F")
    after = changed(shown.page, shown.root, before, pictures=2)
    assert all(a != b for a, b in zip(before["pictures"][:2], after["pictures"][:2], strict=True))
    point = fl.equilibrium(fl.SliderOnBelt(F=205.0, mu_k=1.4))
    assert f"x1 = {point.q[0]:.5g} m" in after["words"]
    assert f"F_N = {point.normal_force:.5g} N" in after["words"]
    press(shown.page, shown.root, "F", "ArrowLeft")
    assert changed(shown.page, shown.root, after)["words"] == before["words"]


@EVERYWHERE
@pytest.mark.parametrize("name", SWITCHES)
def test_a_switch_changes_pictures_and_equilibrium(shown, name):
    before = settled(shown.page, shown.root)
    flip(shown.page, shown.root, name)
    after = changed(shown.page, shown.root, before, words=name != "nonsmooth")
    # Steady sliding neither sticks nor lifts off: without those it is the same.
    assert (after["words"] == before["words"]) == (name == "nonsmooth")
    assert ("phi =" in after["words"]) == (name != "geometry")
    flip(shown.page, shown.root, name)
    last = changed(shown.page, shown.root, after, words=name != "nonsmooth")
    assert last["words"] == before["words"]


@NOTEBOOKS
@pytest.mark.parametrize("name", ["F", *SWITCHES])
def test_without_its_observer_nothing_changes(shown, name):
    """The negative control: the tests above would fail here, as nothing but the observers redraws."""
    heard = shown.page.locator(".deaf-heard")
    times, before = int(heard.inner_text()), settled(shown.page, ".deaf")
    (press if name == "F" else flip)(shown.page, ".deaf", name)
    shown.page.wait_for_function(
        "(times) => Number(document.querySelector('.deaf-heard').innerText) > times",
        arg=times,
        timeout=PATIENCE,
    )
    assert settled(shown.page, ".deaf") == before


@EVERYWHERE
def test_labels_are_typeset_and_have_units(shown):
    for name, letter in LABELS.items():
        label = shown.page.locator(f"{shown.root} .fl-{name} .widget-label").first
        label.locator("mjx-container, .MathJax").first.wait_for(timeout=PATIENCE)
        assert "$" not in label.inner_text()
        assert letter in label.locator("mjx-assistive-mml").text_content()
    for name, unit in {"F": "(N)", "v": "(m/s)", "k2": "(N/m)", "k_nl": "(N/m³)"}.items():
        assert unit in shown.page.locator(f"{shown.root} .fl-{name} .widget-label").first.inner_text()


@COMMAND
def test_the_app_opens_with_a_scene_that_moves_and_has_a_menu_of_all_models(shown):
    menu = shown.page.locator(".fl-scene select")
    options = [text.replace("\xa0", " ") for text in menu.locator("option").all_inner_texts()]
    assert options[0] == "two fates"
    assert [f"model: {row.call}" for row in fl.list_models()] == options[-len(fl.list_models()) :]
    said = shown.page.locator(".fl-equilibrium").inner_text()
    assert "is stable, but from rest this run sticks, slips and separates at 10.7 Hz" in said


@COMMAND
def test_undo_and_redo_of_a_slider(shown):
    page, field = shown.page, shown.page.locator(".fl-mu_k .widget-readout")
    reads = "(v) => document.querySelector('.fl-mu_k .widget-readout').value === v"
    press(page, shown.root, "mu_k")
    page.wait_for_function(reads, arg="1.41")
    settled(page, shown.root)
    for button, value in (("undo", "1.4"), ("redo", "1.41"), ("undo", "1.4")):
        page.get_by_role("button", name=button, exact=True).click()
        page.wait_for_function(reads, arg=value)
        settled(page, shown.root)
    assert field.input_value() == "1.4"


@COMMAND
def test_a_state_is_downloaded(shown):
    page = shown.page
    page.locator(".fl-code").get_by_text("figure, data, state").click()
    for button, name in (("save state", "SliderOnBelt.json"), ("figure svg", "SliderOnBelt.svg")):
        with page.expect_download() as waiting:
            page.get_by_role("button", name=button, exact=True).click()
        assert waiting.value.suggested_filename == name
    page.locator(".fl-code").get_by_text("figure, data, state").click()


@COMMAND
def test_showing_the_sliders_changes_nothing(shown):
    """A browser tells the values of sliders as it shows them, with its rounding."""
    shown.page.locator(f"{shown.root} .fl-structure").get_by_text("structure").click()
    shown.page.locator(f"{shown.root} .fl-code").get_by_text("as Python").click()
    text = shown.page.locator(f"{shown.root} .fl-python textarea").input_value()
    assert (
        "model = fl.SliderOnBelt(mu_k=1.4)\nrun = fl.simulate(model, 20.0, x0='rest', method=fl.Taylor("
        in text
    )
    shown.page.locator(f"{shown.root} .fl-structure").get_by_text("structure").click()
    shown.page.locator(f"{shown.root} .fl-code").get_by_text("as Python").click()


@EVERYWHERE
@pytest.mark.parametrize(("width", "height"), [(1280, 720), (400, 800)], ids=["wide", "narrow"])
def test_nothing_overlaps_and_the_picture_stays_in_sight(shown, width, height):
    page = shown.page
    page.set_viewport_size({"width": width, "height": height})
    # JupyterLab scrolls a panel, not the page
    top = "e => { for (let p = e; p; p = p.parentElement) p.scrollTop = 0 }"
    page.locator(shown.root).first.evaluate(top)
    names = (*LABELS, "mu_s", *(f"switch-{name}" for name in SWITCHES), "compare", "equilibrium", "duration")

    def misplaced():
        boxes = {name: box_of(page, f"{shown.root} .fl-{name}") for name in (*names, "picture")}
        pairs = [(a, b) for a, b in combinations(boxes, 2) if overlap(boxes[a], boxes[b])]
        return pairs + [a for a, box in boxes.items() if box["x"] < 0 or box["x"] + box["width"] > width]

    assert come_to(page, [], misplaced) == []
    picture = box_of(page, f"{shown.root} .fl-picture")
    page.locator(f"{shown.root} .fl-coordinate").scroll_into_view_if_needed()

    def stays_in_sight():
        below = box_of(page, f"{shown.root} .fl-picture")
        visible = min(below["y"] + below["height"], height) - max(below["y"], 0)
        return visible > 0.75 * min(picture["height"], height)

    assert come_to(page, True, stays_in_sight)
    page.set_viewport_size({"width": 1280, "height": 720})


@pytest.mark.slow
def test_a_link_opens_its_scene_with_what_was_changed(browser, tmp_path):
    if find_spec("voila") is None:
        pytest.skip("voila shows the explorer; it is not installed")
    port = free_port()
    with serving(app(tmp_path, port), port, tmp_path) as address:
        page = browser.new_page()
        page.goto(address + printed_path(tmp_path) + "&scene=stick-slip&mu_k=0.55", wait_until="commit")
        page.wait_for_selector(".fl-explorer .fl-panel img", timeout=3 * PATIENCE)
        assert "token" not in page.url
        assert page.locator(".fl-scene select").input_value().replace("\xa0", " ") == "stick-slip"
        assert page.locator(".fl-mu_k .widget-readout").input_value() == "0.55"
        page.close()


@pytest.mark.slow
def test_a_page_has_one_kernel_as_long_as_it_is_open(browser, tmp_path):
    if find_spec("voila") is None:
        pytest.skip("voila shows the explorer; it is not installed")
    before, port = running_kernels(), free_port()
    with serving(app(tmp_path, port), port, tmp_path) as address:
        page = browser.new_page()  # nothing intercepts what it says as it closes
        page.goto(address + printed_path(tmp_path), wait_until="commit")
        assert page.url == address + "/"  # the token is not there to be read from the screen
        page.wait_for_selector(".fl-explorer .fl-panel img", timeout=3 * PATIENCE)
        page.reload(wait_until="commit")
        page.wait_for_selector(".fl-explorer .fl-panel img", timeout=3 * PATIENCE)
        wait_for_kernels(page, before + 1)
        page.goto("about:blank")
        wait_for_kernels(page, before)
        page.close()


def wait_for_kernels(page, number):
    for _ in range(PATIENCE // 200):
        if running_kernels() == number:
            return
        page.wait_for_timeout(200)
    assert running_kernels() == number


def box_of(page, selector):
    return page.locator(selector).first.bounding_box()


def overlap(a, b):
    across = min(a["x"] + a["width"], b["x"] + b["width"]) - max(a["x"], b["x"])
    return across > 1 and min(a["y"] + a["height"], b["y"] + b["height"]) - max(a["y"], b["y"]) > 1


@CLICKABLE
def test_a_click_into_the_plane_moves_the_point_there(shown):
    words = shown.page.locator(".plane .fl-equilibrium")
    assert "is stable" in words.inner_text()
    click(shown.page, ".plane .fl-panel-critical img", 0.5, 0.25)
    shown.page.wait_for_function(
        "document.querySelector('.plane .fl-equilibrium').innerText.includes('unstable')", timeout=PATIENCE
    )
    force = float(shown.page.locator(".plane .fl-F .widget-readout").input_value())
    low, high = fl.explore_stability().picture.tiles["critical"].ax.get_xlim()
    across = (0.5 - AXES_RECTANGLE[0]) / AXES_RECTANGLE[2]
    assert force == pytest.approx(low + across * (high - low), abs=0.01 * (high - low))


@CLICKABLE
def test_a_click_into_the_diagram_selects_the_value_there(shown):
    page = shown.page
    page.wait_for_selector(".diagram .fl-panel img", timeout=PATIENCE)
    settled(page, ".diagram")
    readout = page.locator(".diagram .fl-mu_k .widget-readout")
    low, high = map(float, page.locator(".diagram .fl-range .widget-readout").inner_text().split("–"))
    across, before = 0.75, readout.input_value()
    click(page, ".diagram .fl-panel-bifurcation img", AXES_RECTANGLE[0] + across * AXES_RECTANGLE[2], 0.5)
    page.wait_for_function(
        "(before) => document.querySelector('.diagram .fl-mu_k .widget-readout').value !== before",
        arg=before,
        timeout=PATIENCE,
    )
    expected = low + across * (high - low)
    assert float(readout.input_value()) == pytest.approx(expected, abs=0.01 * (high - low))


PICTURE = "document.querySelector('.diagram .fl-panel-response img').src"
FILLING = "document.querySelector('.diagram .fl-busy').innerText.includes('of 300')"


@CLICKABLE
def test_sliders_answer_while_a_diagram_fills(shown):
    page = shown.page
    settled(page, ".diagram")
    press(page, ".diagram", "F")  # another diagram
    page.wait_for_function(FILLING, timeout=PATIENCE)
    before = page.evaluate(PICTURE)
    press(page, ".diagram", "mu_k")
    page.wait_for_function(f"(before) => {PICTURE} !== before", arg=before, timeout=PATIENCE)
    assert page.evaluate(FILLING)


def click(page, selector, x, y):
    """Click at shares of a picture's width from the left and of its height from above."""
    picture = page.locator(selector)
    picture.scroll_into_view_if_needed(timeout=PATIENCE)
    box = picture.bounding_box()
    picture.click(position={"x": x * box["width"], "y": y * box["height"]})


@NOTEBOOKS
def test_the_animation_plays(shown):
    page = shown.page
    play = page.get_by_role("button", name="play", exact=True)
    play.scroll_into_view_if_needed(timeout=PATIENCE)
    shot = "() => [...document.querySelectorAll('canvas')].slice(-2).map((c) => c.toDataURL())"
    time = page.get_by_text(re.compile(r"^t = \S+ s: "))
    before, start = page.evaluate(shot), time.inner_text()
    play.click()
    page.wait_for_function(
        f"(before) => ({shot})().every((url, i) => url !== before[i])", arg=before, timeout=PATIENCE
    )
    page.get_by_role("button", name="pause", exact=True).click()
    assert time.inner_text() != start


@EVERYWHERE
def test_nothing_went_wrong_on_the_page(shown):
    assert shown.failures == []
    assert shown.page.get_by_text("Error displaying widget").count() == 0
    assert seen(shown.page, shown.root)["pictures"]
