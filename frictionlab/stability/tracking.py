"""Modes followed along a path of parameter values, through crossings, veerings and coalescence.

Two neighbours on the path are compared by the products of left vectors of one with right vectors of the
other.  For equal matrices that is the unit matrix, however close their eigenvalues are, so it tells modes
apart where the usual modal assurance criterion (right vectors with right vectors) sees two alike.  Where
the answer is not clear the path is halved, so that it does not depend on the steps the user chose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from .spectra import eigensystem

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
SAME, OTHER = 0.7, 0.4  # products of unit vectors that count as one mode, and as two
HALVINGS = 24


@dataclass(frozen=True, eq=False)
class Modes:
    """One eigenvalue of every mode at N points of the path: of a conjugate pair that with Im > 0.

    Of an overdamped mode's two real eigenvalues it is the less stable one.

    Parameters
    ----------
    at : array (N,)
        The points.
    values : complex array (N, k)
    right : complex array (N, m, k)
        Vectors of length 1.
    left : complex array (N, k, m)
        Left vectors, left @ right = 1.
    """

    at: Array
    values: ComplexArray
    right: ComplexArray
    left: ComplexArray

    def __getitem__(self, chosen: Any) -> Modes:
        return Modes(self.at[chosen], self.values[chosen], self.right[chosen], self.left[chosen])

    def permuted(self, order: NDArray[np.intp]) -> Modes:
        """With the modes of each point in another order (N, k)."""
        return Modes(
            self.at,
            np.take_along_axis(self.values, order, axis=1),
            np.take_along_axis(self.right, order[:, None, :], axis=2),
            np.take_along_axis(self.left, order[:, :, None], axis=1),
        )


def modes(at: Array, matrices: Array) -> Modes:
    """The modes of state matrices (N, m, m), by ascending frequency; NaN where a matrix is not finite."""
    known = np.isfinite(matrices).all(axis=(1, 2))
    m, k = matrices.shape[1], (matrices.shape[1] + 1) // 2
    found = Modes(at, *(np.full((len(at), *shape), np.nan, complex) for shape in ((k,), (m, k), (k, m))))
    if known.any():
        values, right = eigensystem(matrices[known])
        order = _upper(values, k)
        found.values[known] = np.take_along_axis(values, order, axis=1)
        found.right[known] = np.take_along_axis(right, order[:, None, :], axis=2)
        found.left[known] = np.take_along_axis(_inverse(right), order[:, :, None], axis=1)
    return found


def _upper(values: ComplexArray, k: int) -> NDArray[np.intp]:
    """Indices (N, k) of Im > 0, then of the largest real ones; by ascending frequency."""
    kind = np.where(values.imag > 0, 0, np.where(values.imag == 0, 1, 2))
    chosen = np.lexsort((-values.real, kind), axis=-1)[:, :k]
    frequency = np.take_along_axis(values.imag, chosen, axis=1)
    return np.take_along_axis(chosen, np.argsort(frequency, axis=1, kind="stable"), axis=1)


def _inverse(vectors: ComplexArray) -> ComplexArray:
    # At a defective matrix the vectors are dependent; the left ones are then large, or without meaning.
    try:
        return np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(vectors)


def tracked(path: Modes, sample: Callable[[Array], Modes]) -> Modes:
    """The same points with each mode in one column throughout; `sample` gives modes at further points."""
    steps = _matched(path[:-1], path[1:], sample, HALVINGS)
    order = np.empty(path.values.shape, dtype=np.intp)
    order[:1] = np.arange(path.values.shape[1])
    for before, after, step in zip(order, order[1:], steps):
        after[:] = step[before]
    return path.permuted(order)


def _matched(a: Modes, b: Modes, sample: Callable[[Array], Modes], depth: int) -> NDArray[np.intp]:
    """For each mode of `a` the index of the same mode of `b`, (N, k)."""
    overlap = np.abs(a.left @ b.right)
    found = overlap.argmax(axis=2)
    unclear = ~_clear(overlap, found) & np.isfinite(a.values[:, 0]) & np.isfinite(b.values[:, 0])
    found[np.isnan(overlap[:, 0, 0])] = np.arange(found.shape[1])
    if unclear.any() and depth:
        middle = sample(0.5 * (a.at[unclear] + b.at[unclear]))
        first = _matched(a[unclear], middle, sample, depth - 1)
        second = _matched(middle, b[unclear], sample, depth - 1)
        found[unclear] = np.take_along_axis(second, first, axis=1)
    elif unclear.any():  # an exact coalescence: the nearest eigenvalues, since the vectors are one
        found[unclear] = [_nearest(x, y) for x, y in zip(a.values[unclear], b.values[unclear])]
    return found


def _clear(overlap: Array, found: NDArray[np.intp]) -> NDArray[np.bool_]:
    same = np.take_along_axis(overlap, found[:, :, None], axis=2)
    others = overlap.copy()
    np.put_along_axis(others, found[:, :, None], 0.0, axis=2)
    one_each = (np.sort(found, axis=1) == np.arange(found.shape[1])).all(axis=1)
    return one_each & (same > SAME).all(axis=(1, 2)) & (others < OTHER).all(axis=(1, 2))


def _nearest(a: ComplexArray, b: ComplexArray) -> NDArray[np.intp]:
    return linear_sum_assignment(np.abs(a[:, None] - b[None, :]))[1]
