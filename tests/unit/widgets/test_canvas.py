"""The live canvas: what it is sent, and what its JavaScript draws in a browser of its own."""

import json
import re
from importlib import resources

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.plotting.appearance import BLUE, GREY, MODE_COLOURS
from tests.helpers.canvas_page import open_canvas, picture_of, pixels_of, scrub
from tests.helpers.cases import slow_but

MODEL = fl.SliderOnBelt(mu_k=1.4)
BELT, PHASE = 0, 1  # the two pictures


@pytest.fixture(scope="module")
def run():
    return fl.simulate(MODEL, 0.5, t_eval=np.arange(501) / 1000, progress=False)


@pytest.fixture(scope="module")
def canvas(run):
    return fl.watch(run, window=None)


def columns(canvas):
    names = canvas.scene["columns"]
    return dict(zip(names, np.frombuffer(canvas.rows, "<f4").reshape(-1, len(names)).T))


def test_the_rows_are_the_run_in_32_bits(run, canvas):
    rows, s = columns(canvas), float(re.search(r"× (\S+),", canvas.scene["note"])[1])
    for name, value in {
        "slider_x": s * run["x1"],
        "slider_y": s * run["y1"] + canvas.scene["spring"],
        "belt_x": s * run["x2"],
        "belt_y": s * run["y2"],
        "slope": -run["phi"],
        "travel": s * MODEL.v * run.t,
        "normal_force": run.normal_force,
        "friction_force": run.friction_force,
        "x1": run["x1"],
        "rate": run["x1'"],
    }.items():
        assert np.allclose(rows[name], value, rtol=1e-6, atol=1e-6 * np.abs(value).max()), name
    assert [canvas.scene["modes"][int(code)] for code in rows["mode"]] == run.mode.tolist()


def test_numbers_are_sent_as_bytes_and_the_rest_is_small(canvas):
    state = canvas.get_state(["rows", "scene"])
    assert isinstance(state["rows"], bytes)
    assert len(json.dumps(state["scene"])) < 3000
    assert canvas.scene["colours"] == [MODE_COLOURS[name] for name in canvas.scene["modes"]]


@pytest.mark.parametrize(
    "model",
    [MODEL.without("geometry"), MODEL.without("nonsmooth"), MODEL.replace(interface=fl.StickSlip())],
    ids=repr,
)
def test_other_scenes_are_shown(model):
    rows = columns(fl.watch(fl.simulate(model, 0.1, progress=False)))
    assert len(rows["mode"]) == 101
    assert all(np.isfinite(values).all() for values in rows.values())


@pytest.mark.parametrize("name", ["canvas.js", "panels/panel_image.js"])
def test_the_javascript_is_in_the_package_and_needs_nothing_else(name):
    code = resources.files("frictionlab.widgets").joinpath(*name.split("/")).read_text(encoding="utf-8")
    assert "export default { render }" in code
    assert not re.search(r"https?:|\bimport\b|\bfetch\b|XMLHttpRequest", code)


DARK_MODELS = {"belt": MODEL, "parts": fl.MassOnBelt()}


@pytest.mark.parametrize("name", slow_but(["parts"], DARK_MODELS))
def test_a_dark_style_is_dark_all_over(name, browser):
    run = fl.simulate(DARK_MODELS[name], 0.5, progress=False)
    with fl.style("dark"):
        canvas = fl.watch(run, window=None)
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    open_canvas(page, canvas)
    behind = page.evaluate(
        "getComputedStyle(document.querySelector('canvas').parentNode.parentNode).backgroundColor"
    )
    assert behind == "rgb(17, 17, 17)"
    for index in (BELT, PHASE):
        assert pixels_of(page, index, canvas.scene["ink"])
        assert not pixels_of(page, index, "#000000")
        drawn = picture_of(page, index)
        light = (drawn[..., 3] > 0) & (drawn[..., :3].min(axis=2) > 200)
        assert 0 < light.mean() < 0.05  # lines and letters, and no area
    page.close()


@pytest.fixture(
    params=[
        pytest.param((1280, 720), id="wide"),
        pytest.param((400, 800), id="narrow", marks=pytest.mark.slow),
    ]
)
def page(request, browser, canvas):
    page = browser.new_page(viewport=dict(zip(("width", "height"), request.param)))
    page.failures = []
    page.on("pageerror", lambda error: page.failures.append(error))
    page.on("request", lambda request: request.url.startswith("blob:") or page.failures.append(request.url))
    open_canvas(page, canvas)
    yield page
    assert page.failures == []
    page.close()


