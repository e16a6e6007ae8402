"""The content of a panel as data: a panel is a function that takes a result and returns a `Drawing`.

It makes no artists, so that it does not depend on how a picture is updated, and the same curves can be
checked in a test or kept in grey for comparison::

    def penetration(result):
        t = result.times()
        u = result.run.output("penetration", t)
        return Drawing("time (s)", "penetration (m)", {"penetration": Curve(t, u)})

    fl.explore(panels=("response", penetration))

`envelope` gives long curves in few points: the smallest and the largest value in each pixel's worth of
samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ENVELOPE_BINS = 400  # about the width of a panel in pixels


class Curve(NamedTuple):
    """A line of a panel.

    Parameters
    ----------
    x, y : array_like (N,)
        NaN breaks the line.
    style : mapping
        Keywords of matplotlib's Line2D; those given when a curve is first drawn are kept.
    axis : "left", "right" or "strip"
        The axis of y; on a strip 0 is the bottom of the panel and 1 its top.
    """

    x: Any
    y: Any
    style: Mapping[str, Any] = {}
    axis: Literal["left", "right", "strip"] = "left"


@dataclass(frozen=True)
class Drawing:
    """A panel's content.

    Parameters
    ----------
    xlabel, ylabel : str
        With units.
    curves : mapping of str to Curve
        By the label in the legend; one that begins with an underscore is not listed there.
    right : str
        Label of the axis on the right, for the curves that belong to it.
    yscale : "linear" or "log"
    note : str
        A few words in the corner, without mathematics; they may change with every step of a slider.
    xlim, ylim : (float, float) or None
        None follows the curves.
    progress : (int, int) or None
        Parts done and their total, where the panel is to be called again until all are done.
    """

    xlabel: str
    ylabel: str
    curves: Mapping[str, Curve] = field(default_factory=dict)
    right: str = ""
    yscale: Literal["linear", "log"] = "linear"
    note: str = ""
    xlim: tuple[float, float] | None = None
    ylim: tuple[float, float] | None = None
    progress: tuple[int, int] | None = None


def envelope(x: Any, y: Any, bins: int = ENVELOPE_BINS) -> tuple[Array, Array]:
    """The curve with at most two points for each of `bins` parts of it: its extremes, in their order.

    Parameters
    ----------
    x, y : array_like (N,)
        At equal distances of x; finite.
    bins : int

    Returns
    -------
    x, y : arrays
        Samples of the curve: as given where they are no more than four for each part.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if len(y) <= 4 * bins:
        return x, y
    edges = np.linspace(0, len(y), bins + 1).astype(int)[:-1]
    extremes = np.concatenate(
        [_extreme_indices(np.minimum, y, edges), _extreme_indices(np.maximum, y, edges)]
    )
    kept = np.unique(np.append(extremes, [0, len(y) - 1]))
    return x[kept], y[kept]


def _extreme_indices(extreme: Any, y: Array, edges: NDArray[np.intp]) -> NDArray[np.intp]:
    """Index of the first extreme value in each part, from one edge to the next."""
    value = extreme.reduceat(y, edges)
    part = np.repeat(np.arange(len(edges)), np.diff(np.append(edges, len(y))))
    places = np.flatnonzero(y == value[part])
    return places[np.unique(part[places], return_index=True)[1]]
