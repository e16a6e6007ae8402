"""Zeros of a flow polished by Newton's method down to rounding, and the uncertainty that rounding leaves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.flow import Flow
from frictionlab.stability.state_matrices import MACHINE_EPSILON

Array = NDArray[np.float64]
MAX_UNCERTAINTY = 1e-6  # share of a state: what may be unknown of it
LAST_STEP_RTOL = 1e-9  # share of a state: a step so short is the last
SCALE_ROUNDING = 1e-14  # of a state's usual size: what is smaller is rounding
MAX_POLISH_STEPS = 64
POLISH_CONTRACTION = 0.9  # a step that shrinks less than to this share of the last is rounding alone
NOISE_SAMPLES = 16  # states near a zero at which the rounding of the flow is seen
NOISE_DISTANCE = 1e-8  # share of a state: how far they are from the zero
ORIGIN_DISTANCE = 1e4  # times rounding, of the usual size: how far they are from a zero at the origin
# Relative change of the Jacobian from which on a flow's change is more than linear and rounding.
NONLINEARITY_RTOL = 1e-3
SAME_ZERO_FACTOR = 16.0  # times what is unknown of both: zeros so close are one


def newton_step(flow: Flow, x: Array, values: Sequence[Any]) -> Array:
    """The step (m, N) towards a zero; NaN where the flow is not finite."""
    with np.errstate(all="ignore"):
        matrices, rest = flow.jacobian(x, values), flow.rhs(x, values)
    usable = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(rest).all(axis=0)
    step = np.full_like(x, np.nan)
    step[:, usable] = -solve_matrices(matrices[usable], rest.T[usable, :, None])[..., 0].T
    return step


def solve_matrices(matrices: Array, right: Array) -> Any:
    """Solutions (N, m, k), of least length where a matrix is singular, as at a fold."""
    try:
        return np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:
        regular = np.linalg.slogdet(matrices).sign != 0
    found = np.linalg.pinv(matrices) @ right
    found[regular] = np.linalg.solve(matrices[regular], right[regular])
    return found


def polish_zeros(flow: Flow, x: Array, values: Sequence[Any], scale: Array) -> tuple[Array, Array]:
    """Those of the points (m, N) that Newton's method turns into zeros, and the uncertainty of each.

    The uncertainty is the effect of the flow's rounding on a zero, plus the last step: at a double zero,
    where steps are halved each time, that is the distance to it.  A zero so far out that rounding determines
    its place is too uncertain and left out.  `scale` (m, 1) is the scale of states that are zero.
    """
    x, step = _polish(flow, x[:, _is_near_zero(flow, x, values, scale)], values)
    noise, moved, terms = _rounding_noise(flow, x, values, scale)
    least = SCALE_ROUNDING * np.fmax(scale, terms)
    forces = _times(np.abs(flow.jacobian(x, values)), np.abs(x) + least)
    # At a singular matrix a step of zero does not mean a zero: the rates themselves have to vanish.
    solved = np.abs(flow.rhs(x, values)) <= np.fmax(LAST_STEP_RTOL * forces, SAME_ZERO_FACTOR * noise)
    settled = step <= np.fmax(LAST_STEP_RTOL * np.abs(x) + least, SAME_ZERO_FACTOR * moved)
    unknown = step + moved
    chosen = (solved & settled & (unknown <= MAX_UNCERTAINTY * np.abs(x) + least)).all(axis=0)
    return x[:, chosen], unknown[:, chosen]


def _is_near_zero(flow: Flow, x: Array, values: Sequence[Any], scale: Array) -> Any:
    """Where Newton's method has nearly converged."""
    least = SCALE_ROUNDING * np.fmax(scale, np.abs(x).max(axis=0))
    return (np.abs(newton_step(flow, x, values)) <= MAX_UNCERTAINTY * np.abs(x) + least).all(axis=0)


def _polish(flow: Flow, x: Array, values: Sequence[Any]) -> tuple[Array, Array]:
    """The points after Newton's steps, as long as these shrink, and the size of the next step."""
    step, active = newton_step(flow, x, values), np.ones(x.shape[1], dtype=bool)
    for _ in range(MAX_POLISH_STEPS):
        x = np.where(active, x + step, x)
        after = newton_step(flow, x, values)
        least, most = MACHINE_EPSILON * np.abs(x), POLISH_CONTRACTION * np.abs(step)
        shrinks = (np.abs(after) < most) & (np.abs(after) > least)
        step, active = after, active & shrinks.any(axis=0)
        if not active.any():
            break
    return x, np.abs(step)


def _rounding_noise(flow: Flow, x: Array, values: Sequence[Any], scale: Array) -> tuple[Array, Array, Array]:
    """The uncertainty of zeros (m, N) by the flow's rounding, which is sampled at neighbouring points.

    Also the size of the terms whose sum gives each state of a zero: larger than the state where they cancel.
    """
    matrices, random = flow.jacobian(x, values), np.random.default_rng(0)
    noise = np.zeros_like(x)
    for least in MACHINE_EPSILON * np.append(
        np.zeros(NOISE_SAMPLES), np.geomspace(1, ORIGIN_DISTANCE, NOISE_SAMPLES)
    ):
        way = random.uniform(-1, 1, size=(len(x), 1)) * (NOISE_DISTANCE * np.abs(x) + least * scale)
        ahead, back = x + way, x - way  # both, since curvature is no rounding
        linear = _times(matrices, ahead - back)
        missed = np.abs(flow.rhs(ahead, values) - flow.rhs(back, values) - linear)
        bend = np.abs(_times(flow.jacobian(ahead, values) - flow.jacobian(back, values), way))
        bent = bend > NONLINEARITY_RTOL * _times(
            np.abs(matrices), np.abs(way)
        )  # too far from a zero so near to the origin
        noise = np.where(bent & (least > 0), noise, np.fmax(noise, missed))
    inverse = np.abs(solve_matrices(matrices, np.broadcast_to(np.eye(len(x)), matrices.shape)))
    terms = _times(inverse, _times(np.abs(matrices), np.abs(x)))
    return noise, MACHINE_EPSILON * terms + _times(inverse, noise), terms


def _times(matrices: Array, x: Array) -> Array:
    """Products (m, N) of matrices (N, m, m) and columns."""
    return (matrices @ x.T[:, :, None])[:, :, 0].T


def distinct_zeros(x: Array, unknown: Array) -> Array:
    """Zeros (m, K), each once, by their distance from the origin; those within their uncertainty are one.

    Of two at the same distance but for rounding, as symmetric ones, that with the larger first state comes
    first.
    """
    kept: list[int] = []
    for i in np.argsort(np.linalg.norm(x, axis=0), kind="stable"):
        apart = np.abs(x[:, kept] - x[:, [i]])
        if (apart > SAME_ZERO_FACTOR * (unknown[:, kept] + unknown[:, [i]])).any(axis=0).all():
            kept.append(int(i))
    return x[:, sorted(kept, key=lambda i: (float(f"{np.linalg.norm(x[:, i]):.9e}"), *-x[:, i]))]
