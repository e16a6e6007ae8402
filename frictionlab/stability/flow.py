"""The flow of one mode as functions of arrays, with its derivatives by the state and by all parameters.

With x' = f(x, p) and its Jacobian A = f_x at the equilibrium f = 0,

    dx/dp = -A^-1 f_p,    d(lambda)/dp = l (f_xp + f_xx dx/dp) r,

for the right vector r and the left vector l of a simple eigenvalue, l r = 1.  The second term needs one
solution of A^T w = l f_xx r, however many parameters there are (the adjoint equation).  All derivatives are
those of the flow's formulas.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.tape.formulas import Formulas
from frictionlab.tape.intervals import Interval

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
# Of the largest singular value: below it the equilibrium is no function of the parameters.
SINGULAR_RTOL = 1e-13


class Entries(NamedTuple):
    """The entries of a matrix of derivatives that are not zero everywhere: where they are, and their values.

    Parameters
    ----------
    shape : (rows, columns)
    places : sequence of (row, column)
    formulas : Formulas
        Their values, as functions of all states, then all parameters.
    """

    shape: tuple[int, int]
    places: Sequence[tuple[int, int]]
    formulas: Formulas

    def at(self, x: Any, values: Sequence[Any]) -> Array:
        """The matrix (..., rows, columns) at states `x` (m, ...)."""
        matrix = np.zeros((*self.shape, *np.shape(x[0])))
        for (row, column), entry in zip(self.places, self.formulas.arrays(*x, *values), strict=True):
            matrix[row, column] = entry
        return np.moveaxis(matrix, (0, 1), (-2, -1))

    def bounds(self, x: Any, values: Sequence[Any]) -> dict[tuple[int, int], Any]:
        """The entries by their places, where states are numbers or intervals."""
        return dict(zip(self.places, self.formulas.arrays(*x, *values), strict=True))


@dataclass(frozen=True, eq=False)
class Flow:
    """x' = f(x, p) with its Jacobian, for N states and N values of the parameters.

    Parameters
    ----------
    parameters : tuple of str
    rates : Formulas
        f (m,), functions of the states, then the parameters.
    margins : Formulas
        Positive where the mode can last: its event functions, its normal force.
    """

    parameters: tuple[str, ...]
    rates: Formulas
    margins: Formulas

    @property
    def size(self) -> int:
        """How many states there are."""
        return len(self.rates.outputs)

    @cached_property
    def derivative(self) -> Entries:
        """The Jacobian by the states."""
        return self._entries(range(self.size))

    @cached_property
    def by_parameter(self) -> Entries:
        """f_p."""
        return self._entries(range(self.size, self.rates.tape.inputs))

    def _entries(self, inputs: range) -> Entries:
        places, formulas = self.rates.jacobian(inputs)
        moved = [(row, column - inputs.start) for row, column in places]
        return Entries((self.size, len(inputs)), moved, formulas)

    @cached_property
    def free(self) -> list[int]:
        """The states whose rates depend on no state."""
        return sorted({*range(self.size)} - {row for row, _ in self.derivative.places})

    @cached_property
    def unseen(self) -> list[int]:
        """The states on which no rate depends."""
        return sorted(
            {*range(self.size)} - {column for _, column in self.derivative.places} - {*self.stepped}
        )

    @cached_property
    def stepped(self) -> list[int]:
        """The states at which functions jump, as sign(x) does: no derivative tells of these steps."""
        return sorted(frozenset().union(*self.rates.step_dependences) & {*range(self.size)})

    @property
    def linear(self) -> bool:
        """Whether the Jacobian is the same at every state, and there are no steps."""
        return not self.nonlinear

    @cached_property
    def nonlinear(self) -> list[int]:
        """The states that enter nonlinearly.

        Their columns of the Jacobian are not the same at every state, or steps depend on them.
        """
        states = frozenset(range(self.size))
        known = zip(self.derivative.places, self.derivative.formulas.dependences, strict=True)
        return sorted({column for (_, column), inputs in known if inputs & states} | {*self.stepped})

    @cached_property
    def _nonlinear_entries(self) -> Entries:
        columns = {j: k for k, j in enumerate(self.nonlinear)}
        known = zip(self.derivative.places, self.derivative.formulas.outputs, strict=True)
        chosen = [((i, columns[j]), slot) for (i, j), slot in known if j in columns]
        formulas = Formulas(self.derivative.formulas.tape, tuple(slot for _, slot in chosen))
        return Entries((self.size, len(columns)), [place for place, _ in chosen], formulas)

    def rhs(self, x: Any, values: Sequence[Any]) -> Array:
        """x' (m, ...) at states `x` (m, ...); parameters are numbers or arrays."""
        return _stacked(self.rates.arrays(*x, *values), np.shape(x[0]))

    def bounds(self, x: Sequence[Any], values: Sequence[Any]) -> Sequence[Any]:
        """x' where states are numbers or intervals."""
        return self.rates.arrays(*x, *values)

    def slopes(self, x: Sequence[Any], values: Sequence[Any]) -> dict[tuple[int, int], Any]:
        """Bounds of the Jacobian in boxes, by places; infinite where a rate may jump."""
        entries = self.derivative.bounds(x, values)
        for (row, column), jumps in self.rates.jumps(*x, *values).items():
            if column < self.size:
                wide = Interval(np.where(jumps, -np.inf, 0.0), np.where(jumps, np.inf, 0.0))
                entries[row, column] = entries.get((row, column), 0.0) + wide
        return entries

    def margin(self, x: Any, values: Sequence[Any]) -> Array:
        """The least of the margins, (...)."""
        if not self.margins.outputs:
            return np.full(np.shape(x[0]), np.inf)
        return _stacked(self.margins.arrays(*x, *values), np.shape(x[0])).min(axis=0)

    def jacobian(self, x: Any, values: Sequence[Any]) -> Array:
        """d x'/d x as (..., m, m)."""
        return self.derivative.at(x, values)

    def nonlinear_columns(self, x: Array, values: Sequence[Any]) -> Array:
        """The columns `nonlinear` of the Jacobian as (N, m, k), at states (m, N)."""
        return self._nonlinear_entries.at(x, values)


