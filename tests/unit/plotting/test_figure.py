"""`RunFigure.savefig` writes the pixels that matplotlib's own writes."""

from io import BytesIO

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import frictionlab as fl
from frictionlab.plotting import RunFigure
from tests.helpers.cases import slow_but


def of_a_run():
    return fl.plot_run(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.5, progress=False))


def of_equal_scales():
    figure = RunFigure(figsize=(5.0, 3.0), layout="constrained")
    for ax in figure.subplots(1, 2):
        ax.plot([0.0, 1e-5, 2e-5], [0.0, 4e-5, 1e-5])
        ax.set(aspect="equal", title="a title that is longer than the axes")
    return figure


def without_a_layout():
    figure = RunFigure(figsize=(3.0, 2.0), dpi=80, facecolor="yellow")
    figure.add_subplot().semilogy([1.0, 1e-4], animated=True)
    return figure


SETTINGS = {}, {"savefig.dpi": 60}, {"savefig.bbox": "tight"}
OPTIONS = {}, {"dpi": 50}, {"dpi": "figure"}, {"facecolor": "red"}, {"transparent": True}
WAYS = [  # one option and the setting that moves what is drawn at once, all in the slow tests
    pytest.param(
        settings,
        options,
        marks=() if (settings, options) == ({"savefig.bbox": "tight"}, {}) else pytest.mark.slow,
    )
    for settings in SETTINGS
    for options in OPTIONS
]


def pixels(content):
    return np.asarray(Image.open(content))


@pytest.mark.parametrize(("settings", "options"), WAYS, ids=str)
@pytest.mark.parametrize(
    "make", slow_but([of_equal_scales], [of_equal_scales, without_a_layout]), ids=lambda make: make.__name__
)
def test_the_pixels_are_those_of_matplotlib(make, options, settings, tmp_path):
    with mpl.rc_context(settings):
        make().savefig(path := tmp_path / "ours.png", **options)
        make().savefig(stream := BytesIO(), format="png", **options)
        Figure.savefig(make(), usual := tmp_path / "usual.png", **options)
    assert np.array_equal(pixels(path), pixels(usual))
    assert np.array_equal(pixels(stream), pixels(usual))


@pytest.mark.slow
@pytest.mark.parametrize("style", ["screen", "projector"])
def test_the_picture_of_a_run_is_that_of_matplotlib(style, tmp_path):
    with fl.style(style):
        of_a_run().savefig(path := str(tmp_path / "ours.PNG"))
        Figure.savefig(of_a_run(), usual := tmp_path / "usual.png")
    assert np.array_equal(pixels(path), pixels(usual))


@pytest.mark.slow
def test_a_figure_is_what_it_was_once_it_is_written(tmp_path):
    figure = of_equal_scales()
    canvas, dpi = figure.canvas, figure.dpi
    figure.savefig(first := tmp_path / "first.png")
    figure.savefig(tmp_path / "coarse.png", dpi=30)
    assert (figure.canvas, figure.dpi) == (canvas, dpi)
    figure.savefig(again := tmp_path / "again.png")
    assert np.array_equal(pixels(again), pixels(first))


def test_a_name_without_suffix_gets_matplotlibs(tmp_path):
    of_equal_scales().savefig(tmp_path / "png")
    assert [path.name for path in tmp_path.iterdir()] == ["png.png"]
