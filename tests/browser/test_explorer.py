"""The explorer in a browser, in Voila, in JupyterLab and as `frictionlab app`: keys, clicks, pictures."""

import json
import re
from importlib.util import find_spec
from itertools import combinations
from types import SimpleNamespace
from urllib.parse import quote

import pytest

import frictionlab as fl
from frictionlab.pages.gallery import library_scenes
from frictionlab.widgets.result import default_settings, limit_steps
from tests.browser.screen import PATIENCE, changed, come_to, cut_off, flip, press, seen, settled
from tests.browser.servers import (
    CLICKED,
    MODELS_IN_LAB,
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
LABELS = {"mu_k": "μk", "mu_s": "μs", "F": "FN", "v": "vm/s", "k2": "k2N/m", "k_nl": "knlN/m³"}


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
    "app": (app, "voila", None, "body"),  # it prints its path
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
        page.wait_for_selector(f"{root} .fl-words:not(:empty)", timeout=3 * PATIENCE)
        if module == "jupyterlab":  # what follows in the cell still runs
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
    assert f"x1 = {point.q[0]:.5g} m" in after["words"].replace("\n", "")
    assert f"FN = {point.normal_force:.5g} N" in after["words"].replace("\n", "")
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
    assert ("φ" in after["words"]) == (name != "geometry")
    flip(shown.page, shown.root, name)
    last = changed(shown.page, shown.root, after, words=name != "nonsmooth")
    assert last["words"] == before["words"]


@EVERYWHERE
def test_labels_have_indices_and_units(shown):
    for name, text in LABELS.items():
        label = shown.page.locator(f"{shown.root} .fl-control.fl-{name} .fl-label")
        assert re.sub(r"\s", "", label.inner_text()) == text


@NOTEBOOKS
def test_showing_the_controls_changes_nothing(shown):
    before = settled(shown.page, shown.root)
    heard = int(shown.page.locator(".live-heard").inner_text())
    press(shown.page, shown.root, "F")
    changed(shown.page, shown.root, before)
    shown.page.wait_for_function(
        "(n) => Number(document.querySelector('.live-heard').innerText) > n", arg=heard, timeout=PATIENCE
    )
    press(shown.page, shown.root, "F", "ArrowLeft")
    settled(shown.page, shown.root)


@COMMAND
def test_the_app_opens_with_a_scene_that_moves_and_has_a_menu_of_all_models(shown):
    options = shown.page.locator(".fl-scene option").all_inner_texts()
    assert options[0] == "two fates"
    assert [f"model: {row.call}" for row in fl.list_models()] == options[-len(fl.list_models()) :]
    said = shown.page.locator(".fl-words").inner_text()
    assert "is stable, but from rest this run sticks, slips and separates at 10.7 Hz" in said
    assert shown.page.locator("button.fl-play").inner_text() == "pause"


@COMMAND
def test_undo_and_redo_of_a_slider(shown):
    page, reads = shown.page, "(v) => document.querySelector('.fl-mu_k .fl-field').value === v"
    press(page, shown.root, "mu_k")
    settled(page, shown.root)
    for button, value in (("undo", "1.4"), ("redo", "1.41"), ("undo", "1.4")):
        page.get_by_role("button", name=button, exact=True).click()
        page.wait_for_function(reads, arg=value)
        settled(page, shown.root)


@COMMAND
def test_an_error_is_in_sight_and_undone(shown):
    page, field = shown.page, shown.page.locator(".fl-control.fl-mu_k .fl-field")
    field.fill("-1")
    field.press("Enter")
    page.wait_for_selector(".fl-status.fl-bad")
    assert page.inner_text(".fl-status").startswith("mu_k must be at least 0, got -1.0")
    assert page.inner_text(".fl-mu_k .fl-message").startswith("mu_k must be at least 0")  # beside it too
    assert field.get_attribute("aria-invalid") == "true"
    page.get_by_role("button", name="undo", exact=True).click()
    page.wait_for_selector(".fl-status:not(.fl-bad)")
    assert field.input_value() == "1.4"


@COMMAND
def test_a_slider_stops_where_a_rule_does(shown):
    page = shown.page
    press(page, shown.root, "mu_s", "Home")  # mu_s must be at least mu_k
    page.wait_for_function(
        "document.querySelector('.fl-mu_s .fl-message').innerText.startsWith('mu_s stays at 1.4: mu_s')"
    )
    assert page.locator(".fl-control.fl-mu_s .fl-field").input_value() == "1.4"
    page.wait_for_selector(".fl-status:not(.fl-bad)")
    page.get_by_role("button", name="undo", exact=True).click()
    settled(page, shown.root)


@COMMAND
def test_files_are_downloaded(shown):
    page = shown.page
    page.locator(".fl-files > summary").click()
    for button, name in (("figure svg", "svg"), ("data csv", "csv"), ("save state", "json")):
        with page.expect_download() as waiting:
            page.get_by_role("button", name=button, exact=True).click()
        assert waiting.value.suggested_filename == f"SliderOnBelt.{name}"
    page.locator(".fl-files > summary").click()


@COMMAND
def test_the_code_is_that_of_the_model(shown):
    shown.page.get_by_role("button", name="copy as Python", exact=True).click()
    shown.page.get_by_text("copied as Python").wait_for()


@EVERYWHERE
@pytest.mark.parametrize(("width", "height"), [(1280, 720), (400, 800)], ids=["wide", "narrow"])
def test_nothing_overlaps(shown, width, height):
    page = shown.page
    page.set_viewport_size({"width": width, "height": height})
    names = (*LABELS, *(f"switch-{name}" for name in SWITCHES), "duration")

    def misplaced():
        parts = [*(f"fl-control.fl-{name}" for name in names), "fl-words", "fl-numbers", "fl-panel-phase"]
        boxes = {part: box_of(page, f"{shown.root} .{part}") for part in parts}
        pairs = [(a, b) for a, b in combinations(boxes, 2) if overlap(boxes[a], boxes[b])]
        return pairs + [a for a, box in boxes.items() if box["x"] < 0 or box["x"] + box["width"] > width]

    assert come_to(page, [], misplaced) == []
    page.set_viewport_size({"width": 1280, "height": 720})


@pytest.mark.slow
def test_a_link_opens_its_scene_with_what_was_changed(browser, tmp_path):
    if find_spec("voila") is None:
        pytest.skip("voila shows the explorer; it is not installed")
    port = free_port()
    with serving(app(tmp_path, port), port, tmp_path) as address:
        page = browser.new_page()
        lesson = quote(json.dumps([{"text": "See it stick.", "control": "mu_k", "changed": {"mu_k": 0.55}}]))
        link = f"#scene=stick-slip&mu_k=0.6&lesson={lesson}"
        page.goto(address + printed_path(tmp_path) + link, wait_until="commit")
        page.wait_for_selector(".fl-words:not(:empty)", timeout=3 * PATIENCE)
        page.wait_for_function("document.querySelector('.fl-mu_k .fl-field')?.value === '0.55'")
        assert "token" not in page.url
        assert page.locator(".fl-scene select").input_value() == "stick-slip"
        assert page.inner_text(".fl-step") == "See it stick."
        page.get_by_role("button", name="end the lesson").click()
        page.wait_for_function("location.hash === '#scene=stick-slip&mu_k=0.55'")
        page.close()


IN_LAB = "MassOnBelt()", "SliderOnRigidBelt()", "BouncingBall()"
ALL_SCENES = {each.name: each for each in library_scenes()}


@pytest.mark.parametrize(
    "names", [IN_LAB, pytest.param(tuple(ALL_SCENES), marks=pytest.mark.slow)], ids=["three", "all"]
)
def test_models_in_jupyterlab_show_the_motion_of_simulate(browser, tmp_path, names):
    if find_spec("jupyterlab") is None:
        pytest.skip("jupyterlab shows the explorers; it is not installed")
    scenes = f"[(s.name, s.model) for s in library_scenes() if s.name in {names!r}]"
    source = "from frictionlab.pages.gallery import library_scenes\n" + MODELS_IN_LAB.format(models=scenes)
    write_notebook(tmp_path, source)
    port, failures = free_port(), []
    with serving(in_lab(tmp_path, port), port, tmp_path) as address:
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.on("pageerror", lambda error: failures.append(str(error)))
        page.route(lambda url: not url.startswith((address, "blob:", "data:")), lambda route: route.abort())
        page.goto(address + "/doc/tree/page.ipynb", wait_until="commit")
        run_all(page)
        shown = (name for name in ALL_SCENES if name in names)
        for i, name in enumerate(shown):
            page.wait_for_selector(f".model-{i} .fl-words:not(:empty)", timeout=3 * PATIENCE)
            settings = default_settings(ALL_SCENES[name].model)
            method = limit_steps(settings.method)
            run = fl.simulate(settings.model, settings.t_end, method=method, progress=False)
            assert page.inner_text(f".final-{i}") == repr(run.final_state.tolist())
            assert cut_off(page, f".model-{i}") == []
        assert failures == []
        page.close()


@pytest.mark.slow
def test_pages_of_models_need_no_kernel(browser, tmp_path):
    if find_spec("voila") is None:
        pytest.skip("voila serves the pages; it is not installed")
    before, port = running_kernels(), free_port()
    with serving(app(tmp_path, port), port, tmp_path) as address:
        page = browser.new_context().new_page()
        assert page.request.get(f"{address}/models/DenHartog.html").status == 403
        page.goto(address + printed_path(tmp_path).replace("/?", "/models/?"))
        assert page.url == f"{address}/models/"
        page.get_by_role("link", name="DenHartog()").click()
        page.wait_for_selector(".fl-words:not(:empty)", timeout=PATIENCE)
        page.locator(".fl-scene select").select_option("FreeCoulomb()")
        page.wait_for_url("**/FreeCoulomb.html#*")
        page.wait_for_selector(".fl-words:not(:empty)", timeout=PATIENCE)
        assert page.request.get(f"{address}/models/nothing.html").status == 404
        assert running_kernels() == before
        page.context.close()


@pytest.mark.slow
def test_a_page_has_one_kernel_as_long_as_it_is_open(browser, tmp_path):
    if find_spec("voila") is None:
        pytest.skip("voila shows the explorer; it is not installed")
    before, port = running_kernels(), free_port()
    with serving(app(tmp_path, port), port, tmp_path) as address:
        page = browser.new_page()  # nothing intercepts what it says as it closes
        page.goto(address + printed_path(tmp_path), wait_until="commit")
        assert page.url.split("#")[0] == address + "/"  # the token is not there to be read from the screen
        page.wait_for_selector(".fl-words:not(:empty)", timeout=3 * PATIENCE)
        page.reload(wait_until="commit")
        page.wait_for_selector(".fl-words:not(:empty)", timeout=3 * PATIENCE)
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
    words = shown.page.locator(".plane .fl-words")
    assert "is stable" in words.inner_text()
    click(shown.page, ".plane .fl-panel-critical .fl-over", 0.5, 0.25)
    shown.page.wait_for_function(
        "document.querySelector('.plane .fl-words').innerText.includes('unstable')", timeout=PATIENCE
    )
    force = float(shown.page.locator(".plane .fl-F .fl-field").input_value())
    assert force % 5.0 == 0.0  # a round number
    assert 300.0 < force < 700.0


FIELD = "document.querySelector('.diagram .fl-mu_k .fl-field').value"


@CLICKABLE
def test_a_click_into_the_diagram_selects_the_value_there(shown):
    page = shown.page
    page.wait_for_selector(".diagram .fl-panel-bifurcation", timeout=PATIENCE)
    before = page.evaluate(FIELD)
    click(page, ".diagram .fl-panel-bifurcation .fl-over", 0.8, 0.5)
    page.wait_for_function(f"(before) => {FIELD} !== before", arg=before, timeout=PATIENCE)
    assert 2.0 < float(page.evaluate(FIELD)) < 2.9


PICTURE = "document.querySelector('.diagram .fl-panel-response .fl-canvas').toDataURL()"
FILLING = "document.querySelector('.diagram .fl-busy progress').max === 300"


@CLICKABLE
def test_sliders_answer_while_a_diagram_fills(shown):
    page = shown.page
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
def test_a_run_that_is_watched_plays(shown):
    page = shown.page
    play = page.locator(".watched button.fl-play")
    play.scroll_into_view_if_needed(timeout=PATIENCE)
    start = page.locator(".watched .fl-now").inner_text()
    play.click()
    page.wait_for_function(
        "(start) => document.querySelector('.watched .fl-now').innerText !== start", arg=start
    )
    play.click()
    assert play.inner_text() == "play"


@EVERYWHERE
def test_nothing_went_wrong_on_the_page(shown):
    assert shown.failures == []
    assert shown.page.get_by_text("Error displaying widget").count() == 0
    assert seen(shown.page, shown.root)["pictures"]
