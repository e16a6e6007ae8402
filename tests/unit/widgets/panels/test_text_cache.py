"""Texts that are remembered look as Agg draws them."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from frictionlab.plotting.figure import RunFigure
from frictionlab.widgets.panels.picture import TextCacheCanvas, text_image

TEXTS = "time (s)", r"$\dot{x}_1$ (m/s)", "$10^{-6}$", "−0.025"


def drawn(canvas_type, text, x, angle):
    figure = RunFigure(figsize=(2.0, 2.0), dpi=100)
    figure.text(x, 0.5, text, rotation=angle, color="#0072B2", fontsize=9.0)
    canvas = canvas_type(figure)
    canvas.draw()
    return 255.0 - np.asarray(canvas.buffer_rgba())[..., :3].astype(float)


def middle(ink):
    weight = ink.sum(axis=2)
    return [(np.indices(weight.shape)[axis] * weight).sum() / weight.sum() for axis in (0, 1)]


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("angle", [0.0, 90.0])
@pytest.mark.parametrize("x", [0.2, 0.2034])
def test_a_text_is_as_dark_and_stands_within_a_pixel_of_where_agg_has_it(text, angle, x):
    expected, found = (drawn(kind, text, x, angle) for kind in (FigureCanvasAgg, TextCacheCanvas))
    assert found.sum() == pytest.approx(expected.sum(), rel=0.02)
    assert middle(found) == pytest.approx(middle(expected), abs=1.0)


def test_a_text_is_set_once_for_each_look():
    text_image.cache_clear()
    for _ in range(2):
        drawn(TextCacheCanvas, "gap (m)", 0.2, 0.0)
    assert text_image.cache_info().misses == 1
    drawn(TextCacheCanvas, "gap (m)", 0.2, 90.0)
    assert text_image.cache_info().misses == 2


def test_a_text_without_ink_is_none():
    assert (drawn(TextCacheCanvas, " ", 0.2, 0.0) == 0.0).all()
