"""Where an equilibrium ends in a fold, and its derivatives by all parameters.

At a fold an equilibrium meets another one and both end.  There f(x, q) = 0 and A r = 0 for a vector r, with
c r = 1 for a fixed row c: 2 m + 1 equations for x, r and the parameter q, regular at a quadratic fold.  They
are solved by Newton's method from the last equilibrium before it ends or gives way to another, which is found
by dividing intervals of the parameter.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionlab.analysis.quantities.quantities import Array, Gradient, WithinBounds, gradient_of
from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.flow import EquilibriumDerivatives

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton

SCAN_POINTS = 257
DIVISIONS, PARTS = 10, 16  # of an interval, whose points are followed together: to 2^-40 of it
MAX_STEPS = 30
STEP_RTOL = 1e-13
JUMP_FACTOR = 8.0  # times the median change between scanned values: a larger change may be a jump
JUMP_SHARE = 0.05  # share of such a change that is left after the divisions if it is a jump
FOLD_RTOL = 1e-3  # share of the bounds' distance that the fold may be from where the equilibrium ended


@dataclass(frozen=True)
class FoldValue(WithinBounds):
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

    @property
    def label(self) -> str:
        return f"{self.parameter} at the fold"

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        problem, bounds = self.problem(model)
        count = max((np.size(column) for column in changes.values()), default=1)
        rows = [{name: np.ravel(column)[i] for name, column in changes.items()} for i in range(count)]
        folds = (fold_point(problem, self.parameter, bounds, row) for row in rows)
        return np.array([np.nan if point is None else point.value for point in folds])

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        problem, bounds = self.problem(model)
        point = fold_point(problem, self.parameter, bounds, {})
        if point is None:
            raise ValueError(
                f"the equilibrium must end in a fold within the bounds {self.bounds} of {self.parameter}, "
                "got no fold: widen them, or see equilibria"
            )
        return gradient_of(problem, point.value, point.slopes)


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
    at = EquilibriumDerivatives(problem.flow, x, numbers)
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
        values_at = {name: np.full(len(points), value) for name, value in fixed.items()}
        return problem.states({**values_at, parameter: np.array(points)})

    points = np.linspace(*bounds, SCAN_POINTS)
    states = at(points)
    moves = np.abs(np.diff(states)).max(axis=0)
    absent: Any = np.isnan(states).any(axis=0)
    jumps = np.isnan(moves) | (moves > JUMP_FACTOR * np.nanmedian(moves)) if not absent.all() else absent[1:]
    for i in np.flatnonzero(jumps & ~(absent[1:] & absent[:-1])):
        low, high, x, y = points[i], points[i + 1], states[:, i], states[:, i + 1]
        first = np.abs(y - x).max()
        for _ in range(DIVISIONS):
            parts = np.linspace(low, high, PARTS + 1)
            states_between = np.column_stack([x, at(parts[1:-1]), y])
            gone: Any = np.isnan(states_between).any(axis=0)
            change = np.abs(np.diff(states_between)).max(axis=0)
            k = int(np.argmax(gone[1:] != gone[:-1] if np.isnan(first) else change))
            low, high, x, y = parts[k], parts[k + 1], states_between[:, k], states_between[:, k + 1]
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
            at = EquilibriumDerivatives(flow, x, numbers)
            slopes = at.slopes_of_product(right).real
            rates, finite = flow.rhs(x, numbers), np.isfinite(at.matrix).all()
            finite &= np.isfinite(at.by_parameter).all()
        if not (finite and np.isfinite(slopes).all() and np.isfinite(rates).all()):
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
