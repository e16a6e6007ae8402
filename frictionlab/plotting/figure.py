"""Figures without pyplot: they show themselves in a notebook; legends stand where they cover no data.

`RunFigure` is what every function here makes where it is given no axes.  `AnimatedFigure` keeps the image of
the parts that do not move, for animations of many frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imsave

from frictionlab.file_writing import write_file

from .appearance import PANEL_SIZE, crowding, figure_size, font_size


class RunFigure(Figure):
    """A matplotlib figure that a notebook displays whether or not pyplot was imported there."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write a file or to a stream; see :meth:`matplotlib.figure.Figure.savefig`."""
        with write_file(fname) as beside:
            super().savefig(beside, **options)

    def _repr_png_(self) -> bytes:
        # IPython knows how to display a Figure only once pyplot has set up its inline backend.
        buffer = BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


class RunAxes(Axes):
    """Axes that a notebook displays by their figure."""

    def _repr_png_(self) -> bytes | None:
        figure = self.get_figure(root=True)
        return figure._repr_png_() if isinstance(figure, RunFigure) else None


def new_figure(width: float, height: float) -> RunFigure:
    """A figure of this size in inches, in the present style."""
    return RunFigure(figsize=figure_size(width, height), layout="constrained")


def axes_or_new(ax: Axes | None, size: tuple[float, float] = PANEL_SIZE) -> Axes:
    """The axes given, or those of a new figure of a size in inches, found as ``artist.axes.figure``."""
    if ax is not None:
        return ax
    return new_figure(*size).add_subplot(axes_class=RunAxes)


def legend_beside(ax: Axes, handles: list[Any] | None = None) -> None:
    """A legend of everything labelled in `ax`, or of `handles`, to the right of it."""
    handles = ax.get_legend_handles_labels()[0] if handles is None else handles
    if handles:
        place: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
        ax.legend(handles=handles, frameon=False, fontsize=font_size(9.0), **place)


def set_long_title(ax: Axes, text: str) -> None:
    """A title that fills the width of a figure, smaller where letters are large."""
    title = ax.set_title(text)
    title.set_fontsize(float(title.get_fontsize()) / crowding())


def wrap_label(text: str, length: int) -> str:
    """A label that has so many letters in a line; where letters are large it is broken into lines."""
    return text if crowding() == 1.0 else fill(text, round(length / crowding()), break_long_words=False)


class AnimatedFigure(RunFigure):
    """A figure that keeps the image of its fixed parts, as drawing all of them in every frame takes far
    longer."""

    moving_artists: Sequence[Artist] = ()
    _still: tuple[Any, Any] = (None, None)

    def savefig(self, fname: Any, *, transparent: bool | None = None, **options: Any) -> None:
        """Write a file; from the kept image for PNG or raw pixels, which writers of animations use."""
        kind = options.get("format")
        if (
            not self.moving_artists
            or kind not in ("png", "rgba")
            or transparent
            or options.get("bbox_inches")
        ):
            return super().savefig(fname, transparent=transparent, **options)
        dpi = options.get("dpi", "figure")
        pixels = self.pixels(self.dpi if dpi == "figure" else dpi)
        if kind == "rgba":
            return fname.write(pixels.tobytes())
        with write_file(fname) as beside:
            imsave(beside, pixels, format="png")

    def pixels(self, dpi: float) -> np.ndarray:
        """The picture as (height, width, 4) bytes."""
        canvas, usual = self.canvas, self.dpi
        self.dpi = dpi
        try:
            return self._drawn(FigureCanvasAgg(self))
        finally:
            self.dpi = usual
            self.set_canvas(canvas)

    def _drawn(self, canvas: FigureCanvasAgg) -> np.ndarray:
        renderer, size = canvas.get_renderer(), canvas.get_width_height()
        if self._still[0] != size:
            self._show_moving(False)
            self.draw(renderer)
            self._show_moving(True)
            self._still = size, renderer.copy_from_bbox(self.bbox)
        renderer.restore_region(self._still[1])
        for artist in sorted(self.moving_artists, key=lambda artist: artist.get_zorder()):
            artist.draw(renderer)
        return np.array(canvas.buffer_rgba())

    def _show_moving(self, visible: bool) -> None:
        for artist in self.moving_artists:
            artist.set_visible(visible)
