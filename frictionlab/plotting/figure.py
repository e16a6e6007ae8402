"""A figure that shows itself in a notebook without pyplot."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure


class RunFigure(Figure):
    """A matplotlib figure that a notebook displays whether or not pyplot was imported there."""

    def _repr_png_(self) -> bytes:
        # IPython knows how to display a Figure only once pyplot has set up its inline backend.
        buffer = BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


def axes_or_new(ax: Axes | None, **options: Any) -> Axes:
    """The axes given, or those of a new figure, found as ``artist.axes.figure``."""
    if ax is not None:
        return ax
    settings = {"figsize": (7.0, 4.0), "layout": "constrained"} | options
    return RunFigure(**settings).add_subplot()
