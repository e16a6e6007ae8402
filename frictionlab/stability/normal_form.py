"""The normal form of a Hopf point, w' = (i omega + slope (p - p0)) w + cubic w |w|^2, x = x0 + 2 Re(w q).

Yu. A. Kuznetsov, "Elements of Applied Bifurcation Theory", 3rd ed., Springer, 2004; also his "Andronov-Hopf
bifurcation", Scholarpedia 1(10) (2006) 1858.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .multilinear import Point, along, along_parameter

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
ROUNDING = 1e-9  # what is below this share of its terms, or of the largest eigenvalue, counts as zero
DOUBLE = (
    1e-6  # eigenvalues nearer to each other than this share count as one: rounding parts a double one so far
)


class Pair(NamedTuple):
    """An eigenvalue i omega (rad/s), its right vector q of length 1, its left vector p with p q = 1."""

    omega: float
    right: ComplexArray
    left: ComplexArray


def critical_pair(matrix: Array, frequency: float) -> Pair | None:
    """The pair of that frequency (Hz); None if it is double, or another mode neither grows nor decays."""
    pairs: Any = np.linalg.eig(matrix.astype(complex))
    values, vectors = pairs.eigenvalues, pairs.eigenvectors
    k = int(np.argmin(np.abs(values - 2j * np.pi * frequency)))
    critical, right = values[k], vectors[:, k]
    others: Any = np.delete(values, [k, int(np.argmin(np.abs(values - critical.conjugate())))])
    neutral = np.abs(others.real).min(initial=np.inf) < ROUNDING * np.abs(values).max()
    if neutral or np.abs(others - critical).min(initial=np.inf) < DOUBLE * abs(critical):
        return None
    return Pair(float(critical.imag), right, _left(matrix, critical, right))


def _left(matrix: Array, value: complex, right: ComplexArray) -> ComplexArray:
    """The left vector, from a bordered system, which is regular for a simple eigenvalue."""
    m = len(right)
    bordered = np.zeros((m + 1, m + 1), dtype=complex)
    bordered[:m, :m] = matrix.T - value * np.eye(m)
    bordered[:m, m], bordered[m, :m] = right.conj(), right
    return np.linalg.solve(bordered, np.eye(m + 1)[m])[:m]


def cubic(at: Point, matrix: Array, pair: Pair) -> complex:
    """The coefficient of w |w|^2; its real part is exactly zero where it is zero to rounding."""
    omega, q, p = pair
    shift = -np.linalg.solve(matrix, along(at, q, q.conj()))
    second = np.linalg.solve(2j * omega * np.eye(len(q)) - matrix, along(at, q, q))
    terms = [along(at, q, q, q.conj()), 2 * along(at, q, shift), along(at, q.conj(), second)]
    found = 0.5 * complex(p @ sum(terms))
    size = 0.5 * float(sum(np.abs(p) @ np.abs(term) for term in terms))
    return found if abs(found.real) > ROUNDING * size else complex(0.0, found.imag)


def slope(at: Point, matrix: Array, pair: Pair, parameter: str) -> complex:
    """d(eigenvalue)/d(parameter), with the equilibrium as it moves."""
    _, q, p = pair
    moved = -np.linalg.solve(matrix, along_parameter(at, parameter))
    return complex(p @ (along_parameter(at, parameter, q) + along(at, moved, q)))
