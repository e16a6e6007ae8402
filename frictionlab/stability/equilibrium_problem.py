"""Equilibria and state matrices as functions of the parameters, on which all stability analyses work.

State matrices and `solve` are enough for most analyses.  Those that take further derivatives ask for the
`flow`.  Also here: the checks of parameter names, values and bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import check_value
from frictionlab.models.composition import parameter_metadata
from frictionlab.models.mechanical.masses import check_masses_within
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.model import Model, ModelOrAutomaton, check_parameter_name, check_varied
from frictionlab.stability.flow import Flow
from frictionlab.stability.state_matrices import Array, ComplexArray, eigenvalues_of_matrices, unstable_pairs
from frictionlab.tape.formulas import Formulas
from frictionlab.validation import abbreviate, check_limits, check_pair, float_array

COMPLETING_STEPS = 4  # of Newton's method from nearby: one is enough where a distance is linear


@dataclass(frozen=True, eq=False)
class EquilibriumProblem:
    """Equilibria and linearised flow of one mode.

    Parameters
    ----------
    model : Model or HybridAutomaton
    names : tuple of str
        Names of the coordinates, or of all states where there are none.
    parameter_names : tuple of str
    values : tuple of float
        The parameters, in the flow's order.
    solve : callable
        Takes values of the parameters (numbers or arrays (N,)) and N; gives the states (m, N) of the
        equilibrium, NaN where there is none.
    flow : Flow
    derive_guards : callable
        Gives the functions that are positive while the motion stays in this mode: v_r, the penetration.
    following : tuple of int
        Places of states that follow from the others, such as the angle of what turns, or the height on a
        rigid contact: they have no eigenvalues of their own.
    """

    model: ModelOrAutomaton
    names: tuple[str, ...]
    parameter_names: tuple[str, ...]
    values: tuple[float, ...]
    solve: Callable[[Sequence[Any], int], Array]
    flow: Flow
    derive_guards: Callable[[], Formulas]
    following: tuple[int, ...] = ()

    @property
    def parameters(self) -> dict[str, float]:
        """Name -> value."""
        return dict(zip(self.parameter_names, self.values, strict=True))

    @property
    def further(self) -> list[int]:
        """Places, without `following`, of states that are neither coordinates nor velocities of such."""
        n, m = len(self.names), self.flow.size
        if 2 * n > m:  # the names of all states
            return [*range(m - len(self.following))]
        pairs = {i for i in range(n) if not {i, n + i} & {*self.following}}
        left = [i for i in range(m) if i not in self.following]
        return [place for place, i in enumerate(left) if i >= 2 * n or i % n not in pairs]

    def at(self, changes: Mapping[str, Any]) -> tuple[tuple[Any, ...], int]:
        """The values with some changed to arrays (N,), and N."""
        values: list[Any] = list(self.values)
        lengths: list[int] = []
        for name, numbers in changes.items():
            if name not in self.parameter_names:
                check_varied(self.model, name)
            at = np.asarray(numbers, dtype=float).ravel()
            lengths.append(len(at))
            values[self.parameter_names.index(name)] = at
        return tuple(values), max(lengths, default=1)

    def states(self, changes: Mapping[str, Any]) -> Array:
        """Equilibria (m, N); NaN where there is none."""
        return self.solve(*self.at(changes))

    def linearised(self, changes: Mapping[str, Any]) -> tuple[Array, Array]:
        """Equilibria (m, N) and state matrices (N, m, m); NaN where there is no equilibrium."""
        values, count = self.at(changes)
        x = self.solve(values, count)
        matrices = self.flow.jacobian(x, values)
        matrices[np.isnan(x).any(axis=0)] = np.nan  # entries that do not depend on x are still numbers
        return x, matrices

    @property
    def holds_all(self) -> bool:
        """Whether all states follow from others, as where contacts hold each coordinate."""
        return bool(self.following) and len(self.following) == self.flow.size

    def without_following(self, matrices: Array) -> Array:
        """State matrices (..., m, m) without the states that follow from the others.

        Raises
        ------
        ValueError
            If no state is left.
        """
        if self.holds_all:
            raise ValueError(
                f"the equilibrium of {type(self.model).__name__} must leave a coordinate free to have "
                "eigenvalues, got contacts that hold all: it stays as long as they push"
            )
        for axis in (-2, -1) if self.following else ():
            matrices = np.delete(matrices, self.following, axis=axis)
        return matrices

    def with_following(self, vectors: Any, matrices: Any = None) -> Any:
        """Vectors (..., m, k) of these matrices with the states that follow from the others.

        Those are given by the whole state matrices (..., m, m); with None they are zero, as in left vectors.
        """
        places = [place - i for i, place in enumerate(self.following)]
        if not places:
            return vectors
        whole = np.insert(vectors, places, 0.0, axis=-2)
        if matrices is not None:
            whole[..., self.following, :] = matrices[..., self.following, :] @ whole
        return whole

    def completed(self, x: Array) -> Array:
        """A state (m,) near an equilibrium with the states that follow from the others."""
        whole, places = x.copy(), list(self.following)
        for _ in range(COMPLETING_STEPS if places else 0):
            whole[places] += self.flow.rhs(whole, self.values)[places]
        return whole

    def spectra(self, changes: Mapping[str, Any]) -> ComplexArray:
        """Eigenvalues (N, m), the largest growth rate first."""
        _, matrices = self.linearised(changes)
        eigenvalues: Any = np.full(matrices.shape[:2], complex(np.nan, np.nan))
        matrices = self.without_following(matrices)
        eigenvalues = eigenvalues[:, : matrices.shape[1]]
        finite = np.isfinite(matrices).all(axis=(1, 2))
        eigenvalues[finite] = eigenvalues_of_matrices(matrices[finite])
        return np.take_along_axis(eigenvalues, np.argsort(-eigenvalues.real, axis=1), axis=1)

    def count_growing(self, parameter: str, value: float) -> int:
        """How many pairs of eigenvalues grow at a value of a parameter."""
        return int(unstable_pairs(self.spectra({parameter: value}))[0])


def check_parameter(model: ModelOrAutomaton, name: Any, values: Sequence[float]) -> None:
    """Refuse an unknown parameter, and values that break its own rule.

    Rules between parameters (mu_s is at least mu_k) do not matter here: no steady motion depends on both.
    """
    check_parameter_name(model, name)
    if isinstance(model, Model):
        about = parameter_metadata(type(model), model.components)[name]
        for value in values:
            check_value(name, value, about)


def check_masses_of(model: ModelOrAutomaton, within: Mapping[str, Sequence[float] | Array]) -> None:
    """Refuse values of parameters that in some combination leave a motion without a mass."""
    if isinstance(model, MechanicalModel):
        check_masses_within(model, within)


def check_path(model: ModelOrAutomaton, name: Any, values: Any) -> NDArray[np.float64]:
    """The values (N,) of a parameter, at least one, checked against its rule."""
    at = float_array("values", values, f"give those of {name}", finite=True).ravel()
    if not len(at):
        raise ValueError(f"values must be one number or more, got {abbreviate(values)}: give those of {name}")
    check_parameter(model, name, at.tolist())
    return at


def check_axis(model: ModelOrAutomaton, which: str, given: tuple[str, Any]) -> tuple[str, Array]:
    """A parameter along one side of a grid and its values (N,), which ascend."""
    name, numbers = check_pair(which, given, "a parameter and its values", "give ('F', [1, 2])")
    check_parameter_name(model, name)
    values = float_array(f"the values of {which}", numbers, f"give those of {name}").ravel()
    if len(values) < 2 or not (np.diff(values) > 0).all():
        raise ValueError(
            f"the values of {which} must ascend, two at least, got {abbreviate(values)}: sort them"
        )
    check_parameter(model, name, values.tolist())
    return name, values


def check_bounds(model: ModelOrAutomaton, name: Any, bounds: Any) -> tuple[float, float]:
    """Two values of a parameter, in ascending order."""
    low, high = check_limits("bounds", bounds, "give (low, high)")
    check_parameter(model, name, (low, high))
    return low, high
