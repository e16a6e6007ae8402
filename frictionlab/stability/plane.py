"""Spectra over the unit square that stands for the range of two parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from .scan import growth
from .steady import Steady

Array = NDArray[np.float64]


class Plane:
    """Sorted spectra over the unit square, which stands for the range of two parameters."""

    def __init__(self, view: Steady, x: tuple[str, Array], y: tuple[str, Array]) -> None:
        self._view, self._axes = view, (x, y)

    def values(self, u: Array) -> Array:
        """The parameters (M, 2) at points (M, 2) of the square; by the grid's indices, so logarithmic grids
        are as good as even ones.  Beyond the square they are those at its edge.
        """
        columns = zip(u.T, self._axes)
        return np.stack(
            [np.interp(part * (len(grid) - 1), np.arange(len(grid)), grid) for part, (_, grid) in columns],
            axis=1,
        )

    def spectra(self, u: Array) -> Any:
        """Eigenvalues (M, m), the largest growth rate first."""
        at = self.values(u)
        return self._view.spectra({name: column for (name, _), column in zip(self._axes, at.T)})

    def rate(self, u: Array, level: Any) -> Array:
        """The `level`-th largest growth rate at points (M, 2)."""
        spectra = self.spectra(u)
        # Without damping stable growth rates are zero exactly: they count as negative.
        rates = np.where(spectra.real == 0, growth(spectra), spectra.real)
        return np.take_along_axis(rates, np.broadcast_to(level, len(rates))[:, None], axis=1)[:, 0]


def on_segment(plane: Plane, low: Array, high: Array, levels: Any) -> Array:
    """Where growth rates are zero between two points each, to rounding; NaN if they do not change sign."""

    def rate(share: Array, *rest: Array) -> Array:
        a, b, level = np.stack(rest[:2], axis=1), np.stack(rest[2:4], axis=1), rest[4].astype(int)
        return plane.rate(a + share[:, None] * (b - a), level)

    ends = (np.zeros(len(low)), np.ones(len(low)))
    found = find_root(rate, ends, args=(*low.T, *high.T, np.broadcast_to(levels, len(low))))
    share = np.where(found.success, found.x, np.nan)
    return low + share[:, None] * (high - low)
