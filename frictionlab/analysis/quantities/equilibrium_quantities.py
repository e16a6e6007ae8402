"""Quantities of an equilibrium: its coordinates, its eigenvalues' growth rates and frequencies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionlab.analysis.quantities.sensitivity import Array, Gradient, Quantity
from frictionlab.presentation import state_unit
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_problem import ComplexArray, EquilibriumProblem
from frictionlab.stability.flow import (
    EquilibriumDerivatives,
    equilibrium_derivatives,
    null_vectors,
)
from frictionlab.validation import check_choice, check_number

DEFECTIVE_PRODUCT = 1e-6  # |l r| below which two eigenvalues coalesce: single ones have no derivative


@dataclass(frozen=True)
class EquilibriumCoordinate(Quantity):
    """A coordinate of the equilibrium, m or rad; Eq. (18).

    Parameters
    ----------
    name : str
        As "x1".

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.EquilibriumCoordinate("x")(fl.MassOnBelt(mu_k=0.5, mu_s=1.0))  # mu_k N / k
    0.5
    """

    name: str

    @property
    def label(self) -> str:
        return f"{self.name} at equilibrium ({state_unit(self.name)})"

    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        problem = equilibrium_problem(model)
        values, count = problem.at(changes)
        return problem.solve(values, count)[self._index(problem)]

    def gradient(self, model: Any) -> Gradient:
        problem = equilibrium_problem(model)
        at = derivatives_at(problem)
        i = self._index(problem)
        return gradient_of(problem, float(at.x[i]), at.state()[i])

    def _index(self, problem: EquilibriumProblem) -> int:
        check_choice("name", self.name, problem.names, "name one of them")
        return problem.names.index(self.name)


@dataclass(frozen=True)
class GrowthRate(Quantity):
    """A growth rate at the equilibrium, 1/s: the largest, or that of one mode.

    Parameters
    ----------
    mode : int or None
        Modes are counted from 0 by ascending frequency; None takes the largest growth rate, whose sign is the
        stability.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.GrowthRate()(fl.SliderOnBelt(mu_k=2.0)) > 0
    True
    """

    mode: int | None = None

    def __post_init__(self) -> None:
        _check_mode(self.mode)

    @property
    def label(self) -> str:
        which = "largest growth rate" if self.mode is None else f"growth rate of mode {self.mode}"
        return f"{which} (1/s)"

    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        return _chosen(equilibrium_problem(model), self.mode, changes).real

    def gradient(self, model: Any) -> Gradient:
        problem = equilibrium_problem(model)
        value, slopes = _eigenvalue_gradient(problem, self.mode)
        return gradient_of(problem, value.real, slopes.real)


@dataclass(frozen=True)
class ModeFrequency(Quantity):
    """The frequency of a mode at the equilibrium, Hz.

    Parameters
    ----------
    mode : int or None
        Counted from 0 by ascending frequency; None takes the mode with the largest growth rate.

    Examples
    --------
    >>> import frictionlab as fl
    >>> round(fl.ModeFrequency(0)(fl.SliderOnBelt(mu_k=1.4)), 2)
    13.51
    """

    mode: int | None = None

    def __post_init__(self) -> None:
        _check_mode(self.mode)

    @property
    def label(self) -> str:
        which = "of the least damped mode" if self.mode is None else f"of mode {self.mode}"
        return f"frequency {which} (Hz)"

    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        return _chosen(equilibrium_problem(model), self.mode, changes).imag / (2 * np.pi)

    def gradient(self, model: Any) -> Gradient:
        problem = equilibrium_problem(model)
        value, slopes = _eigenvalue_gradient(problem, self.mode)
        return gradient_of(problem, value.imag / (2 * np.pi), slopes.imag / (2 * np.pi))


def _check_mode(mode: Any) -> None:
    if mode is not None:
        check_number("mode", mode, integer=True, least=0, cure="count from 0, by ascending frequency")


def gradient_of(problem: EquilibriumProblem, value: float, slopes: Any) -> Gradient:
    """A gradient from derivatives (P,) in the order of the flow's parameters."""
    return Gradient(value, dict(zip(problem.parameter_names, map(float, slopes), strict=True)))


def derivatives_at(problem: EquilibriumProblem, **changes: float) -> EquilibriumDerivatives:
    """The derivatives at the equilibrium that :func:`equilibrium_at` gives."""
    return equilibrium_derivatives(problem.flow, *equilibrium_at(problem, **changes))


def equilibrium_at(problem: EquilibriumProblem, **changes: float) -> tuple[Array, tuple[float, ...]]:
    """A problem's equilibrium (m,) with some parameters changed, and the values of all.

    Raises
    ------
    ValueError
        Where there is none.
    """
    values, count = problem.at(changes)
    values = tuple(float(np.ravel(v)[0]) for v in values)
    x = problem.solve(values, count)[:, 0]
    if np.isnan(x).any():
        raise ValueError(
            f"{type(problem.model).__name__} must have an equilibrium in sliding, got none: change its "
            "parameters"
        )
    return x, values


def _chosen(problem: EquilibriumProblem, mode: int | None, changes: Mapping[str, Array]) -> Any:
    """One eigenvalue (N,) with Im >= 0 of each model."""
    return _of_mode(problem.spectra(changes), mode)


def _of_mode(spectra: ComplexArray, mode: int | None) -> ComplexArray:
    """The eigenvalue of a mode in each of some spectra (N, m), sorted by growth rate."""
    if mode is None:
        return spectra[:, 0].real + 1j * np.abs(spectra[:, 0].imag)
    count = (spectra.shape[1] + 1) // 2
    if mode >= count:
        raise ValueError(f"mode must be below {count}, the number of modes, got {mode}: count from 0")
    order = np.lexsort((spectra.imag, spectra.real, np.abs(spectra.imag)))
    chosen = np.take_along_axis(spectra, order, axis=1)[:, min(2 * mode, spectra.shape[1] - 1)]
    return chosen.real + 1j * np.abs(chosen.imag)


def _eigenvalue_gradient(problem: EquilibriumProblem, mode: int | None) -> tuple[complex, ComplexArray]:
    at = derivatives_at(problem)
    value = complex(_of_mode(problem.spectra({}), mode)[0])
    vectors = null_vectors(at.matrix, value)
    if abs(vectors.product) < DEFECTIVE_PRODUCT:
        raise ValueError(
            f"the eigenvalue must be simple to have derivatives, got two that coalesce at {value:.6g} 1/s: "
            "change a parameter a little"
        )
    return value, at.bilinear(vectors.left, vectors.right) / vectors.product
