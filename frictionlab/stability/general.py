"""Zeros of any flow: Newton's method, led to them by continuation from several starts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .flow import Flow

Array = NDArray[np.float64]
STARTS, STEPS, NEWTON = 64, 16, 8
CLOSE = 1e-9


def rest_points(flow: Flow, values: Sequence[float]) -> Array:
    """The zeros (m, K) that are found, each once, by their distance from the origin.

    From each start x0 the zeros of f(x) - (1 - s) f(x0) are followed from s = 0 to 1 (Newton homotopy).
    """
    x = _starts(flow, values)
    rest, typical = flow.rhs(x, values), float(np.abs(x).max())
    for s in np.linspace(0, 1, STEPS + 1)[1:]:
        x = _newton(flow, x, values, (1 - s) * rest)
    x = _newton(flow, x, values, 0.0)
    return _distinct(x[:, _solved(flow, x, values, typical)], typical)


def continued(flow: Flow, x: Array, base: Sequence[float], values: Sequence[Any], count: int) -> Array:
    """Zeros (m, count) for other values of the parameters, followed from `x` (m,) at `base`; NaN if lost."""
    found = np.repeat(x[:, None], count, axis=1)
    for s in np.linspace(0, 1, STEPS + 1)[1:]:
        between = [b if np.ndim(v) == 0 and v == b else b + s * (v - b) for b, v in zip(base, values)]
        found = _newton(flow, found, between, 0.0)
    typical = float(np.abs(found).max(initial=0.0, where=np.isfinite(found))) or 1.0
    found[:, ~_solved(flow, found, values, typical)] = np.nan
    return found


def _starts(flow: Flow, values: Sequence[float]) -> Array:
    """The origin, and points scattered about it as far as the linearised flow's zero lies."""
    origin = np.zeros((len(flow.states), 1))
    reach = np.abs(newton_step(flow, origin, values, 0.0))
    scale = np.where(reach > 0, reach, reach.max() or 1.0)
    scatter = np.random.default_rng(0).normal(size=(len(origin), STARTS - 1))
    return np.hstack([origin, 2 * scale * scatter])


def _newton(flow: Flow, x: Array, values: Sequence[Any], target: Any) -> Array:
    for _ in range(NEWTON):
        x = x + newton_step(flow, x, values, target)
    return x


def newton_step(flow: Flow, x: Array, values: Sequence[Any], target: Any) -> Array:
    """The step (m, N) towards rhs = target; NaN where the flow is not finite."""
    with np.errstate(all="ignore"):
        matrices, rest = flow.jacobian(x, values), flow.rhs(x, values) - target
    usable = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(rest).all(axis=0)
    step = np.full_like(x, np.nan)
    # By the pseudo-inverse: at a fold the matrix is singular.
    step[:, usable] = -(np.linalg.pinv(matrices[usable]) @ rest.T[usable, :, None])[..., 0].T
    return step


def _solved(flow: Flow, x: Array, values: Sequence[Any], typical: float) -> Any:
    """Where Newton's method has nothing left to do, by the measure of a typical state."""
    return np.abs(newton_step(flow, x, values, 0.0)).max(axis=0) <= CLOSE * typical


def _distinct(x: Array, typical: float) -> Array:
    kept: list[Array] = []
    for column in x[:, np.argsort(np.linalg.norm(x, axis=0))].T:
        if all(np.abs(column - other).max() > 1e-6 * typical for other in kept):
            kept.append(column)
    return np.array(kept).reshape(-1, len(x)).T
