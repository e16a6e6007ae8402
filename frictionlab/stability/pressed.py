"""The equilibrium with F_N > 0 and the smallest gap, for many values of the parameters at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .polynomial import IDENTITY, Polynomial
from .statics import Statics, residual

Array = NDArray[np.float64]
NEARLY_REAL = 1e-4  # a double root comes out of the eigenvalues as a pair, some 1e-8 off the real axis
RESIDUAL = 1e-9
NEWTON = 4
GRID, FINEST, REACH, HALVINGS = 401, 1e-9, 3.0, 60


def pressed_gap(statics: Statics, values: Sequence[Any], count: int) -> Array:
    """Gaps (count,) in m; NaN where there is no equilibrium with F_N > 0."""
    excess = excess_polynomial(statics, values)
    with np.errstate(all="ignore"):
        if excess is None:
            gaps = _scanned(statics, values, count)
        else:
            gaps = _candidates(statics, values, np.broadcast_to(excess, (len(excess), count)))
        solved = residual(statics, statics.coordinates(gaps, *values), values) < RESIDUAL
    least = np.where(solved & (gaps > 0) & (statics.forces(gaps, *values)[0] > 0), gaps, np.inf).min(axis=0)
    return np.where(np.isfinite(least), least, np.nan)


def excess_polynomial(statics: Statics, values: Sequence[Any]) -> Array | None:
    """Coefficients of gap(q(g)) - g, of degree 9 at most for Eq. (2); None where a law is no polynomial."""
    try:
        excess = statics.excess(IDENTITY, *values)
    except (TypeError, ValueError, AttributeError):  # sqrt, a broken power, exp or a comparison in a law
        return None
    return excess.coefficients if isinstance(excess, Polynomial) else None


def _candidates(statics: Statics, values: Sequence[Any], excess: Array) -> Array:
    """Nearly real roots (some, N), made exact by Newton's method on the composed equation."""
    roots = _roots(excess)
    real = np.abs(roots.imag) <= NEARLY_REAL * np.abs(roots.real)
    pressed = (roots.real > 0) & (statics.forces(roots.real, *values)[0] > 0)
    gaps = np.sort(np.where(real & pressed, roots.real, np.nan), axis=0)
    gaps = gaps[: int(np.isfinite(gaps).sum(axis=0).max(initial=1))]  # NaN comes last
    return polished(statics, values, gaps)


def polished(statics: Statics, values: Sequence[Any], gaps: Array) -> Array:
    """Newton's method on the composed equation, which does not suffer from the polynomial's cancellation."""
    left = np.abs(statics.excess(gaps, *values))
    for _ in range(NEWTON):
        trial = gaps - statics.excess(gaps, *values) / statics.slope(gaps, *values)
        rest = np.abs(statics.excess(trial, *values))
        gaps, left = np.where(rest < left, trial, gaps), np.fmin(rest, left)
    return gaps


def _roots(coefficients: Array) -> NDArray[np.complex128]:
    """All roots (degree, N).  Their reciprocals are eigenvalues, so a leading coefficient may vanish."""
    degree = len(coefficients) - 1
    # Without a preload the gap is a factor: divided out, the other roots are left.
    coefficients = np.where(coefficients[0] == 0, np.roll(coefficients, -1, axis=0), coefficients)
    companion = np.zeros((coefficients.shape[1], degree, degree))
    companion[:, range(1, degree), range(degree - 1)] = 1.0
    with np.errstate(all="ignore"):
        # In units of the unloaded gap, which is the constant term.
        scale = np.abs(coefficients[0]) ** np.arange(1, degree + 1)[:, None]
        companion[:, 0] = -(coefficients[1:] * scale / coefficients[0]).T
        broken = ~np.isfinite(companion[:, 0]).all(axis=1)
        companion[broken] = np.eye(degree)
        found = np.abs(coefficients[0]) / np.linalg.eigvals(companion).astype(complex).T
    found[:, broken] = np.nan
    return found


def _scanned(statics: Statics, values: Sequence[Any], count: int) -> Array:
    """First root (1, count) seen as a change of sign on a grid, for laws that are no polynomials."""
    grid = np.geomspace(FINEST, 1.0, GRID)[:, None] * np.broadcast_to(reach(statics, values), (count,))
    signs = np.sign(np.broadcast_to(statics.excess(grid, *values), grid.shape))
    turns = (signs[:-1] * signs[1:] <= 0) & (statics.forces(grid[1:], *values)[0] > 0)
    first, columns = np.argmax(turns, axis=0), np.arange(count)
    low, high, sign = grid[first, columns], grid[first + 1, columns], signs[first, columns]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = np.sign(statics.excess(middle, *values)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.where(turns.any(axis=0), 0.5 * (low + high), np.nan)[None]


def reach(statics: Statics, values: Sequence[Any]) -> Any:
    """How far gaps are searched (m): some times that of the unloaded contact; 1 m without a preload."""
    length = REACH * np.abs(statics.excess(0.0, *values))
    return np.where(length == 0, 1.0, length)
