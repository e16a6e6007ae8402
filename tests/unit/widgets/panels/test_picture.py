"""One figure and the same artists for good; axes are drawn only where they change."""

import gc
import sys
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import frictionlab as fl
from frictionlab.plotting.figure import Curve, Drawing
from frictionlab.widgets.panels.picture import DPI, PANEL_HEIGHT, PANEL_WIDTH, Picture, encode_png
from frictionlab.widgets.panels.tile import AXES_RECTANGLE
from tests.helpers.cases import slow_but

MODEL = fl.SliderOnBelt(mu_k=0.4).without("geometry")


def artists(picture):
    return {id(a) for tile in picture.tiles.values() for a in tile.ax.get_children()}


def resident():
    """Megabytes of memory in use; 0 where the system does not say."""
    if sys.platform != "linux":
        return 0.0
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 2**20


def pyplot_figures():
    """Numbers of the figures that pyplot holds."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    return [] if pyplot is None else pyplot.get_fignums()


@pytest.mark.slow
def test_200_steps_of_a_slider_make_no_artist_and_keep_no_memory():
    explorer = fl.explore(MODEL, ("response", "phase", "eigenvalues"))
    explorer.controls["duration"].value = 2.0
    slider, figure = explorer.controls["mu_k"], explorer.picture.figure
    values = 0.4 + 0.3 * np.sin(2 * np.pi * np.arange(200.0) / 100)
    for value in values[:50]:  # caches fill, native code is compiled
        slider.value = value
    gc.collect()
    opened = pyplot_figures()  # by other tests
    before, axes, memory = artists(explorer.picture), list(figure.axes), resident()
    for value in values:
        slider.value = value
    gc.collect()
    assert explorer.error is None
    assert explorer.updates > 200
    assert artists(explorer.picture) == before
    assert (explorer.picture.figure, list(figure.axes)) == (figure, axes)
    assert resident() - memory < 20
    assert pyplot_figures() == opened


def drawn(picture, name, curves, **options):
    picture.panels[name] = lambda result: Drawing("x (m)", "y (m)", curves, **options)
    picture.draw(None)
    return np.asarray(Image.open(BytesIO(picture.images[name].value)).convert("RGB")).astype(int)


def line(top):
    return {"line": Curve(np.linspace(0.0, 1.0, 50), np.linspace(0.0, top, 50), {"color": "black"})}


def test_where_a_diagram_goes_on_nothing_else_is_drawn_again():
    calls = {"whole": 0, "in parts": 0}

    def whole(result):
        calls["whole"] += 1
        return Drawing("x (m)", "y (m)", line(1.0))

    def in_parts(result):
        calls["in parts"] += 1
        left = 3 - calls["in parts"]
        return Drawing("x (m)", "y (m)", line(calls["in parts"]), progress=(3 - left, 3) if left else None)

    picture = Picture({"whole": whole, "in parts": in_parts})
    progress = [picture.draw(None), picture.draw(None, goes_on=True), picture.draw(None, goes_on=True)]
    assert progress == [(1, 3), (2, 3), None]
    assert calls == {"whole": 1, "in parts": 3}
    assert [picture.tiles[name].lines["line"].get_ydata()[-1] for name in calls] == [1.0, 3.0]


def test_axes_are_drawn_anew_only_where_limits_or_labels_change():
    picture = Picture({"one": None})
    tile = picture.tiles["one"]
    counts = []
    for curves in (line(1.0), line(0.9), line(1.02), line(3.0), line(3.0) | {"other": Curve([0.5], [1.0])}):
        drawn(picture, "one", curves)
        counts.append(tile.redrawn)
    assert counts == [1, 1, 1, 2, 3]


def test_over_the_kept_background_the_pixels_are_those_of_a_fresh_drawing():
    fresh, used = Picture({"one": None}), Picture({"one": None})
    drawn(used, "one", line(1.0))
    used_pixels = drawn(used, "one", line(0.9))
    drawn(fresh, "one", line(1.0))
    fresh.tiles["one"].background = None
    assert used.tiles["one"].redrawn == 1
    assert np.array_equal(used_pixels, drawn(fresh, "one", line(0.9)))
    assert (used_pixels.sum(axis=2) < 300).sum() > 500


@pytest.mark.slow
def test_images_have_the_size_of_a_panel_and_show_their_own():
    picture = Picture({"left": None, "right": None, "below": None})
    picture.panels["left"] = picture.panels["below"] = lambda result: Drawing("x (m)", "y (m)")
    picture.panels["right"] = lambda result: Drawing("x (m)", "y (m)", note="here")
    picture.draw(None)
    pixels = {n: np.asarray(Image.open(BytesIO(i.value)).convert("RGB")) for n, i in picture.images.items()}
    assert all(p.shape == (round(PANEL_HEIGHT * DPI), round(PANEL_WIDTH * DPI), 3) for p in pixels.values())
    right = round((AXES_RECTANGLE[0] + AXES_RECTANGLE[2]) * PANEL_WIDTH * DPI)
    corner = {n: p[44:58, right - 32 : right - 5] for n, p in pixels.items()}  # where the note stands
    assert corner["right"].min() < 100 < corner["left"].min()
    assert np.array_equal(corner["left"], corner["below"])


@pytest.mark.slow
def test_a_slow_update_is_marked_while_it_runs():
    waited = []

    def slow(result):
        while explorer is not None and explorer.busy.widget.layout.visibility != "visible":
            waited.append(gc.collect())
        return Drawing("x (m)", "y (m)")

    explorer = None
    explorer = fl.explore(panels=(slow,))
    explorer.controls["mu_k"].value = 0.5
    assert waited
    assert explorer.error is None
    assert explorer.busy.widget.layout.visibility == "hidden"


FEW, MANY = ("response", "phase"), ("response", "phase", "forces", "spectrum", "eigenvalues")


@pytest.mark.parametrize("panels", slow_but([FEW], [("response",), FEW, MANY]))
def test_the_figure_can_be_saved_with_its_curves(panels):
    explorer = fl.explore(MODEL, panels)
    saved = np.asarray(Image.open(BytesIO(explorer.picture.figure._repr_png_())).convert("RGB")).astype(int)
    shown = np.asarray(Image.open(BytesIO(explorer.picture.images["response"].value)).convert("RGB"))
    corner = saved[: shown.shape[0], : shown.shape[1]]
    assert (np.abs(corner - shown.astype(int)).max(axis=2) > 60).mean() < 0.01


def test_a_png_has_the_colours_of_its_lines_and_pure_white():
    colours = ["#D55E00", "#0072B2", "#F0E442"]
    pixels = np.full((40, 60, 3), 255, dtype=np.uint8)
    for i, colour in enumerate([*colours, "#000000"]):
        pixels[10 * i : 10 * i + 5] = [int(colour[j : j + 2], 16) for j in (1, 3, 5)]
    shown = np.asarray(
        Image.open(BytesIO(encode_png(Image.fromarray(pixels), colours))).convert("RGB")
    ).astype(int)
    assert np.abs(shown - pixels).max() <= 1
    assert (shown[5:10] == 255).all()


def test_many_colours_still_fit_into_a_palette():
    pixels = np.zeros((4, 4, 3), dtype=np.uint8)
    colours = [(i / 299, 0.5, 1 - i / 299) for i in range(300)]
    assert Image.open(BytesIO(encode_png(Image.fromarray(pixels), colours))).size == (4, 4)


def test_shades_on_dark_paper_run_from_the_colours_to_the_paper():
    paper, curve = (17, 17, 17), (230, 159, 0)
    pixels = np.full((4, 4, 3), paper, dtype=np.uint8)
    pixels[0], pixels[1] = curve, 255
    image = Image.open(BytesIO(encode_png(Image.fromarray(pixels), ["#E69F00"], "#111111"))).convert("RGB")
    assert [image.getpixel((0, row)) for row in range(3)] == [curve, (255, 255, 255), paper]
