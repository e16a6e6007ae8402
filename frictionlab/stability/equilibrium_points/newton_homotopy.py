"""Zeros of any flow: Newton's method from starts in all decades, and zeros followed through parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.flow import Flow
from frictionlab.stability.state_matrices import MACHINE_EPSILON

from .newton_zeros import (
    LAST_STEP_RTOL,
    SCALE_ROUNDING,
    distinct_zeros,
    newton_step,
    polish_zeros,
    solve_matrices,
)

Array = NDArray[np.float64]
START_COUNT, SEARCH_STEPS = 192, 64  # starting points, and steps from each
START_DECADES = 15.0  # by which a state may differ from the linearised flow's zero
RESTART_ROUNDS = 8  # of starts from what is found
RESTART_DECADES = (-9.0, 2.0)  # of the distances of these starts from it
HOMOTOPY_STEPS, CORRECTOR_STEPS = 16, 8
SAFE_CONTRACTION = 0.25


def find_zeros(flow: Flow, values: Sequence[float]) -> Array:
    """The zeros (m, K) found, each once, by their distance from the origin.

    Newton's method leads to a zero from within some factor of it, so the starts lie in all decades.  Where
    several coordinates have several zeros each, few starts are near to all combinations: so it starts again
    from what is found until that finds nothing more.
    """
    if _has_no_zero(flow, values):
        return np.zeros((len(flow.states), 0))
    with np.errstate(all="ignore"):  # a start may lead out of the range of floats; it is dropped then
        random = np.random.default_rng(0)
        x, scale = _starts(flow, values, random)
        found = _zeros_from(flow, values, x, scale)
        for _ in range(0 if flow.linear else RESTART_ROUNDS):
            before = found.shape[1]
            found = _zeros_from(
                flow, values, np.hstack([found, _restart_points(flow, values, found, random)]), scale
            )
            if not before < found.shape[1] < START_COUNT:  # no new zeros, or a continuum of zeros
                break
    return found


def _zeros_from(flow: Flow, values: Sequence[float], x: Array, scale: Array) -> Array:
    """The zeros that Newton's method finds from the starts."""
    return distinct_zeros(*polish_zeros(flow, _search(flow, x, values), values, scale))


def _restart_points(flow: Flow, values: Sequence[float], found: Array, random: np.random.Generator) -> Array:
    """Starting points (m, 2 START_COUNT) for zeros that are hard to find from afar, made of the zeros found;
    none without these.

    Some have each coordinate about that of one zero or another.  At the others one rate alone is not zero, to
    first order, so that Newton's method looks for other zeros of that rate with the others kept.
    """
    rows, count = found.shape
    if not count:
        return found
    away = random.normal(size=(rows, START_COUNT)) * 10.0 ** random.uniform(
        *RESTART_DECADES, size=START_COUNT
    )
    combined = np.take_along_axis(found, random.integers(count, size=(rows, START_COUNT)), axis=1) * (
        1 + away
    )
    base, rate = found[:, random.integers(count, size=START_COUNT)], random.integers(rows, size=START_COUNT)
    only = solve_matrices(flow.jacobian(base, values), np.eye(rows)[rate][:, :, None])[:, :, 0].T
    length = np.abs(base).max(axis=0) / np.abs(only).max(axis=0)
    return np.hstack([combined, base + away[0] * length * only])


def follow_zero(flow: Flow, x: Array, base: Sequence[float], values: Sequence[Any], count: int) -> Array:
    """Zeros (m, count) for other values of the parameters, followed from `x` (m,) at `base`; NaN if lost."""
    found = np.repeat(x[:, None], count, axis=1)
    with np.errstate(all="ignore"):
        first = newton_step(flow, found, values)
        second = newton_step(flow, found + first, values)
        # Steps that shrink fast are safe (Newton-Kantorovich); otherwise the change of parameters is divided.
        safe = np.abs(second).max(axis=0) <= SAFE_CONTRACTION * np.abs(first).max(axis=0)
        steps = 1 if safe.all() else HOMOTOPY_STEPS
        for s in np.linspace(0, 1, steps + 1)[1:]:
            between = [b if np.ndim(v) == 0 and v == b else b + s * (v - b) for b, v in zip(base, values)]
            found = _newton(flow, found, between)
        scale = _replace_unknown(np.abs(x)[:, None] + np.abs(first))
        found[:, ~_is_solved(flow, found, values, scale)] = np.nan
    return found


def _has_no_zero(flow: Flow, values: Sequence[float]) -> bool:
    """Whether some rate is a constant that is not zero, as that of time, so that the flow has no zero."""
    rates = flow.rhs(np.zeros(len(flow.states)), values)
    return bool((rates[flow.free] != 0).any())


def _starts(flow: Flow, values: Sequence[float], random: np.random.Generator) -> tuple[Array, Array]:
    """The origin and points scattered about it (m, START_COUNT), and sizes of the states (m, 1).

    The origin alone where the flow is linear: there is no other zero to be led to.

    The sizes are where the linearised flow's zero lies.  The points lie in all decades about them: half of
    them in one decade with all their coordinates, the others with each in one of its own.
    """
    origin = np.zeros((len(flow.states), 1))
    scale = _replace_unknown(np.abs(newton_step(flow, origin, values)))
    if flow.linear:
        return origin, scale
    scatter = random.normal(size=(len(origin), START_COUNT))
    scatter[:, ::2] *= 10.0 ** random.uniform(-START_DECADES, START_DECADES, size=scatter[:, ::2].shape)
    scatter[:, 1::2] *= 10.0 ** random.uniform(-START_DECADES, START_DECADES, size=scatter[0, 1::2].shape)
    scatter[flow.unseen] = 0.0  # any value of these does
    return np.hstack([origin, scale * scatter]), scale


def _replace_unknown(sizes: Array) -> Array:
    """Sizes (m, N) with the largest of its column for one that is zero or unknown; 1 where all are."""
    known = np.where(np.isfinite(sizes), sizes, 0.0)
    largest = known.max(axis=0)
    return np.where(known > 0, known, np.where(largest > 0, largest, 1.0))


def _newton(flow: Flow, x: Array, values: Sequence[Any]) -> Array:
    """Newton's method for each column until it has converged."""
    for _ in range(CORRECTOR_STEPS):
        step = newton_step(flow, x, values)
        x = x + step
        if not (np.abs(step) > MACHINE_EPSILON * np.abs(x)).any():
            break
    return x


def _search(flow: Flow, x: Array, values: Sequence[float]) -> Array:
    """The same from all starts, dropping those that have converged or left the range of floats."""
    x, going = x.copy(), np.arange(x.shape[1])
    for _ in range(SEARCH_STEPS):
        step = newton_step(flow, x[:, going], values)
        x[:, going] += step
        going = going[
            (np.abs(step) > LAST_STEP_RTOL * np.abs(x[:, going])).any(axis=0) & np.isfinite(step).all(axis=0)
        ]
        if not going.size:
            break
    return x


def _is_solved(flow: Flow, x: Array, values: Sequence[Any], scale: Array) -> Any:
    """Where Newton's method has converged, and is not stuck at a singular matrix."""
    size = np.fmax(np.abs(x), scale)
    forces = (np.abs(flow.jacobian(x, values)) @ size.T[:, :, None])[:, :, 0].T
    left = np.abs(flow.rhs(x, values)) <= LAST_STEP_RTOL * forces
    step = np.abs(newton_step(flow, x, values))
    return left.all(axis=0) & (step <= LAST_STEP_RTOL * np.abs(x) + SCALE_ROUNDING * scale).all(axis=0)
