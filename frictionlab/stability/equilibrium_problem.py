"""Equilibria and linearised flow as functions of the parameters, on which all stability analyses work.

Give a flow and `solve`, and all analyses work.  Also the checks of parameter names, values and bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import check_value
from frictionlab.models import Model
from frictionlab.models.coercion import check_parameter_name
from frictionlab.models.parameter_namespace import parameter_metadata

from .flow import Flow
from .state_matrices import eigenvalues_of_matrices

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False)
class EquilibriumProblem:
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
        Functions that are positive while the motion stays in this mode: v_r, the penetration.
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
        found[known] = eigenvalues_of_matrices(matrices[known])
        return np.take_along_axis(found, np.argsort(-found.real, axis=1), axis=1)


def check_parameter(model: Any, name: Any, values: Sequence[float]) -> None:
    """Refuse an unknown parameter, and values that break its own rule.

    Rules between parameters (mu_s is at least mu_k) do not matter here: no steady motion depends on both.
    """
    check_parameter_name(model, name)
    if isinstance(model, Model):
        about = parameter_metadata(type(model), model.components)[name]
        for value in values:
            check_value(name, value, about)


def check_path(problem: EquilibriumProblem, name: Any, values: Any) -> NDArray[np.float64]:
    """Values (N,) of a parameter that keep to its rule, one at least."""
    try:
        at = np.atleast_1d(np.asarray(values, dtype=float)).ravel()
    except (TypeError, ValueError):
        at = np.empty(0)
    if not len(at):
        raise ValueError(f"values must be one number or more, got {values!r}: give those of {name}")
    check_parameter(problem.model, name, at.tolist())
    return at


def check_bounds(model: Any, name: Any, bounds: Any) -> tuple[float, float]:
    """Two values of a parameter, in ascending order."""
    try:
        low, high = (float("nan") if isinstance(b, str) else float(b) for b in bounds)
    except (TypeError, ValueError):
        low = high = float("nan")
    if not low < high:
        raise ValueError(f"bounds must be two numbers in ascending order, got {bounds!r}: give (low, high)")
    check_parameter(model, name, (low, high))
    return low, high
