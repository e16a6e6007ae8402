"""Roots of a scalar function by their change of sign."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

# Full relative precision however small the root: only RTOL ends the search.
XTOL, RTOL, STEPS = 1e-300, 8.9e-16, 5000


def bracketed(function: Callable[[float], float], low: float, high: float) -> float | None:
    """A root in [low, high] if the function vanishes at an end or has different signs there, else None."""
    at_low, at_high = function(low), function(high)
    if at_low == 0.0 or at_high == 0.0:
        return low if at_low == 0.0 else high
    if np.sign(at_low) == np.sign(at_high):
        return None
    solver: Any = brentq  # its stub asks for numpy's floats
    root = solver(function, low, high, xtol=XTOL, rtol=RTOL, maxiter=STEPS)
    return float(root)


def scanned(function: Callable[[Any], Any], reach: float, points: int = 4001) -> list[float]:
    """Roots in [-reach, reach] seen as changes of sign on a grid; two that are closer than it are missed.

    `function` takes arrays.  Where it changes its sign through a pole it is larger than on both sides.
    """
    grid = np.linspace(-reach, reach, points)
    with np.errstate(all="ignore"):  # where a law is not defined there is no root
        values = np.broadcast_to(function(grid), grid.shape)
    sizes, signs = np.abs(values), np.sign(values)
    ends = np.flatnonzero(signs[:-1] * signs[1:] <= 0)
    found = [(bracketed(function, float(grid[i]), float(grid[i + 1])), sizes[i : i + 2].max()) for i in ends]
    return sorted({root for root, size in found if root is not None and abs(function(root)) <= size})