def _stacked(parts: Sequence[Any], shape: tuple[int, ...]) -> Array:
    values = np.empty((len(parts), *shape))
    for i, part in enumerate(parts):
        values[i, ...] = part
    return values


def _slopes_of_product(flow: Flow) -> Entries:
    """The derivatives of A r by all states and parameters; the components of r are further inputs."""
    places, formulas = flow.rates.along(range(flow.size)).jacobian(range(flow.rates.tape.inputs))
    return Entries((flow.size, flow.rates.tape.inputs), places, formulas)


class EquilibriumDerivatives(NamedTuple):
    """An equilibrium with the derivatives of its flow by the state and by all parameters.

    Parameters
    ----------
    flow : Flow
    x : array (m,)
    values : sequence of float
        The parameters.
    matrix : array (m, m)
        The Jacobian A.
    by_parameter : array (m, P)
        f_p.
    """

    flow: Flow
    x: Array
    values: Sequence[float]
    matrix: Array
    by_parameter: Array

    def state(self) -> Array:
        """dx/dp (m, P).

        Raises
        ------
        ValueError
            Where A is singular: the equilibrium ends there, or is one of a line of equilibria.
        """
        return -solve_regular(self.matrix, self.by_parameter)

    def slopes_of_product(self, right: Any) -> ComplexArray:
        """The derivatives (m, m + P) of A r by the state and the parameters, with r (m,) held."""
        known = _slopes_of_product(self.flow)
        slopes: Any = np.zeros(known.shape, dtype=complex)
        for place, entry in known.bounds(self.x, [*self.values, *right]).items():
            slopes[place] = entry
        return slopes

    def bilinear(self, left: Any, right: Any) -> ComplexArray:
        """l (dA/dp) r (P,), including the shift of the equilibrium."""
        slopes, m = left @ self.slopes_of_product(right), len(self.x)
        force, total = slopes[:m], slopes[m:]
        return total - solve_regular(self.matrix.T, force) @ self.by_parameter if force.any() else total


def equilibrium_derivatives(flow: Flow, x: Array, values: Sequence[float]) -> EquilibriumDerivatives:
    """The derivatives at an equilibrium (m,)."""
    by_parameter = flow.by_parameter.at(x, values)
    return EquilibriumDerivatives(flow, x, values, flow.jacobian(x, values), by_parameter)


def solve_regular(matrix: Any, right: Any) -> Any:
    """The solution of a linear system with a state matrix.

    Raises
    ------
    ValueError
        Where the matrix is singular, to rounding.
    """
    # Rows and columns are scaled by their size, as state matrices have stiffnesses beside ones.
    rows = 1.0 / np.maximum(np.abs(matrix).max(axis=1), np.finfo(float).tiny)
    columns = 1.0 / np.maximum(np.abs(rows[:, None] * matrix).max(axis=0), np.finfo(float).tiny)
    scaled = rows[:, None] * matrix * columns
    sizes = np.linalg.svd(scaled, compute_uv=False)
    if sizes[-1] < SINGULAR_RTOL * sizes[0]:
        raise ValueError(
            "the equilibrium must depend smoothly on the parameters to have derivatives, got one where the "
            "state matrix is singular: take another value"
        )
    return columns.reshape(-1, *[1] * (np.ndim(right) - 1)) * np.linalg.solve(
        scaled, rows.reshape(-1, *[1] * (np.ndim(right) - 1)) * right
    )


class NullVectors(NamedTuple):
    """Left and right vectors (m,) of an eigenvalue, of length 1 after scaling; `product` is l r."""

    left: Any
    right: Any
    product: complex


def null_vectors(matrix: Array, value: complex) -> NullVectors:
    """The vectors of the eigenvalue nearest to a value, also where two coalesce and l r = 0.

    They are the last singular vectors of A - lambda 1, in units that give velocities the size of coordinates.
    """
    n, odd = divmod(len(matrix), 2)
    size = float(np.sqrt(np.linalg.norm(matrix, 2))) or 1.0
    units = np.ones(len(matrix)) if odd else np.repeat([1.0, size], n)
    scaled = matrix * units / units[:, None]
    shifted = scaled - value * np.eye(len(matrix))
    u, _, vh = np.linalg.svd(shifted)
    left, right = u[:, -1].conj(), vh[-1].conj()
    return NullVectors(left / units, right * units, complex(left @ right))
