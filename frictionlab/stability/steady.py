"""Steady motion as a function of the parameters: the one view of a model that all stability analyses have.

Give a flow and `solve`, and the rest works: sliding.py does so for models, automata.py for automata.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .flow import Flow
from .spectra import eigenvalues_of

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False)
class Steady:
    """Equilibria and linearised flow of one mode.

    Parameters
    ----------
    model : Model or HybridAutomaton
    names : tuple of str
        Names of the coordinates, or of all states where there are none.
    flow : Flow
    values : tuple of float
        The parameters, in the flow's order.
    solve : callable
        Values (numbers or arrays (N,)), and N -> states (m, N) of the equilibrium; NaN where there is none.
    guards : tuple of sympy.Expr
        What is positive while the motion goes on in this mode: v_r, the gap.
    """

    model: Any
    names: tuple[str, ...]
    flow: Flow
    values: tuple[float, ...]
    solve: Callable[[Sequence[Any], int], Array]
    guards: tuple[Any, ...] = ()

    @property
    def parameters(self) -> dict[str, float]:
        """Name -> value."""
        return {symbol.name: value for symbol, value in zip(self.flow.parameters, self.values)}

    def at(self, changes: Mapping[str, Any]) -> tuple[tuple[Any, ...], int]:
        """The values with some changed to arrays (N,), and N."""
        arrays = {name: np.asarray(values, dtype=float).ravel() for name, values in changes.items()}
        count = max((len(a) for a in arrays.values()), default=1)
        return tuple(arrays.get(s.name, v) for s, v in zip(self.flow.parameters, self.values)), count

    def linearised(self, changes: Mapping[str, Any]) -> tuple[Array, Array]:
        """Equilibria (m, N) and state matrices (N, m, m); NaN where there is no equilibrium."""
        values, count = self.at(changes)
        x = self.solve(values, count)
        matrices = self.flow.jacobian(x, values)
        matrices[np.isnan(x).any(axis=0)] = np.nan  # entries that do not depend on x are still numbers
        return x, matrices

    def spectra(self, changes: Mapping[str, Any]) -> ComplexArray:
        """Eigenvalues (N, m), the largest growth rate first."""
        _, matrices = self.linearised(changes)
        found: Any = np.full(matrices.shape[:2], complex(np.nan, np.nan))
        known = np.isfinite(matrices).all(axis=(1, 2))
        found[known] = eigenvalues_of(matrices[known])
        return np.take_along_axis(found, np.argsort(-found.real, axis=1), axis=1)
