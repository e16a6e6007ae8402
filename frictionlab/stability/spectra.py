"""Eigenvalues and vectors of many state matrices at once; exact zeros where there is no damping."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating[Any, Any]]


def eigenvalues_of(matrices: Array) -> ComplexArray:
    """Eigenvalues (N, m) of state matrices (N, m, m)."""
    if _undamped(matrices):
        roots = np.sqrt(np.linalg.eigvals(_stiffness(matrices)).astype(complex))
        return np.concatenate([roots, -roots], axis=-1)
    return np.linalg.eigvals(matrices).astype(complex)


def eigensystem(matrices: Array) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues (N, m) and vectors of length 1 as columns (N, m, m)."""
    if not _undamped(matrices):
        pairs: Any = np.linalg.eig(matrices)
        return pairs.eigenvalues.astype(complex), pairs.eigenvectors.astype(complex)
    squares: Any = np.linalg.eig(_stiffness(matrices))
    roots, shapes = np.sqrt(squares.eigenvalues.astype(complex)), squares.eigenvectors
    values = np.concatenate([roots, -roots], axis=-1)
    coordinates = np.concatenate([shapes, shapes], axis=-1)
    vectors = np.concatenate([coordinates, coordinates * values[:, None, :]], axis=-2)
    return values, vectors / np.linalg.norm(vectors, axis=-2, keepdims=True)


def _undamped(matrices: Array) -> bool:
    """Whether all are those of q'' = -K q: squares of eigenvalues are then real until modes coalesce."""
    n, odd = divmod(matrices.shape[-1], 2)
    unit = np.eye(n, 2 * n, n)
    return not odd and not matrices[:, n:, n:].any() and bool((matrices[:, :n] == unit).all())


def _stiffness(matrices: Array) -> Array:
    n = matrices.shape[-1] // 2
    return matrices[:, n:, :n]
