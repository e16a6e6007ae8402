"""Coupled masses, as of finite elements: M^-1 times forces, by arithmetic with numbers.

Each row of M^-1 has as many entries as there are coordinates, so sympy would multiply and sort millions of
terms.  Where M is a matrix of numbers, times one expression of the parameters, forces are written as numbers
times expressions (:mod:`frictionlab.automaton.expressions`), and only the numbers are multiplied.

Sums are added up one term after the other, so that the results are the same on every processor; those of a
library of linear algebra are not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton.expressions import combinations_of, exact_number, expressions_of

Array = NDArray[np.float64]
# A pivot that is a smaller share of its mass is a rounding error: some motion has no kinetic energy.
LEAST_PIVOT = 1e-13


@dataclass(frozen=True, eq=False)
class CoupledMasses:
    """The inverse of a mass matrix, M^-1 = `inverse` / `scale`.

    Parameters
    ----------
    inverse : array (n, n)
    scale : Expr
        The common factor of all entries of M, such as a density.
    """

    inverse: Array
    scale: Any

    def accelerations(self, forces: Sequence[Any], states: Sequence[Any]) -> list[Any]:
        """M^-1 times forces (n,)."""
        known = combinations_of(forces, states)
        return self.divided(product(self.inverse, known.matrix), known.expressions)

    def divided(self, numbers: Array, expressions: Sequence[Any]) -> list[Any]:
        """Numbers (n, expressions) times expressions, over the masses' scale."""
        return expressions_of(numbers, [one / self.scale for one in expressions])

    def times(self, direction: Array) -> Array:
        """`inverse` times a direction (n,)."""
        return product(self.inverse, direction[:, None])[:, 0]

    def softness(self, direction: Array) -> float:
        """w^T `inverse` w."""
        return float(product(direction[None], self.times(direction)[:, None])[0, 0])


@dataclass(frozen=True, eq=False)
class HeldVelocities:
    """Velocities g_i . q' + rest_i of coupled masses, held at zero by forces along `signs`_i g_i.

    Parameters
    ----------
    masses : CoupledMasses
    rows : array (held, n)
        The g_i.
    signs : array (held,)
        1 or -1.
    rates : tuple of Expr
        Time derivatives of the rest_i, m/s^2.
    """

    masses: CoupledMasses
    rows: Array
    signs: Array
    rates: tuple[Any, ...]

    def solve(self, free: Sequence[Any], states: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """Accelerations under the forces `free` (n,) and the holding forces; and the latter, N."""
        known = combinations_of([*free, *(self.masses.scale * rate for rate in self.rates)], states)
        forces, rates = known.matrix[: len(free)], known.matrix[len(free) :]
        reach = product(self.rows, self.masses.inverse)
        softness = product(reach, self.rows.T)
        holding = -product(inverse_of(softness), product(reach, forces) + rates)
        pushed = product(self.masses.inverse, forces + product(self.rows.T, holding))
        accelerations = self.masses.divided(pushed, known.expressions)
        return self._with_held_velocities(accelerations), expressions_of(
            self.signs[:, None] * holding, known.expressions
        )

    def _with_held_velocities(self, accelerations: list[Any]) -> list[Any]:
        """The accelerations, with one for each held velocity solved from the others.

        So the velocity keeps its value to the last bit.
        """
        adjusted = list(accelerations)
        for row, rate in zip(self.rows, self.rates, strict=True):
            pivot = pivot_of(row)
            adjusted[pivot] = solved_for(row, pivot, adjusted, rate)
        return adjusted


def held_velocities(
    masses: CoupledMasses, rows: Sequence[Any], along: Sequence[Any], rates: Sequence[Any]
) -> HeldVelocities | None:
    """Velocities with gradients `rows` that are held by forces in the directions `along`; or None.

    None where these are not numbers, where a direction is neither a row itself nor minus that, or where a
    coordinate is in several rows.
    """
    numbers = numbers_of([entry for row in rows for entry in row])
    directions = numbers_of([entry for one in along for entry in one])
    if numbers is None or directions is None:
        return None
    numbers, directions = (each.reshape(len(rows), -1) for each in (numbers, directions))
    signs = np.where((directions == numbers).all(axis=1), 1.0, -1.0)
    if (directions != signs[:, None] * numbers).any() or ((numbers != 0).sum(axis=0) > 1).any():
        return None
    return HeldVelocities(masses, numbers, signs, tuple(rates))


def pivot_of(row: Array) -> int:
    """Index of the largest |g_i|: where g . q' is held, this coordinate follows from the others."""
    return int(np.argmax(np.abs(row)))


def solved_for(row: Array, pivot: int, values: Sequence[Any], rest: Any) -> Any:
    """x_p, the pivot, from (sum of g_i x_i) + rest = 0."""
    others = [i for i in np.flatnonzero(row).tolist() if i != pivot]
    shares = [exact_number(-row[i] / row[pivot]) * values[i] for i in others]
    return sum(shares, -rest * exact_number(1.0 / row[pivot]))


def coupled_masses(mass: Any) -> CoupledMasses | None:
    """The inverse of a mass matrix of numbers times one expression; None for any other matrix.

    Raises
    ------
    ValueError
        If some motion has no kinetic energy.
    """
    entries = {place: entry.as_coeff_Mul() for place, entry in mass.todok().items()}
    scales = {rest for _, rest in entries.values()}
    if len(scales) != 1:
        return None
    numbers = np.zeros(mass.shape)
    for place, (number, _) in entries.items():
        numbers[place] = float(number)
    return CoupledMasses(inverse_of(numbers), scales.pop())


def numbers_of(entries: Sequence[Any]) -> Array | None:
    """The entries as an array; None where one is not a number."""
    return np.array(entries, dtype=float) if all(one.is_Number for one in entries) else None


def product(one: Array, other: Array) -> Array:
    """The product of two matrices; sums run from the first term to the last."""
    total = np.zeros((len(one), other.shape[1]))
    for column, row in zip(one.T, other, strict=True):
        total += column[:, None] * row
    return total


def inverse_of(matrix: Array) -> Array:
    """The inverse of a positive definite matrix, by Gauss-Jordan elimination with the diagonal scaled to 1.

    Raises
    ------
    ValueError
        Where it is singular.
    """
    n, diagonal = len(matrix), np.diag(matrix)
    if not (diagonal > 0).all():
        raise _no_energy()
    size = np.sqrt(diagonal)
    both = np.hstack([matrix / size[:, None] / size, np.eye(n)])
    for i in range(n):
        if not both[i, i] > LEAST_PIVOT:
            raise _no_energy()
        both[i] /= both[i, i]
        below = both[:, i].copy()
        below[i] = 0.0
        both -= below[:, None] * both[i]
    return both[:, n:] / size[:, None] / size


def _no_energy() -> ValueError:
    return ValueError(
        "the kinetic energy must be positive whatever the velocities, and is zero for some: give each "
        "coordinate a mass"
    )
