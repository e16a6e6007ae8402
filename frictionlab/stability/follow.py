"""A curve on which a growth rate is zero, followed through a plane of two parameters.

A growth rate, sorted by size among all, is a continuous function in the plane, with kinks where two modes
exchange their places.  So the next point is looked for on an arc around the last: that needs signs only.
All points are then moved onto the curve, along their normals, to rounding.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .plane import Plane, on_segment

Array = NDArray[np.float64]
RADIUS = 0.01  # of the step, where the plane is the unit square
FINEST = RADIUS / 256
AROUND = np.linspace(-np.pi, np.pi, 49)
ARC = AROUND[1:-1]  # all but the way back
STRAIGHT, SHARP = 0.3, 1.0  # turns, rad
REACHES = (0.1, 0.3, 1.0)  # of the step, from a rough point to the curve
LONGEST = 20_000


def traced(plane: Plane, seed: Array, level: int) -> Array:
    """The curve (k, 2) through a point of it, within the square."""
    forward = _followed(plane, seed, level, 1)
    if len(forward) > 3 and np.hypot(*(forward[-1] - seed)) < RADIUS:  # closed
        loop = _onto(plane, np.vstack([forward, seed]), level)
        again = np.hypot(*(loop[-1] - loop[0])) < FINEST
        return np.vstack([loop[:-1] if again else loop, loop[:1]])
    return _onto(plane, np.vstack([_followed(plane, seed, level, -1)[:0:-1], forward]), level)


def _followed(plane: Plane, seed: Array, level: int, side: int) -> Array:
    """Points from the seed on, with the growing side to the left (1) or right (-1), roughly on the curve."""
    path, radius, angles, heading = [seed], RADIUS, AROUND, 0.0
    while len(path) < LONGEST:
        turn = _turn(plane, path[-1], radius, heading + angles, level, side)
        if turn is None or (abs(turn) > SHARP and len(path) > 1 and radius > FINEST):
            # Nothing, or a sharp bend: more closely, so that the tip of a sliver is rounded, not jumped.
            if radius <= FINEST:
                break
            radius /= 4
            continue
        heading, angles = heading + turn, ARC
        step = path[-1] + radius * np.array([np.cos(heading), np.sin(heading)])
        path.append(np.clip(step, 0.0, 1.0))
        if (step != path[-1]).any() and _leaves(plane, path[-1], level):
            break
        if len(path) > 3 and np.hypot(*(path[-1] - seed)) < 0.9 * radius:
            break
        radius = min(2 * radius, RADIUS) if abs(turn) < STRAIGHT else radius
    return np.array(path)


def _turn(plane: Plane, centre: Array, radius: float, angles: Array, level: int, side: int) -> float | None:
    """Angle from the middle one to that in which the curve leaves a circle; None where it ends."""
    circle = centre + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rates = side * plane.rate(circle, level)
    enters = np.flatnonzero((rates[:-1] < 0) & (rates[1:] >= 0))
    if not enters.size:
        return None
    i = enters[np.argmin(np.abs(enters - len(angles) // 2))]
    share = rates[i] / (rates[i] - rates[i + 1])
    return float(angles[i] + share * (angles[i + 1] - angles[i]) - angles[len(angles) // 2])


def _leaves(plane: Plane, point: Array, level: int) -> bool:
    """Whether the curve passes the edge of the square at a point there, rather than running along it."""
    along = ((point > 0) & (point < 1)).astype(float)
    nearby = np.clip(point + RADIUS * np.linspace(-1, 1, 17)[:, None] * along, 0.0, 1.0)
    rates = plane.rate(nearby, level)
    return bool(np.isnan(rates).any() or (rates > 0).any() != (rates > 0).all())


def _onto(plane: Plane, path: Array, level: int) -> Array:
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
    local = np.where(at_edge.any(axis=1), RADIUS, local)[:, None]
    moved = np.full_like(path, np.nan)
    for share in REACHES:
        left = np.isnan(moved[:, 0])
        low, high = (np.clip(path + s * share * local * normal, 0.0, 1.0)[left] for s in (-1, 1))
        moved[left] = on_segment(plane, low, high, level)
        if not np.isnan(moved).any():
            break
    return moved[np.isfinite(moved[:, 0])]


def distance(curve: Array, point: Array) -> float:
    """From a point to a chain of segments."""
    if len(curve) < 2:
        return np.inf
    step = np.diff(curve, axis=0)
    square = np.maximum((step**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((point - curve[:-1]) * step).sum(axis=1) / square, 0.0, 1.0)
    return float(np.hypot(*(curve[:-1] + share[:, None] * step - point).T).min())
