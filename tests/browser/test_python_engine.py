"""What explorers have only where Python answers: widgets beside them, clicks into planes and diagrams, runs
that are watched, links into the app and its kernels.  All else is in test_explorer.py.
"""

import json
from importlib.util import find_spec
from urllib.parse import quote

import pytest

from tests.browser.screen import PATIENCE, changed, press, settled
from tests.browser.servers import (
    app,
    free_port,
    in_lab,
    printed_path,
    run_all,
    running_kernels,
    serving,
    write_notebook,
)

LIVE = ".live"

pytestmark = [pytest.mark.browser, pytest.mark.slow]
needs_voila = pytest.mark.skipif(
    find_spec("voila") is None, reason="voila, which shows the app, is not installed"
)


@pytest.fixture(scope="module", params=["voila", "jupyterlab"])
def page(request, browser, tmp_path_factory):
    """A notebook's page with the explorers, at rest, and at its end that nothing went wrong there."""
    if find_spec(request.param) is None:
        pytest.skip(f"{request.param} shows the explorer; it is not installed")
    folder, port, failures = tmp_path_factory.mktemp(request.param), free_port(), []
    notebook, in_voila = write_notebook(folder), request.param == "voila"
    command = ["voila", str(notebook), "--no-browser", f"--port={port}"] if in_voila else in_lab(folder, port)
    with serving(command, port, folder) as address:
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.on("pageerror", lambda error: failures.append(str(error)))
        page.set_default_timeout(PATIENCE)
        # Voila sends the rest when the cells have run.
        page.goto(address + ("/" if in_voila else "/doc/tree/page.ipynb"), wait_until="commit")
        if not in_voila:
            run_all(page)
        page.wait_for_selector(".diagram .fl-words:not(:empty)", timeout=3 * PATIENCE)
        settled(page, LIVE)
        yield page
        assert failures == []
        assert page.get_by_text("Error displaying widget").count() == 0
        page.close()


def test_showing_the_controls_changes_nothing(page):
    before = settled(page, LIVE)
    heard = int(page.locator(".live-heard").inner_text())
    press(page, LIVE, "F")
    changed(page, LIVE, before)
    page.wait_for_function(
        "(n) => Number(document.querySelector('.live-heard').innerText) > n", arg=heard, timeout=PATIENCE
    )
    press(page, LIVE, "F", "ArrowLeft")
    settled(page, LIVE)


def test_a_long_run_is_stopped_in_jupyterlab_and_plain_voila_says_that_it_cannot(page):
    in_lab = "/doc/tree" in page.url
    before, status = settled(page, LIVE), page.locator(f"{LIVE} .fl-status")
    page.locator(f"{LIVE} [data-name=method] select").select_option("paper's (RK4)")
    changed(page, LIVE, before, words=False)
    page.fill(f"{LIVE} [data-name=duration] .fl-field", "3000" if in_lab else "300")
    page.keyboard.press("Enter")
    page.locator(LIVE).get_by_role("button", name="stop").click()
    said = "The computation was stopped" if in_lab else "This server does not let a computation be stopped"
    status.get_by_text(said).wait_for(timeout=PATIENCE)
    for _ in range(2):  # duration, method: it goes on to answer
        page.locator(LIVE).get_by_role("button", name="undo").click()
        page.wait_for_selector(f"{LIVE} .fl-status:not(.fl-bad)", timeout=PATIENCE)
        settled(page, LIVE)
    assert page.locator(f"{LIVE} [data-name=method] select").input_value().startswith("quick")


@needs_voila
def test_a_link_opens_its_scene_with_what_was_changed(browser, tmp_path):
    port = free_port()
    with serving(app(tmp_path, port), port, tmp_path) as address:
        page = browser.new_page()
        lesson = quote(json.dumps([{"text": "See it stick.", "control": "mu_k", "changed": {"mu_k": 0.55}}]))
        link = f"#scene=stick-slip&mu_k=0.6&lesson={lesson}"
        page.goto(address + printed_path(tmp_path) + link, wait_until="commit")
        page.wait_for_selector(".fl-words:not(:empty)", timeout=3 * PATIENCE)
        page.wait_for_function("document.querySelector('[data-name=mu_k] .fl-field')?.value === '0.55'")
        assert "token" not in page.url
        assert page.locator(".fl-scene select").input_value() == "stick-slip"
        assert page.inner_text(".fl-step") == "See it stick."
        page.get_by_role("button", name="end the lesson").click()
        page.wait_for_function("location.hash === '#scene=stick-slip&mu_k=0.55'")
        page.close()


@needs_voila
def test_a_long_run_is_stopped(browser, tmp_path):
    port = free_port()
    with serving(app(tmp_path, port), port, tmp_path) as address:
        page = browser.new_page()
        page.goto(address + printed_path(tmp_path) + "#method=paper%27s+(RK4)", wait_until="commit")
        page.wait_for_selector(".fl-words:not(:empty)", timeout=3 * PATIENCE)
        page.wait_for_function("document.querySelector('[data-name=method] select')?.value[0] === 'p'")
        settled(page, ".fl-explorer")
        page.fill(".fl-control[data-name=duration] .fl-field", "3000")
        page.keyboard.press("Enter")
        page.get_by_role("button", name="stop").click()
        page.locator(".fl-status").get_by_text("The computation was stopped").wait_for(timeout=PATIENCE)
        page.get_by_role("button", name="undo").click()  # it goes on to answer
        page.wait_for_selector(".fl-status:not(.fl-bad)", timeout=PATIENCE)
        page.close()


@needs_voila
def test_pages_of_models_need_no_kernel(browser, tmp_path):
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


@needs_voila
def test_a_page_has_one_kernel_as_long_as_it_is_open(browser, tmp_path):
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


def test_a_click_into_the_plane_moves_the_point_there(page):
    words = page.locator(".plane .fl-words")
    assert "is stable" in words.inner_text()
    click(page, ".plane .fl-panel-critical .fl-over", 0.5, 0.25)
    page.wait_for_function(
        "document.querySelector('.plane .fl-words').innerText.includes('unstable')", timeout=PATIENCE
    )
    force = float(page.locator(".plane [data-name=F] .fl-field").input_value())
    assert force % 5.0 == 0.0  # a round number
    assert 300.0 < force < 700.0


FIELD = "document.querySelector('.diagram [data-name=mu_k] .fl-field').value"


def test_a_click_into_the_diagram_selects_the_value_there(page):
    page.wait_for_selector(".diagram .fl-panel-bifurcation", timeout=PATIENCE)
    before = page.evaluate(FIELD)
    click(page, ".diagram .fl-panel-bifurcation .fl-over", 0.8, 0.5)
    page.wait_for_function(f"(before) => {FIELD} !== before", arg=before, timeout=PATIENCE)
    assert 2.0 < float(page.evaluate(FIELD)) < 2.9


PICTURE = "document.querySelector('.diagram .fl-panel-response .fl-canvas').toDataURL()"
FILLING = "document.querySelector('.diagram .fl-busy progress').max === 300"


def test_sliders_answer_while_a_diagram_fills(page):
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


def test_a_run_that_is_watched_plays(page):
    play = page.locator(".watched button.fl-play")
    play.scroll_into_view_if_needed(timeout=PATIENCE)
    start = page.locator(".watched .fl-now").inner_text()
    play.click()
    page.wait_for_function(
        "(start) => document.querySelector('.watched .fl-now').innerText !== start", arg=start
    )
    play.click()
    assert play.inner_text() == "play"
