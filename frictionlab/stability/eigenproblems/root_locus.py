"""`fl.root_locus`: the eigenvalues of every mode against a parameter, followed through crossings, veerings
and coalescence.

Neighbouring points of the path are compared by the products of left vectors at one with right vectors at the
other.  If their matrices are equal, these products form the unit matrix, however close the eigenvalues are.
So they can tell two modes apart that the usual modal assurance criterion (right vectors with right vectors)
finds alike.  If they do not, the step is halved.  So the result does not depend on the values asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from frictionlab.models.composition import parameter_unit
from frictionlab.models.model import Model, ModelOrAutomaton
from frictionlab.presentation import TIME, Drawable, count, dataframe, dataset, span
from frictionlab.stability.eigenproblems.eigenvalues import UNITS, mode_shapes, participation_factors
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_points.frozen_time import depends_on_time, frozen_in_time
from frictionlab.stability.equilibrium_problem import EquilibriumProblem, check_path
from frictionlab.stability.large_system import LargeSystem
from frictionlab.stability.state_matrices import (
    eigenpairs_of_matrices,
    eigenvalue_distances,
    equal_eigenvalues,
    left_eigenvectors,
    unstable_pairs,
)

Array = NDArray[np.float64]
ComplexMatrices = NDArray[np.complexfloating[Any, Any]]
ComplexArray = NDArray[np.complex128]
SAME_MODE, OTHER_MODE = 0.7, 0.4  # products of unit vectors that count as one mode, and as two
UNMOVED_SHARE = 0.1  # of the distance to other eigenvalues: a mode that moves less has hardly moved
OFFSET_SHARE = 1e-3  # of a step: so far away vectors are taken where eigenvalues are equal
ENCOUNTER_SHARE = 0.5  # of the way that two modes pass each other: if they come nearer they may have met
WEAK_COUPLING = 0.05  # of the distance at which they pass: a weaker coupling changes nothing
UNCOUPLED_RTOL = 1e-12  # share of the largest eigenvalue
RANK_WEIGHT, TINY_DISTANCE = 0.1, 1e-150
NARROWEST_STEP_RTOL = 1e-12  # share of the largest parameter: steps are not halved below
EXTRA_POINTS = 1000  # points that may be spent on halving steps
SPLIT_SHARE = 0.47  # not a half: crossings tend to lie at round values
NO_EIGENVALUE = complex(np.nan, np.nan)


@dataclass(frozen=True, eq=False)
class Modes:
    """One eigenvalue of every mode at N points of a path.

    Of a conjugate pair it is the one with Im > 0, of an overdamped mode's two real ones the less stable one.
    Where two modes that do not oscillate elsewhere are a pair, the second one has that with Im < 0.

    Parameters
    ----------
    at : array (N,)
        The points.
    values : complex array (N, k)
    right : complex array (N, m, k)
        Vectors of length 1.
    left : complex array (N, k, m)
        Left vectors, left @ right = 1.
    unstable : int array (N,)
        Number of growing pairs among all eigenvalues, including those left out here.
    """

    at: Array
    values: ComplexMatrices
    right: ComplexMatrices
    left: ComplexMatrices
    unstable: NDArray[np.int_]

    def __getitem__(self, index: Any) -> Modes:
        parts: Any = (self.at, self.values, self.right, self.left, self.unstable)
        return Modes(*(part[index] for part in parts))

    def permute(self, order: NDArray[np.intp]) -> Modes:
        """The same modes, in another order (N, k) at each point."""
        return Modes(
            self.at,
            np.take_along_axis(self.values, order, axis=1),
            np.take_along_axis(self.right, order[:, None, :], axis=2),
            np.take_along_axis(self.left, order[:, :, None], axis=1),
            self.unstable,
        )


def modes_along_path(at: Array, matrices: Callable[[Array], Array], further: Sequence[int]) -> Modes:
    """The modes of state matrices (N, m, m) at points (N,) of a path, each in one column throughout.

    Parameters
    ----------
    at : array (N,)
    matrices : callable
        Gives them at any points; NaN where there are no modes.
    further : sequence of int
        Places of the states that are neither coordinates nor their velocities.  Each makes a mode more.
    """
    path = _modes_of_matrices(at, matrices(at), further)
    k = path.values.shape[1]
    modes: Any = _track_modes(path, lambda points: _modes_of_matrices(points, matrices(points), further, k))
    modes.values[modes.values.imag < 0.0] = NO_EIGENVALUE
    return modes


def _modes_of_matrices(at: Array, matrices: Array, further: Sequence[int], k: int = 0) -> Modes:
    """The modes of state matrices (N, m, m), by ascending frequency; NaN where a matrix is not finite.

    There are k of them, or as many as at the point that has most.
    """
    finite, m = np.isfinite(matrices).all(axis=(1, 2)), matrices.shape[1]
    values, right = eigenpairs_of_matrices(matrices[finite])
    left = left_eigenvectors(matrices[finite], values, right)
    parts = np.abs(left * right.swapaxes(1, 2))
    shown = _is_shown(values, parts[..., further].sum(axis=-1) / parts.sum(axis=-1), len(further))
    k = k or int(shown.sum(axis=1).max(initial=0)) or (m + len(further)) // 2
    empty: Any = (np.full((len(at), *shape), NO_EIGENVALUE) for shape in ((k,), (m, k), (k, m)))
    modes = Modes(at, *empty, unstable=np.zeros(len(at), dtype=int))
    modes.unstable[finite] = unstable_pairs(values)
    # the others with Im < 0 and the lowest frequencies fill up
    order = np.lexsort((-values.real, -values.imag, values.imag == 0.0, ~shown), axis=-1)[:, :k]
    frequency = np.take_along_axis(values.imag, order, axis=1)
    order = np.take_along_axis(order, np.argsort(frequency, axis=1, kind="stable"), axis=1)
    modes.values[finite] = np.take_along_axis(values, order, axis=1)
    modes.right[finite] = np.take_along_axis(right, order[:, None, :], axis=2)
    modes.left[finite] = np.take_along_axis(left, order[:, :, None], axis=1)
    return modes


def _is_shown(values: ComplexMatrices, of_further: Array, further: int) -> NDArray[np.bool_]:
    """Which eigenvalues (N, m) stand for a mode: those with Im > 0, and real ones.

    Of these every second one is left out, from the largest on, beside those in which further states have the
    largest shares (N, m).  A pair that becomes two real eigenvalues gives two neighbours, and one of them
    stands for the mode.
    """
    rank = np.argsort(np.argsort(-of_further, axis=1, kind="stable"), axis=1)
    others = (values.imag == 0.0) & (rank >= further)
    order = np.lexsort((-values.real, ~others), axis=-1)
    number = np.argsort(order, axis=1)
    return (values.imag >= 0.0) & ~(others & (number % 2 == 1))


def _track_modes(path: Modes, sample: Callable[[Array], Modes]) -> Modes:
    """The same points with each mode in one column throughout; `sample` gives modes at further points."""
    parted = _separate_equal(path, sample)
    least = NARROWEST_STEP_RTOL * float(np.abs(path.at).max(initial=0.0))
    steps = _match_modes(parted[:-1], parted[1:], sample, least, [len(path.at) + EXTRA_POINTS])
    order = np.empty(path.values.shape, dtype=np.intp)
    order[:1] = np.arange(path.values.shape[1])
    for before, after, step in zip(order, order[1:], steps):
        after[:] = step[before]
    return parted.permute(order)


def _separate_equal(path: Modes, sample: Callable[[Array], Modes]) -> Modes:
    """If modes have equal eigenvalues, as at a crossing, take vectors from nearby.

    At the point itself the vectors are not unique.
    """
    step = np.diff(path.at, prepend=path.at[1:2])
    (alike,) = np.nonzero(equal_eigenvalues(path.values).any(axis=(1, 2)) & (step != 0))
    if not alike.size:
        return path
    nearby = sample(path.at[alike] - OFFSET_SHARE * step[alike])
    alike_still: Any = equal_eigenvalues(nearby.values).any(axis=(1, 2))
    for i, j in enumerate(alike):
        if np.isfinite(nearby.values[i]).all() and not alike_still[i]:
            path.values[j] = path.values[j][_match_eigenvalues(nearby.values[i], path.values[j])]
            path.right[j], path.left[j] = nearby.right[i], nearby.left[i]
    return path


def _match_modes(
    a: Modes, b: Modes, sample: Callable[[Array], Modes], least: float, left: list[int]
) -> NDArray[np.intp]:
    """For each mode of `a` the index of the same mode of `b`, (N, k); without modes the same index.

    Unclear steps are halved, down to the width `least`, and while there are points `left` to spend.  Two
    modes with one eigenvalue throughout would be unclear everywhere.
    """
    finite = np.isfinite(a.values[:, 0]) & np.isfinite(b.values[:, 0])
    if not finite.all():
        matching = np.tile(np.arange(a.values.shape[1]), (len(finite), 1))
        matching[finite] = _match_modes(a[finite], b[finite], sample, least, left)
        return matching
    matching = _assign(_likeness(a, b))
    clear, distinct = _is_clear(a, b.permute(matching))
    wide = ~(clear & distinct) & (np.abs(b.at - a.at) > least)
    if wide.any() and wide.sum() <= left[0]:
        left[0] -= int(wide.sum())
        middle = sample(a.at[wide] + SPLIT_SHARE * (b.at[wide] - a.at[wide]))
        first = _match_modes(a[wide], middle, sample, least, left)
        second = _match_modes(middle, b[wide], sample, least, left)
        matching[wide] = np.take_along_axis(second, first, axis=1)
        clear |= wide
    for i in np.flatnonzero(~clear):  # an exact coalescence: match eigenvalues, since the vectors are equal
        matching[i] = _match_eigenvalues(a.values[i], b.values[i])
    return matching


def _distance_to_next(values: ComplexMatrices) -> Array:
    """Distance of each eigenvalue (N, k) to the nearest other one."""
    distances = eigenvalue_distances(values, values)
    return np.where(np.eye(values.shape[1], dtype=bool), np.inf, distances).min(axis=2)


def _likeness(a: Modes, b: Modes) -> Array:
    """Similarity of the modes of `a` and `b` (N, k, k), whatever the lengths of their vectors."""
    return np.sqrt(np.abs(a.left @ b.right) * np.abs(np.swapaxes(b.left @ a.right, 1, 2)))


def _assign(likeness: Array) -> NDArray[np.intp]:
    """For each mode the index of the most similar one; each index is used once."""
    matching, each = likeness.argmax(axis=2), np.arange(likeness.shape[1])
    (twice,) = np.nonzero((np.sort(matching, axis=1) != each).any(axis=1))
    for i in twice:
        matching[i] = linear_sum_assignment(-likeness[i])[1]
    return matching


def _is_clear(a: Modes, b: Modes) -> tuple[Any, Any]:
    """Whether columns of `a` and `b` are clearly the same modes, and whether no two met in between."""
    either = equal_eigenvalues(a.values) & equal_eigenvalues(b.values)  # the order of these does not matter
    likeness, own = _likeness(a, b), np.eye(a.values.shape[1], dtype=bool)
    # A mode that is unlike all others is accepted if it has hardly moved: the vectors of a rigid body's
    # motion tell nothing.
    still = np.abs(a.values - b.values) < UNMOVED_SHARE * np.minimum(
        _distance_to_next(a.values), _distance_to_next(b.values)
    )
    same = (likeness > SAME_MODE) | either.any(axis=2, keepdims=True) | still[:, :, None]
    clear = np.where(own, same, either | (likeness < OTHER_MODE)).all(axis=(1, 2))
    return clear, ~(_may_have_met(a, b) & ~either).any(axis=(1, 2))


def _may_have_met(a: Modes, b: Modes) -> Any:
    """Which modes (N, k, k) may have met between `a` and `b`, with a coupling that matters.

    If two eigenvalues are d apart and the coupling is c, the vectors mix by c/d.  So d and the mixing give c.
    """
    start, end = (v[:, :, None] - v[:, None, :] for v in (a.values, b.values))
    way = np.maximum(np.abs(end - start), TINY_DISTANCE)
    share = np.clip(-((end - start).conj() / way * (start / way)).real, 0.0, 1.0)
    nearest = np.abs(start + share * (end - start))
    mixed = a.left @ b.right
    own = np.einsum("...ii->...i", mixed)
    with np.errstate(divide="ignore", invalid="ignore"):  # 0 where two coalesce: they have met
        mixing = np.abs(mixed * np.swapaxes(mixed, 1, 2) / (own[:, :, None] * own[:, None, :])) ** 0.5
    coupling = mixing * np.abs(start) * np.abs(end) / way
    largest = np.abs(a.values).max(axis=1, initial=0.0)[:, None, None]
    return (nearest < ENCOUNTER_SHARE * way) & ~(
        coupling <= np.maximum(UNCOUPLED_RTOL * largest, WEAK_COUPLING * nearest)
    )


def _match_eigenvalues(a: ComplexMatrices, b: ComplexMatrices) -> NDArray[np.intp]:
    """For each eigenvalue of `a` the index of its match in `b`, by their distances; each index is used once.

    If four distances are equal, as at a coalescence, the higher frequency goes with the larger growth.
    """
    distance, rank = np.abs(a[:, None] - b[None, :]), np.subtract.outer(a.real + a.imag, b.real + b.imag)
    return linear_sum_assignment(distance**2 + RANK_WEIGHT * rank**2)[1]


@dataclass(frozen=True, eq=False)
class RootLocus(Drawable):
    """Eigenvalues of k modes at N values of a parameter, each mode in one column.

    There is one for each of n coordinates, and one for each further state; two of these that are a pair at
    all values are one mode.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    at : array (N,)
        Its values.
    values : complex array (N, k)
        1/s, with Im >= 0; NaN where there is no equilibrium, outside the window of a structure, and for
        states of its open contacts.  Of an overdamped mode's two real eigenvalues it is the less stable one.
        Where two further states are a pair, one of two columns has NaN.
    coordinates : tuple of str
    shapes : complex array (N, n, k)
        Mode shapes: ``shapes[i, :, j]`` are the coordinates in mode j, the largest of them 1.
    participation : array (N, n, k)
        Share of each coordinate in each mode: ``participation[i, :, j]`` sums to 1.
    unstable : int array (N,)
        Number of growing pairs of eigenvalues; two real ones count as a pair, one alone too.
    """

    drawn_by = "plot_root_locus"

    model: ModelOrAutomaton
    parameter: str
    at: Array
    values: ComplexArray
    coordinates: tuple[str, ...]
    shapes: ComplexArray
    participation: Array
    unstable: NDArray[np.int_]

    @property
    def frequencies(self) -> Array:
        """Im/(2 pi), Hz, (N, n)."""
        return self.values.imag / (2 * np.pi)

    @property
    def growth_rates(self) -> Array:
        """Real parts, 1/s, (N, n)."""
        return self.values.real

    def to_dataframe(self) -> Any:
        """One row for each value of the parameter and each mode, as a pandas DataFrame (needs the extra
        ``data``).

        Columns: growth rate, frequency, and the share of each coordinate, as "participation of x1".
        """
        n, modes = self.values.shape
        columns = {"growth_rate": self.growth_rates.ravel(), "frequency": self.frequencies.ravel()}
        for i, name in enumerate(self.coordinates):
            columns[f"participation of {name}"] = self.participation[:, i].ravel()
        index = {self.parameter: np.repeat(self.at, modes), "mode": np.tile(np.arange(modes), n)}
        return dataframe(columns, index, UNITS | self._parameter_unit())

    def to_xarray(self) -> Any:
        """All of it as an xarray Dataset (needs the extra ``data``), with the parameter, "mode" and
        "coordinate" as dimensions."""
        two = (self.parameter, "mode")
        three, shapes = (self.parameter, "coordinate", "mode"), self.shapes
        variables = {"growth_rate": (two, self.growth_rates), "frequency": (two, self.frequencies)}
        variables |= {
            "unstable": (self.parameter, self.unstable),
            "participation": (three, self.participation),
        }
        variables |= {"shape_real": (three, shapes.real), "shape_imag": (three, shapes.imag)}
        coordinates = {self.parameter: self.at, "coordinate": list(self.coordinates)}
        return dataset(variables, coordinates, UNITS | self._parameter_unit())

    def _parameter_unit(self) -> dict[str, str]:
        return {self.parameter: parameter_unit(self.model, self.parameter)}

    def __repr__(self) -> str:
        path = f"{self.parameter} {span(self.at)} in {count(len(self.at), 'value')}"
        growing = f"at most {count(int(self.unstable.max()), 'pair')} of eigenvalues growing"
        return f"RootLocus({path}, {count(self.values.shape[1], 'mode')}, {growing})"


def root_locus(model: ModelOrAutomaton, parameter: str, values: Any) -> RootLocus:
    """Eigenvalues of all modes at the sliding equilibrium, for each value of a parameter.

    The modes are followed by their vectors, not sorted, so that a column is one mode through crossings and
    veerings.  Beyond an exact coalescence the order of the two modes is arbitrary.

    Parameters
    ----------
    model : Model, HybridAutomaton or Structure
        Modes of a large structure are followed by their shapes as long as they are within its window, and
        the locus has no shapes.
    parameter : str
        "t" for a model that depends on time: eigenvalues of the system as it is at each of these times.
    values : array_like (N,)
        Along a path: each mode is followed from one value to the next.

    Returns
    -------
    RootLocus

    Raises
    ------
    TypeError
        For an unknown parameter, or what is no model.
    ValueError
        For a value that breaks its rule, or where no value has an equilibrium.

    Examples
    --------
    >>> import frictionlab as fl
    >>> locus = fl.root_locus(fl.SliderOnBelt(), "mu_k", [0.0, 1.0, 2.0])
    >>> locus.values.shape, [bool(rates.max() < 0) for rates in locus.growth_rates]
    ((3, 5), [True, True, False])
    """
    if isinstance(model, LargeSystem):
        return model.find_root_locus(parameter, values)
    in_time = isinstance(parameter, str) and parameter == TIME
    if in_time and isinstance(model, Model) and depends_on_time(model):
        model = frozen_in_time(model)
    at = check_path(model, parameter, values)
    problem = equilibrium_problem(model, within={parameter: at})

    def matrices(points: Array) -> Array:
        return problem.without_following(problem.linearised({parameter: points})[1])

    path: Any = modes_along_path(at, matrices, problem.further)
    _refuse_nothing(path, parameter)
    return RootLocus(
        model,
        parameter,
        at,
        path.values,
        problem.names,
        *_shapes_and_participation(problem, parameter, path),
        path.unstable,
    )


def _shapes_and_participation(
    problem: EquilibriumProblem, parameter: str, path: Any
) -> tuple[ComplexArray, Array]:
    n = len(problem.names)
    matrices = problem.linearised({parameter: path.at})[1] if problem.following else None
    right = problem.with_following(path.right, matrices)
    left = problem.with_following(path.left.swapaxes(1, 2)).swapaxes(1, 2)
    with np.errstate(invalid="ignore"):  # NaN where there is no equilibrium
        return mode_shapes(right, n), participation_factors(left, right, n)


def _refuse_nothing(path: Modes, parameter: str) -> None:
    if not np.isfinite(path.values).any():
        raise ValueError(
            f"there must be an equilibrium with F_N > 0 at a value of {parameter} at least, "
            f"got none from {path.at.min():g} to {path.at.max():g}: change the values or the model"
        )
