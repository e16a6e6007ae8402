"""Long curves in few points: the smallest and the largest value in each pixel's worth of samples."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BINS = 400  # about the pixels that a panel is wide


def envelope(x: Any, y: Any, bins: int = BINS) -> tuple[Array, Array]:
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
    extremes = np.concatenate([_places(np.minimum, y, edges), _places(np.maximum, y, edges)])
    kept = np.unique(np.append(extremes, [0, len(y) - 1]))
    return x[kept], y[kept]


def _places(extreme: Any, y: Array, edges: NDArray[np.intp]) -> NDArray[np.intp]:
    """Where in each part (from one edge to the next) its extreme value stands first."""
    value = extreme.reduceat(y, edges)
    part = np.repeat(np.arange(len(edges)), np.diff(np.append(edges, len(y))))
    places = np.flatnonzero(y == value[part])
    return places[np.unique(part[places], return_index=True)[1]]
