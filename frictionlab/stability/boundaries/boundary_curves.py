"""The curves in a plane of two parameters on which a growth rate is zero, found between neighbouring grid
points.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.state_matrices import growth_rates, unstable_pairs

from .boundary_tracing import STEP_RADIUS, ParameterPlane, distance_to_curve, trace_curve, zeros_on_segments
from .stability_changes import FOLD_RATE_AT_ROOT

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
SAME_CURVE_DISTANCE = 0.1 * STEP_RADIUS  # a point this near to a curve lies on it


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


def boundary_curves(
    problem: EquilibriumProblem, x: tuple[str, Array], y: tuple[str, Array], spectra: Any
) -> tuple[Boundary, ...]:
    """All curves that pass between neighbours on the grid; `spectra` (ny, nx, m) are those on it."""
    plane = ParameterPlane(problem, x, y)
    seeds, ranks = _seed_points(plane, spectra)
    found: list[Boundary] = []
    while len(seeds):
        rank = int(ranks[0])
        curve = trace_curve(plane, seeds[0], rank)
        passed = (ranks == rank) & np.array(
            [distance_to_curve(curve, seed) < SAME_CURVE_DISTANCE for seed in seeds]
        )
        passed[0] = True
        seeds, ranks = seeds[~passed], ranks[~passed]
        found += _describe_curve(plane, curve, rank)
    return tuple(_distinct_curves(found))


def _seed_points(plane: ParameterPlane, spectra: Any) -> tuple[Array, Indices]:
    """Points of the curves on the edges between grid points, and which growth rate is zero there."""
    found = [*_edges(spectra, 0), *_edges(spectra, 1)]
    if not found:
        return np.zeros((0, 2)), np.zeros(0, dtype=np.intp)
    low, high, ranks = (np.array(part) for part in zip(*found))
    return zeros_on_segments(plane, low, high, ranks), ranks


def _edges(spectra: Any, axis: int) -> Iterator[tuple[Array, Array, int]]:
    """Ends in the unit square of the grid's edges along an axis, wherever a mode begins to grow between."""
    counts = (growth_rates(spectra) > 0).sum(axis=2)
    known = np.isfinite(spectra[..., 0])
    before, after = (np.delete(np.arange(counts.shape[axis]), end) for end in (-1, 0))
    differ = counts.take(before, axis) != counts.take(after, axis)
    both = known.take(before, axis) & known.take(after, axis)
    scale = np.array(counts.shape)[::-1] - 1
    for row, column in np.argwhere(differ & both):
        a, b = (row, column), (row + 1 - axis, column + axis)
        for rank in _levels(spectra, counts, a, b):
            yield np.array(a[::-1]) / scale, np.array(b[::-1]) / scale, rank


def _levels(spectra: Any, counts: Any, a: tuple[int, int], b: tuple[int, int]) -> Iterator[int]:
    few, many = sorted((a, b), key=lambda place: counts[place])
    rank = counts[few]
    while rank < counts[many]:
        yield int(rank)
        rank += 1 if spectra[many][rank].imag == 0 else 2  # a pair has two equal growth rates


def _describe_curve(plane: ParameterPlane, curve: Array, rank: int) -> list[Boundary]:
    """The curve, split into sections of one kind each: flutter, divergence, or the end of an equilibrium."""
    if len(curve) < 2:
        return []
    spectra = plane.spectra(curve)
    critical = spectra[:, rank]
    frequencies = np.abs(critical.imag) / (2 * np.pi)
    frequencies[np.abs(critical.real) > FOLD_RATE_AT_ROOT * np.abs(spectra).max(axis=1)] = np.nan
    kinds = np.where(np.isnan(frequencies), 2, frequencies == 0)
    cuts = np.flatnonzero(np.diff(kinds)) + 1
    parts = zip(np.split(curve, cuts), np.split(frequencies, cuts))
    return [
        Boundary(plane.values(piece), hertz, _unstable_on_sides(plane, piece))
        for piece, hertz in parts
        if len(piece) > 1
    ]


def _unstable_on_sides(plane: ParameterPlane, piece: Array) -> tuple[int, int]:
    """Growing pairs on the two sides of the middle of a curve."""
    i = len(piece) // 2
    step = piece[min(i + 1, len(piece) - 1)] - piece[i - 1]
    beside = piece[i] + 0.05 * np.array([[-step[1], step[0]], [step[1], -step[0]]])
    few, many = sorted(unstable_pairs(plane.spectra(beside)).tolist())
    return few, many


def _distinct_curves(found: list[Boundary]) -> list[Boundary]:
    """Each curve once: the two growth rates of a pair vanish together, all at the end of an equilibrium."""
    kept: list[Boundary] = []
    size = np.ptp(np.vstack([c.points for c in found]), axis=0) if found else np.ones(2)
    size[size == 0] = 1.0
    for curve in sorted(found, key=lambda c: -len(c.points)):
        some = curve.points[:: max(1, len(curve.points) // 4)] / size
        alike = [c.points / size for c in kept if _kind(c) == _kind(curve)]
        if not any(
            all(distance_to_curve(other, point) < SAME_CURVE_DISTANCE for point in some) for other in alike
        ):
            kept.append(curve)
    return kept


def _kind(curve: Boundary) -> int:
    middle = curve.frequencies[len(curve.frequencies) // 2]
    return 2 if np.isnan(middle) else int(middle > 0)
