"""Quantities at the first loss of stability (critical value of a parameter, frequency) and at folds.

At a fold an equilibrium meets another one and both end.  There f(x, q) = 0 and A r = 0 for a vector r, with
c r = 1 for a fixed row c: 2 m + 1 equations for x, r and the parameter q, regular at a quadratic fold.  They
are solved by Newton's method from the last equilibrium before it ends or gives way to another, which is found
by halving intervals of the parameter.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionlab.analysis.quantities.quantities import (
    DEFECTIVE_PRODUCT,
    Array,
    Gradient,
    Quantity,
    derivatives_at,
    gradient_of,
)
from frictionlab.stability.boundaries.first_losses import FirstLosses, first_losses
from frictionlab.stability.boundaries.stability_changes import (
    StabilityChange,
    StabilityKind,
    changes_on_lines,
    first_loss_change,
    unstable_from_the_start,
)
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_problem import EquilibriumProblem, check_bounds
from frictionlab.stability.flow import (
    EquilibriumDerivatives,
    equilibrium_derivatives,
    null_vectors,
)
from frictionlab.validation import check_limits, check_text

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton

SCAN_POINTS = 257
HALVINGS = 40
MAX_STEPS = 30
STEP_RTOL = 1e-13
JUMP_FACTOR = 8.0  # times the median change between scanned values: a larger change may be a jump
JUMP_SHARE = 0.05  # share of such a change that is left after halving if it is a jump
FOLD_RTOL = 1e-3  # share of the bounds' distance that the fold may be from where the equilibrium ended
REAL_RTOL = 1e-6  # a slope of the critical value with a larger share of imaginary part has no meaning


class FoldPoint(NamedTuple):
    """The parameter's value at a fold, the equilibrium (m,) there, and the value's derivatives (P,)."""

    value: float
    x: Array
    slopes: Array


def fold_point(
    problem: EquilibriumProblem, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Any]
) -> FoldPoint | None:
    """The first fold between two values of a parameter; None where the equilibrium does not end in one."""
    values, _ = problem.at({**fixed, parameter: bounds[0]})
    numbers, place = [float(np.ravel(v)[0]) for v in values], problem.parameter_names.index(parameter)
    for end in _ends(problem, parameter, bounds, fixed):
        numbers[place] = end.value
        fold = _newton(problem, end.x, numbers, place)
        # Otherwise there is no fold: the equilibrium leaves its mode, or its law ends.
        if fold is not None and abs(fold[1] - end.value) < FOLD_RTOL * (bounds[1] - bounds[0]):
            numbers[place] = fold[1]
            return _with_slopes(problem, fold[0], numbers, place)
    return None


def _with_slopes(problem: EquilibriumProblem, x: Array, numbers: list[float], place: int) -> FoldPoint:
    at = equilibrium_derivatives(problem.flow, x, numbers)
    left = np.linalg.svd(at.matrix)[0][:, -1]
    forces = left @ at.by_parameter
    slopes = -forces / forces[place]
    slopes[place] = 0.0  # the value at the fold does not depend on the parameter's own
    return FoldPoint(numbers[place], x, slopes)


class _End(NamedTuple):
    """The parameter's value next to where an equilibrium begins or ends, and the equilibrium (m,) there."""

    value: float
    x: Array


def _ends(
    problem: EquilibriumProblem, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Any]
) -> Iterator[_End]:
    """Where the equilibrium begins, ends, or gives way to another, in ascending order, from both sides."""

    def at(points: Any) -> Array:
        given = {name: np.full(len(points), value) for name, value in fixed.items()}
        values, count = problem.at({**given, parameter: np.array(points)})
        return problem.solve(values, count)

    points = np.linspace(*bounds, SCAN_POINTS)
    states = at(points)
    moves = np.abs(np.diff(states)).max(axis=0)
    gone: Any = np.isnan(states).any(axis=0)
    jumps = np.isnan(moves) | (moves > JUMP_FACTOR * np.nanmedian(moves)) if not gone.all() else gone[1:]
    for i in np.flatnonzero(jumps & ~(gone[1:] & gone[:-1])):
        low, high, x, y = points[i], points[i + 1], states[:, i], states[:, i + 1]
        first = np.abs(y - x).max()
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            z = at([middle])[:, 0]
            before, after = np.abs(z - x).max(), np.abs(y - z).max()
            known = np.isnan(z).any() == np.isnan(x).any() if np.isnan(first) else before <= after
            low, high, x, y = (middle, high, z, y) if known else (low, middle, x, z)
        if np.isnan(first) or np.abs(y - x).max() > JUMP_SHARE * first:
            yield from (
                _End(float(v), state) for v, state in ((low, x), (high, y)) if np.isfinite(state).all()
            )