def frames_of(run, mode):
    """Some frames amid a mode."""
    inside = np.flatnonzero((run.mode[1:-1] == mode) & (run.mode[2:] == mode) & (run.mode[:-2] == mode)) + 1
    assert len(inside), f"the run has no frame amid {mode}"
    return inside[:: max(1, len(inside) // 5)].tolist()


def to_pixels(page, canvas, x, y):
    """Where a point of the mechanism is on its canvas."""
    width, height = page.evaluate(
        "(({ width, height }) => [width, height])(document.querySelector('canvas'))"
    )
    (x0, x1), (y0, y1) = canvas.scene["limits"]
    k = min(width / (x1 - x0), height / (y1 - y0))
    return width / 2 + k * (x - (x0 + x1) / 2), height / 2 - k * (y - (y0 + y1) / 2)


@pytest.mark.parametrize("mode", ["stick", "separation"])
def test_the_browser_draws_the_slider_in_its_place_and_colour(page, run, canvas, mode):
    rows, (w, h) = columns(canvas), canvas.scene["block"]
    for k in frames_of(run, mode):
        assert f"t = {run.t[k]:.3f} s: {mode};" in scrub(page, k)
        left, right, top, bottom = pixels_of(page, BELT, MODE_COLOURS[mode])
        x, y = rows["slider_x"][k], rows["slider_y"][k]
        expected = *to_pixels(page, canvas, x - w / 2, y + h), *to_pixels(page, canvas, x + w / 2, y)
        # The outline and a blurred pixel at each edge lie between.
        assert np.abs(np.array([left, top, right + 1, bottom + 1]) - expected).max() < 2.5


def test_the_browser_draws_the_normal_force_but_not_in_flight(page, run, canvas):
    for k in frames_of(run, "separation"):
        scrub(page, k)
        assert pixels_of(page, BELT, BLUE) is None
    size, scale = canvas.scene["block"][1], canvas.scene["scale"]
    for k in frames_of(run, "stick"):
        scrub(page, k)
        rows = columns(canvas)
        middle = rows["slider_y"][k] + size / 2
        tip = to_pixels(page, canvas, 0.0, middle + run.normal_force[k] / scale)[1]
        assert abs(pixels_of(page, BELT, BLUE)[2] - tip) < 4.5  # a tip is thinner than a pixel


@pytest.mark.parametrize(("name", "axis"), [("x1", 0), ("rate", 1)])
def test_the_browser_moves_the_point_in_the_phase_plane(page, canvas, name, axis):
    values = columns(canvas)[name]
    low, high = int(values.argmin()), int(values.argmax())
    scrub(page, low)
    before = picture_of(page, PHASE)
    scrub(page, high)
    changed = np.argwhere((before != picture_of(page, PHASE)).any(axis=2))[:, ::-1]  # x, y of the pixels
    first, last = changed.min(axis=0)[axis], changed.max(axis=0)[axis]
    # Axes 58 and 12 pixels from the edges across, 12 and 40 down; 5 % of the range stays free at each end.
    start, room = ((58, before.shape[1] - 70), (12, before.shape[0] - 52))[axis]
    radius, free = 6.75, 0.05 / 1.1 * room
    assert first == pytest.approx(start + free - radius, abs=1.5)
    assert last + 1 == pytest.approx(start + room - free + radius, abs=1.5)


def test_playing_advances_at_the_stated_pace_and_pausing_stops(page):
    def time():
        return float(re.match(r"t = (\S+) s", page.locator("span").first.inner_text())[1])

    scrub(page, 100)
    page.get_by_role("button", name="play").click()
    page.wait_for_function("document.querySelector('span').textContent >= 't = 0.11'")
    page.get_by_role("button", name="pause").click()
    stopped = time()
    page.wait_for_timeout(100)
    assert time() == stopped >= 0.11
    assert page.get_by_role("combobox").input_value() == "0.05"
    page.get_by_role("combobox").select_option("real time")


def test_nothing_is_cut_off(page):
    width = page.viewport_size["width"]
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    parts = "[...document.querySelectorAll('canvas, button, select, input')]"
    boxes = page.evaluate(f"{parts}.map((e) => e.getBoundingClientRect().toJSON())")
    assert all(box["left"] >= 0 and box["right"] <= width and box["width"] > 40 for box in boxes)


OTHERS = [fl.MassOnBelt(), fl.SliderOnRigidBelt(), fl.BouncingBall(), fl.TwoBlocks()]


@pytest.mark.parametrize("model", slow_but(OTHERS[-1:], OTHERS), ids=repr)
def test_the_browser_draws_the_bodies_of_other_models_in_their_places(page, model):
    run = fl.simulate(model, 8 * model.period, progress=False)
    canvas = fl.watch(run, window=None)
    open_canvas(page, canvas)
    rows, scene = columns(canvas), canvas.scene
    names, count = list(rows), len(rows["mode"])
    bodies = [s["first"] for s in scene["shapes"] if s["kind"] in ("block", "disc")]
    # In the other modes the bodies are as grey as the walls.
    coloured = [k for k in range(count) if scene["colours"][int(rows["mode"][k])] != GREY]
    assert len(coloured) > 20
    for k in coloured[:: len(coloured) // 4]:
        assert scene["modes"][int(rows["mode"][k])] in scrub(page, k)
        places = np.array([[rows[names[i + j]][k] for j in range(4)] for i in bodies])
        x, y, w, h = places.T
        left, right, top, bottom = pixels_of(page, BELT, scene["colours"][int(rows["mode"][k])])
        low = to_pixels(page, canvas, (x - w / 2).min(), (y + h / 2).max())
        high = to_pixels(page, canvas, (x + w / 2).max(), (y - h / 2).min())
        # As above; arrows and springs may cover the edge of a body, not its corners.
        assert np.abs(np.array([left, top, right + 1, bottom + 1]) - [*low, *high]).max() < 2.5
