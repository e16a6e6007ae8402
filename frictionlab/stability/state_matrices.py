"""Eigenvalues, vectors and growth rates of stacks of state matrices, and which of them are zero but for
rounding.

Without damping the squares of the eigenvalues are computed, so that growth rates are exact zeros until two
modes coalesce.  Single growth rates are zero where the backward error of the eigenvalue problem could explain
them: computed eigenvalues of A are exact ones of A + E, where |E| is about m eps |A|. Source: Golub and Van
Loan, Matrix Computations, 4th ed., sections 7.2 and 7.5.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating[Any, Any]]

SMALLEST_EIGENVALUE = 1e-280  # where all eigenvalues are zero
# Growth rates below this share of the largest eigenvalue count as zero: no damping at all.
NEUTRAL_RTOL = 1e-10
MACHINE_EPSILON = float(np.finfo(float).eps)  # spacing of floats at 1
BALANCING_GAIN = 0.95  # factors that leave a larger share of the norm of a row and a column are left out
BACKWARD_ERROR = 4.0 * MACHINE_EPSILON  # of both, with a factor of two to spare


def eigenvalues_of_matrices(matrices: Array) -> ComplexArray:
    """Eigenvalues (N, m) of state matrices (N, m, m)."""
    if _is_undamped(matrices):
        roots = np.sqrt(np.linalg.eigvals(_stiffness(matrices)).astype(complex))
        return np.concatenate([roots, -roots], axis=-1)
    return np.linalg.eigvals(matrices).astype(complex)


def eigenpairs_of_matrices(matrices: Array) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues (N, m) and vectors of length 1 as columns (N, m, m)."""
    if not _is_undamped(matrices):
        pairs: Any = np.linalg.eig(matrices)
        return pairs.eigenvalues.astype(complex), pairs.eigenvectors.astype(complex)
    squares: Any = np.linalg.eig(_stiffness(matrices))
    roots, shapes = np.sqrt(squares.eigenvalues.astype(complex)), squares.eigenvectors
    values = np.concatenate([roots, -roots], axis=-1)
    coordinates = np.concatenate([shapes, shapes], axis=-1)
    vectors = np.concatenate([coordinates, coordinates * values[:, None, :]], axis=-2)
    return values, vectors / np.linalg.norm(vectors, axis=-2, keepdims=True)


def _is_undamped(matrices: Array) -> bool:
    """Whether all are those of q'' = -K q: squares of eigenvalues are then real until modes coalesce."""
    n, odd = divmod(matrices.shape[-1], 2)
    unit = np.eye(n, 2 * n, n)
    return not odd and not matrices[:, n:, n:].any() and bool((matrices[:, :n] == unit).all())


def _stiffness(matrices: Array) -> Array:
    n = matrices.shape[-1] // 2
    return matrices[:, n:, :n]


def growth_rates(spectra: ComplexArray) -> Array:
    """Growth rates; those that are zero but for rounding are a little below zero."""
    bound = NEUTRAL_RTOL * np.abs(spectra).max(axis=-1, keepdims=True, initial=SMALLEST_EIGENVALUE)
    return np.where(np.abs(spectra.real) < bound, -bound, spectra.real)


def unstable_pairs(spectra: ComplexArray) -> NDArray[np.int_]:
    """Number of growing pairs of eigenvalues; real ones count two as one, and one alone as one."""
    return ((growth_rates(spectra) > 0).sum(axis=-1) + 1) // 2


def is_neutral(matrix: Array, values: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Whether the real part of each eigenvalue (m,) of a real matrix (m, m) is nothing but rounding.

    To first order E moves an eigenvalue by |E| times its condition number.  Where two coalesce that number
    is infinite and tells nothing, as at critical damping: an E is required as well that puts an eigenvalue on
    the imaginary axis at this frequency.  Both are evaluated for the balanced matrix.
    """
    scaled = balanced(matrix)
    error = len(matrix) * BACKWARD_ERROR * np.linalg.norm(scaled, 2)
    pairs: Any = np.linalg.eig(scaled)
    known, right = pairs.eigenvalues, pairs.eigenvectors
    nearest = np.abs(values[:, None] - known).argmin(axis=1)
    neutral = np.abs(values.real) * _cosines(right)[nearest] <= error
    for i in np.flatnonzero(neutral):  # one by one: matrices of many states are large
        on_axis = scaled - 1j * values.imag[i] * np.eye(len(matrix))
        # The least singular value is below what is left of any vector of length 1, which takes less time.
        left_over = np.linalg.norm(on_axis @ right[:, nearest[i]])
        neutral[i] = left_over <= error or np.linalg.svd(on_axis, compute_uv=False)[-1] <= error
    return neutral


def _cosines(right: ComplexArray) -> Array:
    """|w v| (m,) of the left and right vectors w, v of length 1: inverse condition numbers of eigenvalues.

    `right` holds those as columns; where eigenvalues coalesce there is no basis, and w v = 0.
    """
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return np.zeros(len(right))
    with np.errstate(over="ignore", invalid="ignore"):  # next to no basis
        return np.nan_to_num(1.0 / np.linalg.norm(left, axis=1))


def balanced(matrix: Array) -> Array:
    """D^-1 A D with powers of two in the diagonal D that make norms of rows and columns alike.

    That changes no eigenvalue and no digit.  R. James, J. Langou, B. R. Lowery, "On matrix balancing and
    eigenvector computation", arXiv:1401.5766 (2014), algorithm 3, which LAPACK's gebal is.
    """
    found = np.array(matrix, dtype=float)
    unchanged = False
    while not unchanged:
        unchanged = True
        for i in range(len(found)):
            column, row = np.linalg.norm(found[:, i]), np.linalg.norm(found[i])
            if not (column and row and np.isfinite(column + row)):
                continue
            power = 2.0 ** np.round(0.5 * np.log2(row / column))
            if np.hypot(column * power, row / power) < BALANCING_GAIN * np.hypot(column, row):
                unchanged = False
                found[:, i] *= power
                found[i] /= power
    return found
