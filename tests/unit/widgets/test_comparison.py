"""The mechanism that moves in an explorer; two scenes at once; the size and colours that a page asks for."""

import re
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import frictionlab as fl
from tests.helpers.cases import slow_but
from tests.helpers.explorers import MODELS, lines

DARK = (17, 17, 17)


@pytest.fixture
def explorer():
    made = fl.explore(fl.SliderOnBelt(mu_k=1.4), ("mechanism", "response"))
    yield made
    made.close()


def frames(canvas):
    names = canvas.scene["columns"]
    return dict(zip(names, np.frombuffer(canvas.rows, "<f4").reshape(-1, len(names)).T, strict=True))


def words(text):
    return re.sub(r"<[^>]+>", "", text.replace("<br>", "\n"))


@pytest.mark.parametrize("name", slow_but(["SliderOnBelt()", "TwoBlocks()", "DenHartog()"], MODELS))
def test_every_model_opens_with_its_mechanism_in_motion(name):
    model = MODELS[name]
    explorer = fl.explore(model, ("mechanism",))
    assert explorer.error is None
    rows = frames(explorer.mechanism.canvas)
    assert all(np.isfinite(values).all() for values in rows.values())
    t = explorer.mechanism.canvas.scene["start"] + explorer.mechanism.canvas.scene["step"] * np.arange(
        len(rows["mode"])
    )
    coordinate = next(name for name in model.coordinates if name in rows)
    exact = explorer.run(np.minimum(t, explorer.run.raw.t))[:, explorer.run.names.index(coordinate)]
    assert np.allclose(rows[coordinate], exact, rtol=1e-6, atol=1e-6 * np.abs(exact).max())
    assert np.ptp(rows[coordinate]) > 0
    explorer.close()


def test_a_control_moves_the_mechanism(explorer):
    before = frames(explorer.mechanism.canvas)["x1"]
    explorer.controls["F"].value = 300.0
    t = explorer.result.times()
    expected = explorer.run(t)[:, 0]
    found = frames(explorer.mechanism.canvas)["x1"]
    assert not np.array_equal(before, found)
    assert (found.min(), found.max()) == pytest.approx((expected.min(), expected.max()), rel=0.01)


@pytest.mark.slow
def test_a_model_without_a_mechanism_is_explored_without():
    class Bare(fl.MassOnBelt):
        mechanism = None

    assert "mechanism" not in fl.explore(Bare(), None).result.__dict__
    explorer = fl.explore(Bare())
    assert (explorer.error, explorer.mechanism) == (None, None)
    asked = fl.explore(Bare(), ("mechanism", "response"))
    assert "give the model a property `mechanism`" in asked.layout.message.value


def test_a_scene_is_kept_beside_another_and_exchanged(explorer):
    shown = lines(explorer, "response")["$x_{1}$"].get_ydata()
    explorer.controls["compare"].value = True
    assert "move a control" in explorer.layout.comparison.value
    explorer.controls["F"].value = 300.0
    explorer.controls["switch-cubic"].value = False
    told = words(explorer.layout.comparison.value)
    assert "dotted, kept: switch-cubic = on, F = 200, k_nl = 10000" in told
    assert "solid, now: switch-cubic = off, F = 300" in told
    kept = explorer.picture.tiles["response"].frozen["$x_{1}$"]
    assert np.array_equal(kept.get_ydata(), shown)
    assert np.array_equal(
        frames(explorer.comparison.mechanism.canvas)["x1"], frames_of(fl.SliderOnBelt(mu_k=1.4))
    )
    assert explorer.comparison.mechanism.canvas in explorer.layout.pictures.children
    assert [m.canvas.follows for m in (explorer.mechanism, explorer.comparison.mechanism)] == [False, True]
    explorer.controls["swap"].click()
    assert explorer.model == fl.SliderOnBelt(mu_k=1.4)
    assert "solid, now: switch-cubic = on, F = 200" in words(explorer.layout.comparison.value).replace(
        "  ", " "
    )
    assert np.array_equal(lines(explorer, "response")["$x_{1}$"].get_ydata(), shown)
    explorer.controls["compare"].value = False
    assert explorer.comparison.mechanism is None
    assert explorer.layout.comparison.layout.display == "none"
    assert explorer.controls["swap"].disabled
    assert len(explorer.layout.pictures.children) == 2


def frames_of(model):
    other = fl.explore(model, ("mechanism",))
    found = frames(other.mechanism.canvas)["x1"]
    other.close()
    return found


def test_a_page_asks_for_a_size_and_for_dark_colours(explorer):
    explorer.controls["compare"].value = True
    explorer.controls["F"].value = 300.0
    kept, now = (picture["$x_{1}$"].get_ydata() for picture in both(explorer))
    screen = explorer.layout.screen
    screen.set_state({"pixels": 790, "dark": True})
    assert image(explorer).size == (770, 525)  # 175 pixels an inch
    assert image(explorer).getpixel((1, 1)) == DARK
    assert explorer.mechanism.canvas.scene["paper"] == "#111111"
    assert explorer.comparison.mechanism.canvas.scene["paper"] == "#111111"
    found = [picture["$x_{1}$"].get_ydata() for picture in both(explorer)]
    assert all(np.array_equal(a, b) for a, b in zip(found, (kept, now), strict=True))
    right = explorer.picture.tiles["response"].right
    assert right is not None
    assert right.yaxis.label.get_color() == "#ffffff"
    screen.set_state({"pixels": 445, "dark": False})
    assert image(explorer).size == (440, 300)
    assert image(explorer).getpixel((1, 1)) == (255, 255, 255)


def both(explorer):
    tile = explorer.picture.tiles["response"]
    return tile.frozen, tile.lines


def image(explorer):
    return Image.open(BytesIO(explorer.picture.images["response"].value)).convert("RGB")


def test_a_style_of_ones_own_is_kept_on_any_page():
    with fl.style("dark"):
        explorer = fl.explore(fl.MassOnBelt(), ("mechanism", "response"))
    explorer.layout.screen.set_state({"pixels": 790, "dark": False})
    explorer.controls["v"].value = 0.3
    assert image(explorer).getpixel((1, 1)) == DARK
    assert explorer.mechanism.canvas.scene["paper"] == "#111111"
