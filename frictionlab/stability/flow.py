"""The flow of one mode and its derivative as functions of arrays, derived by sympy once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray
from scipy.sparse import csr_array

from frictionlab.automaton.combinations import combinations_of
from frictionlab.models.symbols import derivatives

Array = NDArray[np.float64]
# Terms from which on to write each as Python code takes seconds; they are then sums of a few expressions.
MANY_TERMS = 1000


@dataclass(frozen=True, eq=False)
class Flow:
    """x' = rhs(x) and its Jacobian, for N states and N values of the parameters.

    Parameters
    ----------
    states, parameters : tuple of sympy.Symbol
    expressions : tuple of sympy.Expr
        The right-hand sides.
    margins : tuple of sympy.Expr
        Positive where the mode can last: its event functions, its normal force.
    coordinates : int
        How many states are coordinates.
    """

    states: tuple[Any, ...]
    parameters: tuple[Any, ...]
    expressions: tuple[Any, ...]
    margins: tuple[Any, ...]
    coordinates: int

    @cached_property
    def _partial(self) -> dict[tuple[int, int], Any]:
        places, states = {x: j for j, x in enumerate(self.states)}, {*self.states}
        return {
            (i, places[x]): entry
            for i, row in enumerate(self.expressions)
            for x, entry in sorted(derivatives(row, states).items(), key=lambda item: places[item[0]])
        }

    @cached_property
    def free(self) -> list[int]:
        """The states whose rates depend on no state."""
        return sorted({*range(len(self.states))} - {row for row, _ in self._partial})

    @cached_property
    def unseen(self) -> list[int]:
        """The states on which no rate depends."""
        return sorted({*range(len(self.states))} - {column for _, column in self._partial})

    @cached_property
    def linear(self) -> bool:
        """Whether the Jacobian is the same at every state."""
        states = {*self.states}
        return all(states.isdisjoint(entry.free_symbols) for entry in self._partial.values())

    @cached_property
    def nonlinear(self) -> list[int]:
        """The states that enter nonlinearly: columns of the Jacobian that are not the same at every state."""
        states = {*self.states}
        return sorted(
            {j for (_, j), entry in self._partial.items() if not states.isdisjoint(entry.free_symbols)}
        )

    @cached_property
    def _entries(self) -> Callable[..., Any]:
        return self.compiled(tuple(self._partial.values()))

    @cached_property
    def _nonlinear_partial(self) -> dict[tuple[int, int], Any]:
        return {place: entry for place, entry in self._partial.items() if place[1] in self.nonlinear}

    @cached_property
    def _nonlinear_entries(self) -> Callable[..., Any]:
        return self.compiled(tuple(self._nonlinear_partial.values()))

    @cached_property
    def _rhs(self) -> Callable[..., Any]:
        return self.compiled(self.expressions)

    @cached_property
    def _margins(self) -> Callable[..., Any]:
        return self.compiled(self.margins)

    def compiled(self, expressions: Sequence[Any]) -> Callable[..., Any]:
        """A numpy function of all states, then all parameters."""
        arguments = [*self.states, *self.parameters]
        if sum(len(sympy.Add.make_args(one)) for one in expressions) < MANY_TERMS:
            return sympy.lambdify(arguments, list(expressions), modules="numpy", cse=True)
        sums = combinations_of(expressions, self.states)
        of = sympy.lambdify(arguments, list(sums.expressions), modules="numpy", cse=True)
        matrix = csr_array((sums.numbers, tuple(sums.places.T)), (sums.sums, len(sums.expressions)))
        return lambda *values: matrix @ np.stack(np.broadcast_arrays(*of(*values)))

    def rhs(self, x: Any, values: Sequence[Any]) -> Array:
        """x' (m, ...) at states `x` (m, ...); parameters are numbers or arrays."""
        return _stacked(self._rhs(*x, *values), np.shape(x[0]))

    def margin(self, x: Any, values: Sequence[Any]) -> Array:
        """The least of the margins, (...)."""
        if not self.margins:
            return np.full(np.shape(x[0]), np.inf)
        return _stacked(self._margins(*x, *values), np.shape(x[0])).min(axis=0)

    def jacobian(self, x: Any, values: Sequence[Any]) -> Array:
        """d x'/d x as (..., m, m)."""
        m = len(self.states)
        matrix = np.zeros((m, m, *np.shape(x[0])))
        entries = self._entries(*x, *values)
        if isinstance(entries, np.ndarray):
            rows, columns = zip(*self._partial)
            matrix[rows, columns] = entries.reshape(len(rows), -1) if matrix.ndim > 2 else entries
        else:
            for place, entry in zip(self._partial, entries):
                matrix[place] = entry
        return np.moveaxis(matrix, (0, 1), (-2, -1))

    def nonlinear_columns(self, x: Array, values: Sequence[Any]) -> Array:
        """The columns `nonlinear` of the Jacobian as (N, m, k), at states (m, N)."""
        columns = {j: k for k, j in enumerate(self.nonlinear)}
        found = np.zeros((x.shape[1], len(self.states), len(columns)))
        for (i, j), entry in zip(self._nonlinear_partial, self._nonlinear_entries(*x, *values)):
            found[:, i, columns[j]] = entry
        return found


def _stacked(parts: Sequence[Any], shape: tuple[int, ...]) -> Array:
    found = np.empty((len(parts), *shape))
    for i, part in enumerate(parts):
        found[i, ...] = part
    return found
