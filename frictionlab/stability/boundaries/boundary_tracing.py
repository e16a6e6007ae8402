"""A stability boundary followed through a plane of two parameters, which is mapped to the unit square.

A growth rate, sorted by size among all, is a continuous function in the plane, with kinks where two modes
exchange their places.  So the next point is looked for on an arc around the last, which needs signs only.
All points are then moved onto the curve, along their normals, to rounding.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.state_matrices import growth_rates

Array = NDArray[np.float64]

STEP_RADIUS = 0.01  # of the step, where the plane is the unit square
SMALLEST_RADIUS = STEP_RADIUS / 256
CIRCLE_ANGLES = np.linspace(-np.pi, np.pi, 49)
ARC_ANGLES = CIRCLE_ANGLES[1:-1]  # all but the way back
STRAIGHT_TURN, SHARP_TURN = 0.3, 1.0  # turns, rad
NORMAL_SHARES = (0.1, 0.3, 1.0)  # of the step, from a rough point to the curve
MAX_CURVE_POINTS = 20_000


class ParameterPlane:
    """Sorted spectra over the unit square, which stands for the range of two parameters."""

    def __init__(self, problem: EquilibriumProblem, x: tuple[str, Array], y: tuple[str, Array]) -> None:
        self._problem, self._axes = problem, (x, y)

    def values(self, u: Array) -> Array:
        """The parameters (M, 2) at points (M, 2) of the square; by the grid's indices, so logarithmic grids
        are as good as even ones.  Beyond the square they are those at its edge.
        """
        columns = zip(u.T, self._axes)
        return np.stack(
            [np.interp(part * (len(grid) - 1), np.arange(len(grid)), grid) for part, (_, grid) in columns],
            axis=1,
        )

    def spectra(self, u: Array) -> Any:
        """Eigenvalues (M, m), the largest growth rate first."""
        at = self.values(u)
        return self._problem.spectra({name: column for (name, _), column in zip(self._axes, at.T)})

    def rate(self, u: Array, rank: Any) -> Array:
        """The `rank`-th largest growth rate at points (M, 2)."""
        spectra = self.spectra(u)
        # Without damping stable growth rates are zero exactly: they count as negative.
        rates = np.where(spectra.real == 0, growth_rates(spectra), spectra.real)
        return np.take_along_axis(rates, np.broadcast_to(rank, len(rates))[:, None], axis=1)[:, 0]


def zeros_on_segments(plane: ParameterPlane, low: Array, high: Array, ranks: Any) -> Array:
    """Where growth rates are zero between two points each, to rounding; NaN if they do not change sign."""

    def rate(share: Array, *rest: Array) -> Array:
        a, b, rank = np.stack(rest[:2], axis=1), np.stack(rest[2:4], axis=1), rest[4].astype(int)
        return plane.rate(a + share[:, None] * (b - a), rank)

    ends = (np.zeros(len(low)), np.ones(len(low)))
    found = find_root(rate, ends, args=(*low.T, *high.T, np.broadcast_to(ranks, len(low))))
    share = np.where(found.success, found.x, np.nan)
    return low + share[:, None] * (high - low)


def trace_curve(plane: ParameterPlane, seed: Array, rank: int) -> Array:
    """The curve (k, 2) through a seed point on it, within the square."""
    forward = _follow(plane, seed, rank, 1)
    if len(forward) > 3 and np.hypot(*(forward[-1] - seed)) < STEP_RADIUS:  # closed
        loop = _project_onto_curve(plane, np.vstack([forward, seed]), rank)
        again = np.hypot(*(loop[-1] - loop[0])) < SMALLEST_RADIUS
        return np.vstack([loop[:-1] if again else loop, loop[:1]])
    return _project_onto_curve(plane, np.vstack([_follow(plane, seed, rank, -1)[:0:-1], forward]), rank)


def _follow(plane: ParameterPlane, seed: Array, rank: int, side: int) -> Array:
    """Points from the seed on, with the growing side to the left (1) or right (-1), roughly on the curve."""
    path, radius, angles, heading = [seed], STEP_RADIUS, CIRCLE_ANGLES, 0.0
    while len(path) < MAX_CURVE_POINTS:
        turn = _turn(plane, path[-1], radius, heading + angles, rank, side)
        if turn is None or (abs(turn) > SHARP_TURN and len(path) > 1 and radius > SMALLEST_RADIUS):
            # Nothing, or a sharp bend: more closely, so that the tip of a sliver is rounded, not jumped.
            if radius <= SMALLEST_RADIUS:
                break
            radius /= 4
            continue
        heading, angles = heading + turn, ARC_ANGLES
        step = path[-1] + radius * np.array([np.cos(heading), np.sin(heading)])
        path.append(np.clip(step, 0.0, 1.0))
        if (step != path[-1]).any() and _leaves(plane, path[-1], rank):
            break
        if len(path) > 3 and np.hypot(*(path[-1] - seed)) < 0.9 * radius:
            break
        radius = min(2 * radius, STEP_RADIUS) if abs(turn) < STRAIGHT_TURN else radius
    return np.array(path)


def _turn(
    plane: ParameterPlane, centre: Array, radius: float, angles: Array, rank: int, side: int
) -> float | None:
    """Angle, relative to the middle of an arc, at which the curve crosses the arc; None where it ends."""
    circle = centre + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rates = side * plane.rate(circle, rank)
    enters = np.flatnonzero((rates[:-1] < 0) & (rates[1:] >= 0))
    if not enters.size:
        return None
    i = enters[np.argmin(np.abs(enters - len(angles) // 2))]
    share = rates[i] / (rates[i] - rates[i + 1])
    return float(angles[i] + share * (angles[i + 1] - angles[i]) - angles[len(angles) // 2])


def _leaves(plane: ParameterPlane, point: Array, rank: int) -> bool:
    """Whether the curve passes the edge of the square at a point there, rather than running along it."""
    along = ((point > 0) & (point < 1)).astype(float)
    nearby = np.clip(point + STEP_RADIUS * np.linspace(-1, 1, 17)[:, None] * along, 0.0, 1.0)
    rates = plane.rate(nearby, rank)
    return bool(np.isnan(rates).any() or (rates > 0).any() != (rates > 0).all())


def _project_onto_curve(plane: ParameterPlane, path: Array, rank: int) -> Array:
    """The points moved onto the curve, along its normal or along the edge of the square."""
    if len(path) < 2:
        return path
    along = np.gradient(path, axis=0)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    length = np.hypot(*normal.T)[:, None]
    normal = normal / np.where(length > 0, length, 1.0)
    at_edge = (path <= 0) | (path >= 1)
    normal[at_edge.any(axis=1)] = np.where(at_edge, 0.0, 1.0)[at_edge.any(axis=1)]
    # Within reach of the local step: beyond it another branch may pass.
    apart = np.hypot(*np.diff(path, axis=0).T)
    local = np.minimum(np.append(apart, np.inf), np.append(np.inf, apart))
    local = np.where(at_edge.any(axis=1), STEP_RADIUS, local)[:, None]
    moved = np.full_like(path, np.nan)
    for share in NORMAL_SHARES:
        left = np.isnan(moved[:, 0])
        low, high = (np.clip(path + s * share * local * normal, 0.0, 1.0)[left] for s in (-1, 1))
        moved[left] = zeros_on_segments(plane, low, high, rank)
        if not np.isnan(moved).any():
            break
    return moved[np.isfinite(moved[:, 0])]


def distance_to_curve(curve: Array, point: Array) -> float:
    """From a point to a chain of segments."""
    if len(curve) < 2:
        return np.inf
    step = np.diff(curve, axis=0)
    square = np.maximum((step**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((point - curve[:-1]) * step).sum(axis=1) / square, 0.0, 1.0)
    return float(np.hypot(*(curve[:-1] + share[:, None] * step - point).T).min())
