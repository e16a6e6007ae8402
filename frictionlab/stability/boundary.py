"""The curves in a plane of two parameters on which a growth rate is zero."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .follow import RADIUS, distance, traced
from .plane import Plane, on_segment
from .scan import growth, unstable_pairs
from .steady import Steady

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
PASSED = 0.1 * RADIUS  # a point this near to a curve lies on it
JUMP = 1e-6  # as in changes.py


@dataclass(frozen=True, eq=False)
class Boundary:
    """A curve on which one growth rate is zero.

    Parameters
    ----------
    points : array (k, 2)
        Values of the two parameters.
    frequencies : array (k,)
        Of the mode, Hz; zero for divergence, NaN where the equilibrium ends and another takes over.
    unstable : (int, int)
        Number of growing pairs of eigenvalues on the two sides, the smaller first.
    """

    points: Array
    frequencies: Array
    unstable: tuple[int, int]


def boundaries(
    view: Steady, x: tuple[str, Array], y: tuple[str, Array], spectra: Any
) -> tuple[Boundary, ...]:
    """All curves that pass between neighbours on the grid; `spectra` (ny, nx, m) are those on it."""
    plane = Plane(view, x, y)
    seeds, levels = _seeds(plane, spectra)
    found: list[Boundary] = []
    while len(seeds):
        level = int(levels[0])
        curve = traced(plane, seeds[0], level)
        passed = (levels == level) & np.array([distance(curve, seed) < PASSED for seed in seeds])
        passed[0] = True
        seeds, levels = seeds[~passed], levels[~passed]
        found += _described(plane, curve, level)
    return tuple(_without_doubles(found))


def _seeds(plane: Plane, spectra: Any) -> tuple[Array, Indices]:
    """Points of the curves on the edges between grid points, and which growth rate is zero there."""
    found = [*_edges(spectra, 0), *_edges(spectra, 1)]
    if not found:
        return np.zeros((0, 2)), np.zeros(0, dtype=np.intp)
    low, high, levels = (np.array(part) for part in zip(*found))
    return on_segment(plane, low, high, levels), levels


def _edges(spectra: Any, axis: int) -> Iterator[tuple[Array, Array, int]]:
    """Ends in the unit square of the grid's edges along an axis, wherever a mode begins to grow between."""
    counts = (growth(spectra) > 0).sum(axis=2)
    known = np.isfinite(spectra[..., 0])
    before, after = (np.delete(np.arange(counts.shape[axis]), end) for end in (-1, 0))
    differ = counts.take(before, axis) != counts.take(after, axis)
    both = known.take(before, axis) & known.take(after, axis)
    scale = np.array(counts.shape)[::-1] - 1
    for row, column in np.argwhere(differ & both):
        a, b = (row, column), (row + 1 - axis, column + axis)
        for level in _levels(spectra, counts, a, b):
            yield np.array(a[::-1]) / scale, np.array(b[::-1]) / scale, level


def _levels(spectra: Any, counts: Any, a: tuple[int, int], b: tuple[int, int]) -> Iterator[int]:
    few, many = sorted((a, b), key=lambda place: counts[place])
    level = counts[few]
    while level < counts[many]:
        yield int(level)
        level += 1 if spectra[many][level].imag == 0 else 2  # a pair has two equal growth rates


def _described(plane: Plane, curve: Array, level: int) -> list[Boundary]:
    """The curve in pieces of one kind each: flutter, divergence, or the end of an equilibrium."""
    if len(curve) < 2:
        return []
    spectra = plane.spectra(curve)
    critical = spectra[:, level]
    frequencies = np.abs(critical.imag) / (2 * np.pi)
    frequencies[np.abs(critical.real) > JUMP * np.abs(spectra).max(axis=1)] = np.nan
    kinds = np.where(np.isnan(frequencies), 2, frequencies == 0)
    cuts = np.flatnonzero(np.diff(kinds)) + 1
    parts = zip(np.split(curve, cuts), np.split(frequencies, cuts))
    return [
        Boundary(plane.values(piece), hertz, _sides(plane, piece)) for piece, hertz in parts if len(piece) > 1
    ]


def _sides(plane: Plane, piece: Array) -> tuple[int, int]:
    """Growing pairs on the two sides of the middle of a curve."""
    i = len(piece) // 2
    step = piece[min(i + 1, len(piece) - 1)] - piece[i - 1]
    beside = piece[i] + 0.05 * np.array([[-step[1], step[0]], [step[1], -step[0]]])
    few, many = sorted(unstable_pairs(plane.spectra(beside)).tolist())
    return few, many


def _without_doubles(found: list[Boundary]) -> list[Boundary]:
    """Each curve once: the two growth rates of a pair vanish together, all at the end of an equilibrium."""
    kept: list[Boundary] = []
    size = np.ptp(np.vstack([c.points for c in found]), axis=0) if found else np.ones(2)
    size[size == 0] = 1.0
    for curve in sorted(found, key=lambda c: -len(c.points)):
        some = curve.points[:: max(1, len(curve.points) // 4)] / size
        alike = [c.points / size for c in kept if _kind(c) == _kind(curve)]
        if not any(all(distance(other, point) < PASSED for point in some) for other in alike):
            kept.append(curve)
    return kept


def _kind(curve: Boundary) -> int:
    middle = curve.frequencies[len(curve.frequencies) // 2]
    return 2 if np.isnan(middle) else int(middle > 0)
