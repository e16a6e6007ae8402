"""`fl.stability_map`: the number of growing pairs over a plane of two parameters, and its exact boundary.

The boundary, curves on which a growth rate is zero, is found between neighbouring grid points, and followed
through the plane, which is mapped to the unit square.  A growth rate, sorted by size among all, is a
continuous function in the plane, with kinks where two modes exchange their places.  So the next point is
looked for on an arc around the last, which needs signs only.  All points are then moved onto the curve, along
their normals, to rounding.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from frictionlab.interruption import progress_bar
from frictionlab.models.composition import parameter_unit
from frictionlab.models.model import ModelOrAutomaton
from frictionlab.presentation import Drawable, count, dataframe, dataset, span
from frictionlab.stability.boundaries.stability_changes import FOLD_RATE_AT_ROOT
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_problem import check_axis
from frictionlab.stability.large_system import LargeSystem, SpectraOf
from frictionlab.stability.state_matrices import growth_rates, unstable_pairs
from frictionlab.validation import abbreviate, check_flag, explains_keywords

Array = NDArray[np.float64]
NO_EQUILIBRIUM = -1
GRID_CHUNK = 4096  # grid points between two updates of the progress bar
STEP_RADIUS = 0.01  # of a step along a curve, in the unit square
SMALLEST_RADIUS = STEP_RADIUS / 256
CIRCLE_ANGLES = np.linspace(-np.pi, np.pi, 49)
ARC_ANGLES = CIRCLE_ANGLES[1:-1]  # all but the way back
STRAIGHT_TURN, SHARP_TURN = 0.3, 1.0  # turns, rad
NORMAL_SHARES = (0.1, 0.3, 1.0)  # of the step, from a rough point to the curve
MAX_CURVE_POINTS = 20_000
SAME_CURVE_DISTANCE = 0.1 * STEP_RADIUS  # a point this near to a curve lies on it


@dataclass(frozen=True, eq=False)
class StabilityMap(Drawable):
    """Stability of the sliding equilibrium over a grid of two parameters.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x, y : str
        The parameters.
    x_values, y_values : array (nx,), (ny,)
    unstable : int array (ny, nx)
        Number of growing pairs of eigenvalues, two real ones or one alone counting as a pair; -1 where
        there is no equilibrium.
    growth : array (ny, nx)
        Largest growth rate, 1/s; NaN where there is no equilibrium.
    boundary : tuple of Boundary
        The curves on which a growth rate is zero, to rounding.
    """

    drawn_by = "plot_stability_map"

    model: ModelOrAutomaton
    x: str
    y: str
    x_values: Array
    y_values: Array
    unstable: NDArray[np.int_]
    growth: Array
    boundary: tuple[Boundary, ...]

    def to_dataframe(self) -> Any:
        """One row for each point of the grid, as a pandas DataFrame (needs the extra ``data``)."""
        columns = {"unstable": self.unstable.ravel(), "growth": self.growth.ravel()}
        up, across = np.meshgrid(self.y_values, self.x_values, indexing="ij")
        return dataframe(columns, {self.y: up.ravel(), self.x: across.ravel()}, self._units())

    def to_xarray(self) -> Any:
        """The grid as an xarray Dataset (needs the extra ``data``), with the parameters as dimensions."""
        plane = (self.y, self.x)
        variables = {"unstable": (plane, self.unstable), "growth": (plane, self.growth)}
        return dataset(variables, {self.y: self.y_values, self.x: self.x_values}, self._units())

    def _units(self) -> dict[str, str]:
        return {name: parameter_unit(self.model, name) for name in (self.x, self.y)} | {"growth": "1/s"}

    def __repr__(self) -> str:
        axes = ", ".join(
            f"{name} {span(values)} in {count(len(values), 'value')}"
            for name, values in ((self.x, self.x_values), (self.y, self.y_values))
        )
        stable = f"stable at {int((self.unstable == 0).sum())} of {self.unstable.size}"
        curves = f"{len(self.boundary)} boundary curve{'' if len(self.boundary) == 1 else 's'}"
        return f"StabilityMap({axes}; {stable}, {curves})"


@explains_keywords
def stability_map(
    model: ModelOrAutomaton,
    x: tuple[str, Any],
    y: tuple[str, Any],
    *,
    progress: bool = True,
) -> StabilityMap:
    """Number of growing pairs and largest growth rate over a grid, and the curves between.

    The curves start where neighbours on the grid differ, and are followed from there; one that closes
    between the points of the grid is missed.

    Parameters
    ----------
    model : Model, HybridAutomaton or Structure
        A structure of more than 50 freedoms is reduced first, to modes at some points of the plane.
    x, y : (str, array_like)
        Two parameters and their values, ascending, two at least.
    progress : bool
        Show a progress bar where it takes more than a second.

    Returns
    -------
    StabilityMap

    Raises
    ------
    TypeError
        For an unknown parameter, or what is no model.
    ValueError
        For a value that breaks its rule, or values that do not ascend.

    Examples
    --------
    >>> import frictionlab as fl
    >>> plane = fl.stability_map(fl.SliderOnBelt(), ("F", [100, 500, 1000]), ("mu_k", [0.5, 1.5]))
    >>> plane.unstable.tolist()
    [[0, 0, 0], [0, 1, 1]]
    """
    check_flag("progress", progress)
    across, up = (check_axis(model, which, axis) for which, axis in (("x", x), ("y", y)))
    if across[0] == up[0]:
        raise ValueError(f"x and y must be different parameters, got {abbreviate(x[0])} twice: change one")
    source: SpectraOf
    if isinstance(model, LargeSystem):
        source = model.spectra_over({name: (at[0], at[-1]) for name, at in (across, up)})
    else:
        source = equilibrium_problem(model, within=dict([across, up]))
    spectra = _spectra_on_grid(source, across, up, progress)
    growing = np.where(np.isnan(spectra[..., 0]), NO_EQUILIBRIUM, unstable_pairs(spectra))
    curves = boundary_curves(source, across, up, spectra)
    return StabilityMap(model, across[0], up[0], across[1], up[1], growing, spectra[..., 0].real, curves)


def _spectra_on_grid(problem: SpectraOf, x: tuple[str, Array], y: tuple[str, Array], progress: bool) -> Any:
    """Sorted spectra (ny, nx, m)."""
    across, up = (plane.ravel() for plane in np.meshgrid(x[1], y[1]))
    starts = progress_bar(range(0, len(up), GRID_CHUNK), "stability map", shown=progress)
    parts = [
        problem.spectra({x[0]: across[i : i + GRID_CHUNK], y[0]: up[i : i + GRID_CHUNK]}) for i in starts
    ]
    return np.concatenate(parts).reshape(len(y[1]), len(x[1]), -1)


class ParameterPlane:
    """Sorted spectra over the unit square, which stands for the range of two parameters."""

    def __init__(self, problem: SpectraOf, x: tuple[str, Array], y: tuple[str, Array]) -> None:
        self._problem, self._axes = problem, (x, y)

    def values(self, u: Array) -> Array:
        """The parameters (M, 2) at points (M, 2) of the square, interpolated by the grid's indices:
        logarithmic grids are as good as even ones.  Beyond the square they are those at its edge.
        """
        columns = zip(u.T, self._axes)
        return np.column_stack(
            [np.interp(part * (len(grid) - 1), np.arange(len(grid)), grid) for part, (_, grid) in columns]
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
    root = find_root(rate, ends, args=(*low.T, *high.T, np.broadcast_to(ranks, len(low))))
    share = np.where(root.success, root.x, np.nan)
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
    """Points roughly on the curve, from the seed on, with the growing side to the left (1) or right (-1)."""
    path, radius, angles, heading = [seed], STEP_RADIUS, CIRCLE_ANGLES, 0.0
    while len(path) < MAX_CURVE_POINTS:
        turn = _turn(plane, path[-1], radius, heading + angles, rank, side)
        if turn is None or (abs(turn) > SHARP_TURN and len(path) > 1 and radius > SMALLEST_RADIUS):
            # No crossing, or a sharp bend: with shorter steps the tip of a sliver is rounded, not jumped.
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
    """Whether the curve leaves the square at a point on its edge, rather than running along the edge."""
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
    # Not farther than the local step: beyond it another branch may pass.
    spacing = np.hypot(*np.diff(path, axis=0).T)
    local = np.minimum(np.append(spacing, np.inf), np.append(np.inf, spacing))
    local = np.where(at_edge.any(axis=1), STEP_RADIUS, local)[:, None]
    on_curve = np.full_like(path, np.nan)
    for share in NORMAL_SHARES:
        left = np.isnan(on_curve[:, 0])
        low, high = (np.clip(path + s * share * local * normal, 0.0, 1.0)[left] for s in (-1, 1))
        on_curve[left] = zeros_on_segments(plane, low, high, rank)
        if not np.isnan(on_curve).any():
            break
    return on_curve[np.isfinite(on_curve[:, 0])]


def distance_to_curve(curve: Array, point: Array) -> float:
    """Distance from a point to a chain of segments."""
    if len(curve) < 2:
        return np.inf
    step = np.diff(curve, axis=0)
    square = np.maximum((step**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((point - curve[:-1]) * step).sum(axis=1) / square, 0.0, 1.0)
    return float(np.hypot(*(curve[:-1] + share[:, None] * step - point).T).min())


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

    def __repr__(self) -> str:
        low, high = self.unstable
        where = f"{count(len(self.points), 'point')} at {span(self.frequencies)} Hz"
        return f"Boundary({where}, between {low} and {count(high, 'growing pair')})"


def boundary_curves(
    problem: SpectraOf, x: tuple[str, Array], y: tuple[str, Array], spectra: Any
) -> tuple[Boundary, ...]:
    """All curves that pass between neighbours on the grid; `spectra` (ny, nx, m) are those on it."""
    plane = ParameterPlane(problem, x, y)
    seeds, ranks = _seed_points(plane, spectra)
    boundaries: list[Boundary] = []
    while len(seeds):
        rank = int(ranks[0])
        curve = trace_curve(plane, seeds[0], rank)
        distances = np.array([distance_to_curve(curve, seed) for seed in seeds])
        passed = (ranks == rank) & (distances < SAME_CURVE_DISTANCE)
        passed[0] = True
        seeds, ranks = seeds[~passed], ranks[~passed]
        boundaries += _describe_curve(plane, curve, rank)
    return tuple(_distinct_curves(boundaries))


def _seed_points(plane: ParameterPlane, spectra: Any) -> tuple[Array, NDArray[np.intp]]:
    """Points of the curves on the edges between grid points, and which growth rate is zero there."""
    edges = [*_edges(spectra, 0), *_edges(spectra, 1)]
    if not edges:
        return np.zeros((0, 2)), np.zeros(0, dtype=np.intp)
    low, high, ranks = (np.array(part) for part in zip(*edges))
    return zeros_on_segments(plane, low, high, ranks), ranks


def _edges(spectra: Any, axis: int) -> Iterator[tuple[Array, Array, int]]:
    """Ends of the grid's edges along an axis on which modes begin to grow, and which growth rate is zero."""
    counts = (growth_rates(spectra) > 0).sum(axis=2)
    finite = np.isfinite(spectra[..., 0])
    before, after = (np.delete(np.arange(counts.shape[axis]), end) for end in (-1, 0))
    differ = counts.take(before, axis) != counts.take(after, axis)
    both = finite.take(before, axis) & finite.take(after, axis)
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


def _distinct_curves(curves: list[Boundary]) -> list[Boundary]:
    """Each curve once: both growth rates of a pair vanish on one curve, and all where an equilibrium ends."""
    distinct: list[Boundary] = []
    size = np.ptp(np.vstack([c.points for c in curves]), axis=0) if curves else np.ones(2)
    size[size == 0] = 1.0
    for curve in sorted(curves, key=lambda c: -len(c.points)):
        some = curve.points[:: max(1, len(curve.points) // 4)] / size
        alike = [c.points / size for c in distinct if _kind(c) == _kind(curve)]
        if not any(max(distance_to_curve(other, at) for at in some) < SAME_CURVE_DISTANCE for other in alike):
            distinct.append(curve)
    return distinct


def _kind(curve: Boundary) -> int:
    middle = curve.frequencies[len(curve.frequencies) // 2]
    return 2 if np.isnan(middle) else int(middle > 0)
