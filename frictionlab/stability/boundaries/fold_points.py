"""Folds: where an equilibrium meets another one and both end, solved as a bordered system.

At a fold f(x, q) = 0 and A r = 0 for a vector r, with c r = 1 for a fixed row c: 2 m + 1 equations for x, r
and the parameter q, regular at a quadratic fold.  The start is the last equilibrium that halving finds before
it ends or gives way to another.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.flow import equilibrium_derivatives, flow_derivatives

Array = NDArray[np.float64]
SCAN_POINTS = 257
HALVINGS = 40
MAX_STEPS = 30
STEP_RTOL = 1e-13
JUMP_FACTOR = 8.0  # of the median between scanned values: a larger move may be a jump
JUMP_SHARE = 0.05  # of it that is left after halving where it is one
FOLD_RTOL = 1e-3  # share of the bounds by which the fold may miss where the equilibrium was seen to end


class FoldPoint(NamedTuple):
    """The parameter's value at a fold, the equilibrium (m,) there, and derivatives (P,) of the value."""

    value: float
    x: Array
    slopes: Array


def fold_point(
    problem: EquilibriumProblem, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Any]
) -> FoldPoint | None:
    """The first fold between two values of a parameter; None where the equilibrium does not end in one."""
    names = [symbol.name for symbol in problem.flow.parameters]
    values, _ = problem.at({**fixed, parameter: bounds[0]})
    numbers, place = [float(np.ravel(v)[0]) for v in values], names.index(parameter)
    for end in _ends(problem, parameter, bounds, fixed):
        numbers[place] = end.value
        found = _newton(problem, end.x, numbers, place)
        # Elsewhere the equilibrium leaves its mode, or its law ends: no fold.
        if found is not None and abs(found[1] - end.value) < FOLD_RTOL * (bounds[1] - bounds[0]):
            numbers[place] = found[1]
            return _with_slopes(problem, found[0], numbers, place)
    return None


def _with_slopes(problem: EquilibriumProblem, x: Array, numbers: list[float], place: int) -> FoldPoint:
    at = equilibrium_derivatives(problem.flow, x, numbers)
    left = np.linalg.svd(at.matrix)[0][:, -1]
    forces = left @ at.by_parameter
    slopes = -forces / forces[place]
    slopes[place] = 0.0  # the value at the fold does not depend on the parameter's own
    return FoldPoint(numbers[place], x, slopes)


class _End(NamedTuple):
    """A value at which an equilibrium (m,) is known, just before it ends."""

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
    apart = np.isnan(moves) | (moves > JUMP_FACTOR * np.nanmedian(moves)) if not gone.all() else gone[1:]
    for i in np.flatnonzero(apart & ~(gone[1:] & gone[:-1])):
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
        at = equilibrium_derivatives(flow, x, numbers)
        found = flow_derivatives(flow)
        curved, mixed = np.zeros((m, m)), np.zeros(m)
        i, j, k = found.second.places.T
        np.add.at(curved, (i, k), found.second.at(x, numbers) * right[j])
        i, j, k = found.mixed.places.T
        np.add.at(mixed, i, np.where(k == place, found.mixed.at(x, numbers) * right[j], 0.0))
        system = np.zeros((2 * m + 1, 2 * m + 1))
        system[:m, :m], system[:m, -1] = at.matrix, at.by_parameter[:, place]
        system[m:-1, :m], system[m:-1, m:-1], system[m:-1, -1] = curved, at.matrix, mixed
        system[-1, m:-1] = row
        missed = np.concatenate([flow.rhs(x, numbers), at.matrix @ right, [row @ right - 1.0]])
        try:
            step = -np.linalg.solve(system, missed)
        except np.linalg.LinAlgError:
            return None
        x, right, numbers[place] = x + step[:m], right + step[m:-1], numbers[place] + step[-1]
        if np.abs(step[:m]).max() <= STEP_RTOL * size and abs(step[-1]) <= STEP_RTOL * abs(numbers[place]):
            break
    return (x, float(numbers[place])) if np.isfinite(x).all() else None
