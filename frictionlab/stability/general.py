"""Zeros of any flow: Newton's method, led to them by continuation from several starts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .flow import Flow

Array = NDArray[np.float64]
STARTS, STEPS, NEWTON, FINISH = 128, 16, 8, 40
DECADES = 5.0  # by which half of the starts may differ from the linearised flow's zero
SHRINK = 0.25
CLOSE, ROUNDING = 1e-9, 1e-14  # of the state and of its size: what a last step may still change
ALIKE = 1e3  # times that: zeros so close are one
EPSILON = float(np.finfo(float).eps)


def rest_points(flow: Flow, values: Sequence[float]) -> Array:
    """The zeros (m, K) that are found, each once, by their distance from the origin.

    From each start x0 the zeros of f(x) - (1 - s) f(x0) are followed from s = 0 to 1 (Newton homotopy).
    """
    if _always_moves(flow, values):
        return np.zeros((len(flow.states), 0))
    with np.errstate(all="ignore"):  # a path may leave the range of floats; it is dropped then
        x, scale = _starts(flow, values)
        rest = flow.rhs(x, values)
        for s in np.linspace(0, 1, STEPS + 1)[1:]:
            x = _newton(flow, x, values, (1 - s) * rest)
        x = _newton(flow, x, values, 0.0, FINISH)
        return _distinct(x[:, _solved(flow, x, values, scale)], scale[:, 0])


def continued(flow: Flow, x: Array, base: Sequence[float], values: Sequence[Any], count: int) -> Array:
    """Zeros (m, count) for other values of the parameters, followed from `x` (m,) at `base`; NaN if lost."""
    found = np.repeat(x[:, None], count, axis=1)
    with np.errstate(all="ignore"):
        first = newton_step(flow, found, values, 0.0)
        second = newton_step(flow, found + first, values, 0.0)
        # Steps that shrink fast are safe (Newton-Kantorovich); otherwise in smaller changes of parameters.
        safe = np.abs(second).max(axis=0) <= SHRINK * np.abs(first).max(axis=0)
        steps = 1 if safe.all() else STEPS
        for s in np.linspace(0, 1, steps + 1)[1:]:
            between = [b if np.ndim(v) == 0 and v == b else b + s * (v - b) for b, v in zip(base, values)]
            found = _newton(flow, found, between, 0.0)
        scale = _positive(np.abs(x)[:, None] + np.abs(first))
        found[:, ~_solved(flow, found, values, scale)] = np.nan
    return found


def _always_moves(flow: Flow, values: Sequence[float]) -> bool:
    """Whether a state changes at a rate that no state has a part in, as time does."""
    rates = flow.rhs(np.zeros(len(flow.states)), values)
    return bool((rates[flow.free] != 0).any())


def _starts(flow: Flow, values: Sequence[float]) -> tuple[Array, Array]:
    """The origin and points scattered about it (m, STARTS), and sizes of the states (m, 1).

    The origin alone where the flow is linear: there is no other zero to be led to.

    The sizes are where the linearised flow's zero lies.  Half of the points lie further in and out too,
    for zeros that it does not know of.
    """
    origin = np.zeros((len(flow.states), 1))
    scale = _positive(np.abs(newton_step(flow, origin, values, 0.0)))
    if flow.linear:
        return origin, scale
    random = np.random.default_rng(0)
    scatter = random.normal(size=(len(origin), STARTS - 1))
    scatter[:, ::2] *= 10.0 ** random.uniform(-DECADES, DECADES, size=scatter[:, ::2].shape)
    return np.hstack([origin, 2 * scale * scatter]), scale


def _positive(sizes: Array) -> Array:
    """Sizes (m, N) with the largest of its column for one that is zero or unknown; 1 where all are."""
    known = np.where(np.isfinite(sizes), sizes, 0.0)
    largest = known.max(axis=0)
    return np.where(known > 0, known, np.where(largest > 0, largest, 1.0))


def _newton(flow: Flow, x: Array, values: Sequence[Any], target: Any, most: int = NEWTON) -> Array:
    for _ in range(most):
        step = newton_step(flow, x, values, target)
        x = x + step
        if not (np.abs(step) > EPSILON * np.abs(x)).any():
            break
    return x


def newton_step(flow: Flow, x: Array, values: Sequence[Any], target: Any) -> Array:
    """The step (m, N) towards rhs = target; NaN where the flow is not finite."""
    with np.errstate(all="ignore"):
        matrices, rest = flow.jacobian(x, values), flow.rhs(x, values) - target
    usable = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(rest).all(axis=0)
    step = np.full_like(x, np.nan)
    step[:, usable] = -_solution(matrices[usable], rest.T[usable, :, None])[..., 0].T
    return step


def _solution(matrices: Array, right: Array) -> Any:
    try:
        return np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:  # singular, as at a fold
        return np.linalg.pinv(matrices) @ right


def _solved(flow: Flow, x: Array, values: Sequence[Any], scale: Array) -> Any:
    """Where Newton's method has nothing left to do, and not because it is stuck at a singular matrix."""
    size = np.fmax(np.abs(x), scale)
    forces = (np.abs(flow.jacobian(x, values)) @ size.T[:, :, None])[:, :, 0].T
    left = np.abs(flow.rhs(x, values)) <= CLOSE * forces
    step = np.abs(newton_step(flow, x, values, 0.0))
    return left.all(axis=0) & (step <= CLOSE * np.abs(x) + ROUNDING * scale).all(axis=0)


def _distinct(x: Array, scale: Array) -> Array:
    kept: list[Array] = []
    for column in x[:, np.argsort(np.linalg.norm(x, axis=0))].T:
        bounds = (CLOSE * np.fmax(np.abs(column), np.abs(other)) + ROUNDING * scale for other in kept)
        if all((np.abs(column - o) > ALIKE * bound).any() for o, bound in zip(kept, bounds)):
            kept.append(column)
    return np.array(kept).reshape(-1, len(x)).T
