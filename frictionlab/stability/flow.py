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
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.state_matrices import solve_regular
from frictionlab.tape.formulas import Formulas
from frictionlab.tape.intervals import Interval

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


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
        own_places = [(row, column - inputs.start) for row, column in places]
        return Entries((self.size, len(inputs)), own_places, formulas)

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
        entries = zip(self.derivative.places, self.derivative.formulas.dependences, strict=True)
        return sorted({column for (_, column), inputs in entries if inputs & states} | {*self.stepped})

    @cached_property
    def _nonlinear_entries(self) -> Entries:
        columns = {j: k for k, j in enumerate(self.nonlinear)}
        entries = zip(self.derivative.places, self.derivative.formulas.outputs, strict=True)
        bent = [((i, columns[j]), slot) for (i, j), slot in entries if j in columns]
        formulas = Formulas(self.derivative.formulas.tape, tuple(slot for _, slot in bent))
        return Entries((self.size, len(columns)), [place for place, _ in bent], formulas)

    def rhs(self, x: Any, values: Sequence[Any]) -> Array:
        """x' (m, ...) at states `x` (m, ...); parameters are numbers or arrays."""
        return _stacked(self.rates.arrays(*x, *values), np.shape(x[0]))

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


@dataclass(frozen=True, eq=False)
class EquilibriumDerivatives:
    """An equilibrium with the derivatives of its flow by the state and by all parameters.

    Parameters
    ----------
    flow : Flow
    x : array (m,)
    values : sequence of float
        The parameters.
    """

    flow: Flow
    x: Array
    values: Sequence[float]

    @cached_property
    def matrix(self) -> Array:
        """The Jacobian A (m, m)."""
        return self.flow.jacobian(self.x, self.values)

    @cached_property
    def by_parameter(self) -> Array:
        """f_p (m, P)."""
        return self.flow.by_parameter.at(self.x, self.values)

    def state(self) -> Array:
        """dx/dp (m, P).

        Raises
        ------
        ValueError
            Where A is singular: the equilibrium ends there, or is one of a line of equilibria.
        """
        return -solve_regular(self.matrix, self.by_parameter)

    def along(self, functions: Formulas, *directions: Any) -> NDArray[Any]:
        """The derivative of functions (k,) along each of some directions (m,), real or complex; without any
        their values."""
        for _ in directions:
            functions = functions.along(range(self.flow.size))
        return np.array(functions.arrays(*self.x, *self.values, *chain.from_iterable(directions)))

    def slopes_of_product(self, right: Any) -> ComplexArray:
        """The derivatives (m, m + P) of A r by the state and the parameters, with r (m,) held."""
        rates, count = self.flow.rates, self.flow.rates.tape.inputs
        places, formulas = rates.along(range(self.flow.size)).jacobian(range(count))
        slopes: Any = np.zeros((self.flow.size, count), dtype=complex)
        for place, entry in zip(places, formulas.arrays(*self.x, *self.values, *right), strict=True):
            slopes[place] = entry
        return slopes

    def bilinear(self, left: Any, right: Any) -> ComplexArray:
        """l (dA/dp) r (P,), including the shift of the equilibrium."""
        slopes, m = left @ self.slopes_of_product(right), len(self.x)
        force, total = slopes[:m], slopes[m:]
        return total - solve_regular(self.matrix.T, force) @ self.by_parameter if force.any() else total
