"""Quantities where stability first changes: the critical value of a parameter, and the frequency there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from frictionlab.analysis.quantities.quantities import (
    DEFECTIVE_PRODUCT,
    Array,
    Gradient,
    WithinBounds,
    derivatives_at,
    gradient_of,
)
from frictionlab.stability.boundaries.stability_changes import (
    CriticalPoints,
    StabilityChange,
    StabilityKind,
    changes_on_lines,
    critical_change,
    critical_points,
    unstable_all_along,
)
from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.flow import EquilibriumDerivatives
from frictionlab.stability.state_matrices import eigenpair

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton

REAL_RTOL = 1e-6  # a slope of the critical value with a larger share of imaginary part has no meaning


@dataclass(frozen=True)
class _AtCriticalPoint(WithinBounds):
    """A number where stability first changes as a parameter grows."""

    def _change(self, problem: EquilibriumProblem, bounds: tuple[float, float]) -> StabilityChange:
        changes = changes_on_lines(problem, self.parameter, bounds, {})[0]
        change = critical_change(changes)
        if change is None:
            why = unstable_all_along(problem, self.parameter, bounds[0], changes)
            raise ValueError(
                f"stability must be lost or regained within the bounds {self.bounds} of {self.parameter}, "
                f"got neither{why and f', as {why}'}: widen them, or see stability_changes"
            )
        return change

    def _points(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> CriticalPoints:
        problem, bounds = self.problem(model)
        if self.parameter in changes:
            raise ValueError(
                f"{self.parameter} must be left out, got values of it: its critical value is asked for"
            )
        fixed = {name: np.asarray(column, dtype=float) for name, column in changes.items()}
        return critical_points(problem, self.parameter, bounds, fixed)


@dataclass(frozen=True)
class CriticalValue(_AtCriticalPoint):
    """The first value of a parameter at which stability is lost or regained; see :func:`critical_value`.

    Its derivatives are known where flutter sets in (a Hopf point), at divergence, and where undamped modes
    coalesce, but not where the equilibrium ends in a fold.

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

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        return self._points(model, changes).values

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        problem, bounds = self.problem(model)
        change = self._change(problem, bounds)
        slopes, _ = _critical_slopes(problem, self.parameter, change)
        return gradient_of(problem, change.value, slopes)


@dataclass(frozen=True)
class CriticalFrequency(_AtCriticalPoint):
    """The frequency of the flutter that begins or ends at the critical value of a parameter, Hz.

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

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        return self._points(model, changes).frequencies

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        problem, bounds = self.problem(model)
        change = self._change(problem, bounds)
        _, slopes = _critical_slopes(problem, self.parameter, change)
        if change.kind != StabilityKind.FLUTTER or np.isnan(slopes).any():
            raise ValueError(
                "stability must change by flutter of damped modes for the frequency to have derivatives, "
                f"got {change.kind} at {self.parameter} = {change.value:.6g}: ask for CriticalValue"
            )
        return gradient_of(problem, change.frequency, slopes)


def _critical_slopes(
    problem: EquilibriumProblem, parameter: str, change: StabilityChange
) -> tuple[Array, Array]:
    """Derivatives (P,) of the critical value and of the frequency there by all parameters."""
    place = problem.parameter_names.index(parameter)
    if change.kind == StabilityKind.BORDER:
        raise ValueError(
            "stability must change by flutter or divergence for the critical value to have derivatives, got "
            f"a border of a law in pieces at {parameter} = {change.value:.6g}, where eigenvalues jump: take "
            "another range"
        )
    if change.kind == StabilityKind.FOLD:
        raise ValueError(
            "stability must change by flutter or divergence for the critical value to have derivatives, "
            f"got a fold at {parameter} = {change.value:.6g}, where the equilibrium ends: take another range"
        )
    at = derivatives_at(problem, **{parameter: change.value})
    value, frequency = _flutter_slopes(at, place, 2j * np.pi * change.frequency)
    value[place] = frequency[place] = 0.0  # the critical value does not depend on the parameter's own
    return value, frequency


def _flutter_slopes(at: EquilibriumDerivatives, place: int, critical: complex) -> tuple[Array, Array]:
    """Derivatives (P,) of the critical value and of the frequency, from Re(l dA r / l r) = 0.

    This keeps the eigenvalue on the imaginary axis.  Where two coalesce (without damping) l r = 0, and
    l dA r = 0 keeps them double.  By a parameter that would move them apart to both sides of the axis, as
    damping does, there is no derivative.
    """
    pair = eigenpair(at.matrix, critical)
    slopes = at.bilinear(pair.left, pair.right)
    if abs(pair.product) < DEFECTIVE_PRODUCT:
        ratio = -slopes / slopes[place]
        sizes = np.abs(np.array(at.values, dtype=float))
        # A slope that is zero to rounding, compared with the critical value, counts as real.
        nothing = (np.abs(ratio) * sizes <= REAL_RTOL * sizes[place]) & (sizes > 0)
        real = (np.abs(ratio.imag) <= REAL_RTOL * np.abs(ratio)) | nothing
        return np.where(real, ratio.real, np.nan), np.full(len(slopes), np.nan)
    rates = slopes / pair.product
    value = -rates.real / rates[place].real
    return value, (rates.imag + rates[place].imag * value) / (2 * np.pi)
