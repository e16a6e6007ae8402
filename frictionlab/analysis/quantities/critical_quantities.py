"""Quantities of the first loss of stability: the critical value of a parameter, and the frequency there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionlab.stability.boundaries.first_losses import FirstLosses, first_losses
from frictionlab.stability.boundaries.fold_points import fold_point
from frictionlab.stability.boundaries.stability_changes import (
    StabilityChange,
    changes_on_lines,
    first_loss_change,
)
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_problem import EquilibriumProblem, check_bounds
from frictionlab.stability.flow import EquilibriumDerivatives, null_vectors

from .equilibrium_quantities import DEFECTIVE_PRODUCT, derivatives_at, gradient_of
from .quantity import Array, Gradient, Quantity

REAL_RTOL = 1e-6  # of its size: a slope of the critical value that is not real to this has no meaning


@dataclass(frozen=True)
class _AtFirstLoss(Quantity):
    """A number at the first loss of stability as a parameter grows."""

    parameter: str
    bounds: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "bounds", tuple(map(float, self.bounds)))

    def _change(self, problem: EquilibriumProblem) -> StabilityChange:
        limits = check_bounds(problem.model, self.parameter, self.bounds)
        change = first_loss_change(changes_on_lines(problem, self.parameter, limits, {})[0])
        if change is None:
            raise ValueError(
                f"stability must be lost within the bounds {self.bounds} of {self.parameter}, got no loss: "
                "widen them, or see stability_changes"
            )
        return change

    def _losses(self, model: Any, changes: Mapping[str, Array]) -> FirstLosses:
        problem = equilibrium_problem(model)
        limits = check_bounds(problem.model, self.parameter, self.bounds)
        if self.parameter in changes:
            raise ValueError(
                f"{self.parameter} must be left out, got values of it: its critical value is asked for"
            )
        fixed = {name: np.asarray(column, dtype=float) for name, column in changes.items()}
        return first_losses(problem, self.parameter, limits, fixed)


@dataclass(frozen=True)
class CriticalValue(_AtFirstLoss):
    """The first value of a parameter at which stability is lost as it grows; see :func:`critical_value`.

    Its derivatives hold where flutter sets in (a Hopf point), and where undamped modes coalesce; where the
    equilibrium ends in a fold they are not known.

    Parameters
    ----------
    parameter : str
    bounds : (float, float)

    Examples
    --------
    >>> import frictionlab as fl
    >>> round(fl.CriticalValue("mu_k", (0, 4))(fl.SliderOnBelt()), 5)
    1.51378
    """

    @property
    def label(self) -> str:
        return f"critical {self.parameter}"

    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        return self._losses(model, changes).values

    def gradient(self, model: Any) -> Gradient:
        problem = equilibrium_problem(model)
        change = self._change(problem)
        slopes, _ = _critical_slopes(problem, self.parameter, change)
        return gradient_of(problem, change.value, slopes)


@dataclass(frozen=True)
class CriticalFrequency(_AtFirstLoss):
    """The frequency at which flutter begins where stability is first lost as a parameter grows, Hz.

    Parameters
    ----------
    parameter : str
    bounds : (float, float)

    Examples
    --------
    >>> import frictionlab as fl
    >>> 10 < fl.CriticalFrequency("mu_k", (0, 4))(fl.SliderOnBelt()) < 20
    True
    """

    @property
    def label(self) -> str:
        return f"frequency at the critical {self.parameter} (Hz)"

    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        return self._losses(model, changes).frequencies

    def gradient(self, model: Any) -> Gradient:
        problem = equilibrium_problem(model)
        change = self._change(problem)
        _, slopes = _critical_slopes(problem, self.parameter, change)
        if change.kind != "flutter" or np.isnan(slopes).any():
            raise ValueError(
                "stability must be lost by flutter of damped modes for the frequency to have derivatives, "
                f"got {change.kind} at {self.parameter} = {change.value:.6g}: ask for CriticalValue"
            )
        return gradient_of(problem, change.frequency, slopes)


@dataclass(frozen=True)
class FoldValue(Quantity):
    """The first value of a parameter at which an equilibrium ends in a fold, or begins in one.

    At a fold the state matrix A is singular, l A = 0; the equilibrium stays on it where l f_p dp = 0, so that
    d(fold)/dp = -l f_p / l f_q with q the parameter.

    Parameters
    ----------
    parameter : str
    bounds : (float, float)
        Where it is looked for.

    Examples
    --------
    >>> import frictionlab as fl, sympy as sp
    >>> x, p, a = sp.symbols("x p a")
    >>> ends = fl.HybridAutomaton((x,), (fl.Mode("flow", (p - a + x**2,)),), {p: 0.5, a: 1.0})
    >>> round(fl.FoldValue("p", (0.5, 2.0))(ends), 9)  # at p = a
    1.0
    """

    parameter: str
    bounds: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "bounds", tuple(map(float, self.bounds)))

    @property
    def label(self) -> str:
        return f"{self.parameter} at the fold"

    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        problem = equilibrium_problem(model)
        low, high = check_bounds(problem.model, self.parameter, self.bounds)
        count = max((np.size(column) for column in changes.values()), default=1)
        rows = [{name: np.ravel(column)[i] for name, column in changes.items()} for i in range(count)]
        found = (fold_point(problem, self.parameter, (low, high), row) for row in rows)
        return np.array([np.nan if point is None else point.value for point in found])

    def gradient(self, model: Any) -> Gradient:
        problem = equilibrium_problem(model)
        limits = check_bounds(problem.model, self.parameter, self.bounds)
        point = fold_point(problem, self.parameter, limits, {})
        if point is None:
            raise ValueError(
                f"the equilibrium must end in a fold within the bounds {self.bounds} of {self.parameter}, "
                "got no fold: widen them, or see equilibria"
            )
        return gradient_of(problem, point.value, point.slopes)


def _critical_slopes(
    problem: EquilibriumProblem, parameter: str, change: StabilityChange
) -> tuple[Array, Array]:
    """Derivatives (P,) of the critical value and of the frequency there by all parameters."""
    place = [symbol.name for symbol in problem.flow.parameters].index(parameter)
    if change.kind == "fold":
        raise ValueError(
            "stability must be lost by flutter or divergence for the critical value to have derivatives, "
            f"got a fold at {parameter} = {change.value:.6g}, where the equilibrium ends: take another range"
        )
    at = derivatives_at(problem, **{parameter: change.value})
    value, frequency = _flutter_slopes(at, place, 2j * np.pi * change.frequency)
    value[place] = frequency[place] = 0.0  # the critical value does not depend on the parameter's own
    return value, frequency


def _flutter_slopes(at: EquilibriumDerivatives, place: int, critical: complex) -> tuple[Array, Array]:
    """Where the eigenvalue stays on the imaginary axis: Re(l dA r / l r) = 0.

    Where two coalesce (without damping) l r = 0, and they stay double where l dA r = 0: a parameter that
    would take them apart to both sides of the axis, as damping, has no derivative.
    """
    vectors = null_vectors(at.matrix, critical)
    slopes = at.bilinear(vectors.left, vectors.right)
    if abs(vectors.product) < DEFECTIVE_PRODUCT:
        ratio = -slopes / slopes[place]
        sizes = np.abs(np.array(at.values, dtype=float))
        # What is zero but for rounding beside the critical value is real as well.
        nothing = (np.abs(ratio) * sizes <= REAL_RTOL * sizes[place]) & (sizes > 0)
        real = (np.abs(ratio.imag) <= REAL_RTOL * np.abs(ratio)) | nothing
        return np.where(real, ratio.real, np.nan), np.full(len(slopes), np.nan)
    rates = slopes / vectors.product
    value = -rates.real / rates[place].real
    return value, (rates.imag + rates[place].imag * value) / (2 * np.pi)
