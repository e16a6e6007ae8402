"""A run that is watched: what the browser gets, and what it draws of it on a page of its own."""

import base64
import json

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.pages.export import text_of
from frictionlab.plotting.appearance import MODE_COLOURS
from tests.helpers.cases import slow_but
from tests.helpers.explorers import columns

MODEL = fl.SliderOnBelt(mu_k=1.4)
# A model that answers as anywidget's does, with all that Python sends; its bytes are aligned to nothing.
START = """async ({ code, css, values }) => {
  const module = await import(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
  const bytes = (text) => {
    const found = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const padded = new Uint8Array(found.length + 3);
    padded.set(found, 3);
    return new DataView(padded.buffer, 3);
  };
  const revived = (key, value) => (value?.base64 === undefined ? value : bytes(value.base64));
  const state = JSON.parse(values, revived), el = document.createElement("div");
  document.head.append(Object.assign(document.createElement("style"), { textContent: css }));
  document.body.append(el);
  const nothing = () => {}, model = { get: (name) => state[name], set: nothing, save_changes: nothing };
  window.stop = module.default.render({ model: { ...model, on: nothing, off: nothing }, el });
  await new Promise((done) => setTimeout(done, 200));
}"""


@pytest.fixture(scope="module")
def run():
    return fl.simulate(MODEL, 0.5, t_eval=np.arange(501) / 1000, progress=False)


@pytest.fixture(scope="module")
def watched(run):
    return fl.watch(run, window=None, speed=0.05)


def opened(browser, widget, dark=False):
    page = browser.new_page(viewport={"width": 1280, "height": 720}, color_scheme="dark" if dark else "light")
    page.failures = []
    page.on("pageerror", lambda error: page.failures.append(str(error)))
    page.on("request", lambda request: request.url.startswith("blob:") or page.failures.append(request.url))
    page.set_content("<!doctype html><body style='margin: 0'></body>")
    state = {name: getattr(widget, name) for name in ("scene", "state", "picture", "error")}
    values = json.dumps(state, default=lambda data: {"base64": base64.b64encode(data).decode()})
    code = {"code": widget._esm, "css": text_of("explorer.css"), "values": values}
    page.evaluate(START, code)
    return page


@pytest.fixture(scope="module")
def page(browser, watched):
    page = opened(browser, watched)
    yield page
    assert page.failures == []
    page.close()


def test_the_browser_gets_the_run_to_the_last_bit(run, watched):
    found = columns(watched)
    t = found["t"]
    assert t == pytest.approx(run.t)
    assert np.array_equal(np.column_stack([found[name] for name in run.names]), run(t))
    assert all(np.array_equal(found[name], run.output(name, t)) for name in run.automaton.outputs)
    assert found["mode"].tolist() == run.mode.tolist()
    assert len(json.dumps(watched.scene)) < 6000


def test_factors_and_paces_are_the_callers(run):
    widget = fl.watch(run, window=0.1, speed=0.3, rate=50.0, magnify=2.0)
    assert (widget.scene["speed"], widget.picture["magnify"]) == (0.3, 2.0)
    assert columns(widget)["t"] == pytest.approx(np.arange(0.4, 0.501, 0.02))


@pytest.mark.parametrize("mode", ["stick", "separation"])
def test_the_browser_draws_the_slider_in_the_colour_of_its_mode(page, run, mode):
    inside = np.flatnonzero((run.mode[1:-1] == mode) & (run.mode[2:] == mode) & (run.mode[:-2] == mode)) + 1
    for k in inside[:: max(1, len(inside) // 5)].tolist():
        assert scrub(page, run.t[k] / 0.5).endswith(f": {mode}")
        # The slider has 22 x 16 pixels within its edge; arrows of forces and load cover half of them at most.
        assert coloured(page, MODE_COLOURS[mode]) > 22 * 16 / 2
        others = {MODE_COLOURS[name] for name in ("stick", "separation")} - {MODE_COLOURS[mode]}
        assert not any(coloured(page, other) for other in others)


OTHERS = [fl.MassOnBelt(), fl.BouncingBall(), fl.TwoBlocks()]


@pytest.mark.parametrize("model", slow_but(OTHERS[-1:], OTHERS), ids=repr)
def test_other_mechanisms_move(browser, model):
    page = opened(browser, fl.watch(fl.simulate(model, 4 * model.period, progress=False)))
    before = scrub(page, 0.1), pixels(page)
    after = scrub(page, 0.35), pixels(page)
    assert before[0] != after[0]
    assert (before[1] != after[1]).any()
    assert page.failures == []
    page.close()


def test_on_a_dark_page_it_is_dark(browser, watched):
    page = opened(browser, watched, dark=True)
    paper = page.evaluate("getComputedStyle(document.querySelector('.fl-explorer')).backgroundColor")
    assert paper == "rgb(17, 17, 17)"
    assert not coloured(page, "#000000")
    page.close()


def test_playing_advances_at_the_stated_pace_and_pausing_stops(page):
    scrub(page, 0.2)
    assert page.locator(".fl-pace").input_value() == "0.05"
    page.get_by_role("button", name="play").click()
    page.wait_for_function("document.querySelector('.fl-now').textContent >= 't = 0.11'")
    page.get_by_role("button", name="pause").click()
    stopped = page.inner_text(".fl-now")
    page.wait_for_timeout(100)
    assert page.inner_text(".fl-now") == stopped


def scrub(page, share):
    """Move the slider of time; returns the line of text."""
    move = "(v) => { const s = document.querySelector('.fl-scrub'); s.value = v; s.oninput() }"
    page.evaluate(move, round(1000 * float(share)))
    return page.inner_text(".fl-now")


def pixels(page):
    """Pixels (height, width, 4) of the mechanism."""
    script = """() => {
      const c = document.querySelector(".fl-panel-mechanism .fl-canvas");
      const { data } = c.getContext("2d").getImageData(0, 0, c.width, c.height);
      let text = "";
      for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
      return [c.height, c.width, btoa(text)];
    }"""
    height, width, text = page.evaluate(script)
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)


def coloured(page, colour):
    """How many pixels have exactly a colour."""
    return int((pixels(page) == [*bytes.fromhex(colour[1:]), 255]).all(axis=2).sum())
