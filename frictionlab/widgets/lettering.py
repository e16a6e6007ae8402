"""A canvas that remembers what texts look like: to set one takes as long as to draw many curves."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.font_manager import FontProperties
from numpy.typing import NDArray

REMEMBERED = 2048  # texts


class Lettering(NamedTuple):
    """Pixels (h, w, 4) of a text, upwards, and where its left lower corner is as seen from its origin."""

    pixels: NDArray[np.uint8]
    left: int
    below: int


class LetteringRenderer(RendererAgg):
    """Agg, with every text set once; it then stands at whole pixels."""

    def draw_text(
        self,
        gc: Any,
        x: float,
        y: float,
        s: str,
        prop: Any,
        angle: float,
        ismath: Any = False,
        mtext: Any = None,
    ) -> None:
        """Copy the text's pixels to where its origin, y downwards, is."""
        look = tuple(gc.get_rgb()), gc.get_alpha()
        letters = lettering(s, prop.copy(), float(angle), bool(ismath), self.dpi, look)
        if letters is not None:
            left, below = round(x) + letters.left, self.height - round(y) + letters.below
            self.draw_image(gc, left, below, letters.pixels)


class LetteringCanvas(FigureCanvasAgg):
    """A canvas for one figure that never changes its size."""

    def get_renderer(self) -> LetteringRenderer:
        """The only one."""
        if not hasattr(self, "renderer"):
            self.renderer = LetteringRenderer(*self.figure.bbox.size, self.figure.dpi)
        return self.renderer


@lru_cache(REMEMBERED)
def lettering(
    text: str, prop: FontProperties, angle: float, ismath: bool, dpi: float, look: Any
) -> Lettering | None:
    """What a text looks like; None where nothing of it is seen."""
    plain = RendererAgg(1, 1, dpi)
    width, height, descent = plain.get_text_width_height_descent(text, prop, ismath)
    reach = int(np.ceil(np.hypot(width, height + descent))) + 4  # whatever the angle
    sheet = RendererAgg(2 * reach, 2 * reach, dpi)
    gc = sheet.new_gc()
    colour, alpha = look
    gc.set_foreground(colour, isRGBA=True)
    gc.set_alpha(alpha)
    sheet.draw_text(gc, reach, reach, text, prop, angle, ismath)
    pixels = np.asarray(sheet.buffer_rgba())
    rows, columns = (np.flatnonzero(pixels[..., 3].any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    top, bottom, left = rows[0], rows[-1] + 1, columns[0]
    cut = pixels[top:bottom, left : columns[-1] + 1]
    return Lettering(cut[::-1].copy(), int(left) - reach, reach - int(bottom))
