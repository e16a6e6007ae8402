"""Outlines of springs and of a belt around two wheels."""

from __future__ import annotations

import numpy as np

from .windows import Array

TURNS = 6


def spring(start: tuple[float, float], end: tuple[float, float], width: float) -> Array:
    """A zigzag (2, 2 TURNS + 4) from `start` to `end`, straight at both ends."""
    a, b = np.array(start, dtype=float), np.array(end, dtype=float)
    along = np.r_[0.0, np.linspace(0.2, 0.8, 2 * TURNS + 2), 1.0]
    across = np.r_[0.0, 0.0, np.tile([1.0, -1.0], TURNS), 0.0, 0.0]
    way = b - a
    normal = np.array([-way[1], way[0]]) / (float(np.hypot(way[0], way[1])) or 1.0)
    return a[:, None] + way[:, None] * along + normal[:, None] * (width / 2 * across)


def around(distance: Array, wheels: tuple[float, float], radius: float) -> Array:
    """Points (2, P) of a belt at a distance (P,) along it, from its left upper end, clockwise.

    In the belt's own frame: the upper surface is at height zero, the wheels' centres are one radius below.
    """
    left, right = wheels
    straight, bend = left + right, np.pi * radius
    d = np.mod(distance, 2 * (straight + bend))
    first, second = (d - straight) / radius, (d - 2 * straight - bend) / radius
    top, bottom = d < straight, (d >= straight + bend) & (d < 2 * straight + bend)
    down = first < np.pi
    x = np.where(down, right + radius * np.sin(first), -left - radius * np.sin(second))
    y = np.where(down, radius * np.cos(first) - radius, -radius - radius * np.cos(second))
    x = np.where(top, d - left, np.where(bottom, right - (d - straight - bend), x))
    return np.array([x, np.where(top, 0.0, np.where(bottom, -2 * radius, y))])


def tilted(points: Array, x: float, y: float, slope: float) -> Array:
    """Points (2, P) of the belt's frame as seen from outside: turned to a slope, moved to (x, y)."""
    c, s = np.array([1.0, slope]) / np.hypot(1.0, slope)
    return np.array([[c, -s], [s, c]]) @ points + np.array([[x], [y]])