def _newton(
    problem: EquilibriumProblem, x: Array, numbers: list[float], place: int
) -> tuple[Array, float] | None:
    """State and value at the fold, by Newton's method on the bordered system."""
    flow, m = problem.flow, len(x)
    right = np.linalg.svd(flow.jacobian(x, numbers))[2][-1]
    row, numbers, size = right.copy(), list(numbers), np.abs(x).max()
    for _ in range(MAX_STEPS):
        with np.errstate(all="ignore"):  # from a poor start steps may leave all floats
            at = equilibrium_derivatives(flow, x, numbers)
            slopes = at.slopes_of_product(right).real
            rates = flow.rhs(x, numbers)
        if not (np.isfinite(at.matrix).all() and np.isfinite(slopes).all() and np.isfinite(rates).all()):
            return None
        curved, mixed = slopes[:, :m], slopes[:, m + place]
        system = np.zeros((2 * m + 1, 2 * m + 1))
        system[:m, :m], system[:m, -1] = at.matrix, at.by_parameter[:, place]
        system[m:-1, :m], system[m:-1, m:-1], system[m:-1, -1] = curved, at.matrix, mixed
        system[-1, m:-1] = row
        missed = np.concatenate([rates, at.matrix @ right, [row @ right - 1.0]])
        try:
            step = -np.linalg.solve(system, missed)
        except np.linalg.LinAlgError:
            return None
        x, right, numbers[place] = x + step[:m], right + step[m:-1], numbers[place] + step[-1]
        if np.abs(step[:m]).max() <= STEP_RTOL * size and abs(step[-1]) <= STEP_RTOL * abs(numbers[place]):
            break
    return (x, float(numbers[place])) if np.isfinite(x).all() else None


@dataclass(frozen=True)
class _AtFirstLoss(Quantity):
    """A number at the first loss of stability as a parameter grows."""

    parameter: str
    bounds: tuple[float, float]

    def __post_init__(self) -> None:
        check_text("parameter", self.parameter, "name a parameter")
        object.__setattr__(self, "bounds", check_limits("bounds", self.bounds, "give (low, high)"))

    def _change(self, problem: EquilibriumProblem) -> StabilityChange:
        limits = check_bounds(problem.model, self.parameter, self.bounds)
        changes = changes_on_lines(problem, self.parameter, limits, {})[0]
        change = first_loss_change(changes)
        if change is None:
            why = unstable_from_the_start(problem, self.parameter, limits, changes)
            raise ValueError(
                f"stability must be lost within the bounds {self.bounds} of {self.parameter}, got no loss"
                f"{why and f', as {why}'}: widen them, or see stability_changes"
            )
        return change

    def _losses(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> FirstLosses:
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
        return self._losses(model, changes).values

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
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

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        return self._losses(model, changes).frequencies

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        problem = equilibrium_problem(model)
        change = self._change(problem)
        _, slopes = _critical_slopes(problem, self.parameter, change)
        if change.kind != StabilityKind.FLUTTER or np.isnan(slopes).any():
            raise ValueError(
                "stability must be lost by flutter of damped modes for the frequency to have derivatives, "
                f"got {change.kind} at {self.parameter} = {change.value:.6g}: ask for CriticalValue"
            )
        return gradient_of(problem, change.frequency, slopes)


@dataclass(frozen=True)
class FoldValue(Quantity):
    """The first value of a parameter at which an equilibrium ends in a fold, or begins in one.

    At a fold the state matrix A is singular, l A = 0.  Changes dp of the parameters with l f_p dp = 0 keep
    the equilibrium at the fold, so that d(fold)/dp = -l f_p / l f_q with q the parameter.

    Parameters
    ----------
    parameter : str
    bounds : (float, float)
        Range in which the fold is looked for.

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
        check_text("parameter", self.parameter, "name a parameter")
        object.__setattr__(self, "bounds", check_limits("bounds", self.bounds, "give (low, high)"))

    @property
    def label(self) -> str:
        return f"{self.parameter} at the fold"

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        problem = equilibrium_problem(model)
        low, high = check_bounds(problem.model, self.parameter, self.bounds)
        count = max((np.size(column) for column in changes.values()), default=1)
        rows = [{name: np.ravel(column)[i] for name, column in changes.items()} for i in range(count)]
        folds = (fold_point(problem, self.parameter, (low, high), row) for row in rows)
        return np.array([np.nan if point is None else point.value for point in folds])

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
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
    place = problem.parameter_names.index(parameter)
    if change.kind == StabilityKind.FOLD:
        raise ValueError(
            "stability must be lost by flutter or divergence for the critical value to have derivatives, "
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
    vectors = null_vectors(at.matrix, critical)
    slopes = at.bilinear(vectors.left, vectors.right)
    if abs(vectors.product) < DEFECTIVE_PRODUCT:
        ratio = -slopes / slopes[place]
        sizes = np.abs(np.array(at.values, dtype=float))
        # A slope that is zero to rounding, compared with the critical value, counts as real.
        nothing = (np.abs(ratio) * sizes <= REAL_RTOL * sizes[place]) & (sizes > 0)
        real = (np.abs(ratio.imag) <= REAL_RTOL * np.abs(ratio)) | nothing
        return np.where(real, ratio.real, np.nan), np.full(len(slopes), np.nan)
    rates = slopes / vectors.product
    value = -rates.real / rates[place].real
    return value, (rates.imag + rates[place].imag * value) / (2 * np.pi)
