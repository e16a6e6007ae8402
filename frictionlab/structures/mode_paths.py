"""Modes of a structure along a parameter: its root locus, and spectra for maps.

The spectra of a structure of few freedoms are cheap.  A larger one is reduced to few freedoms first
(`reduction`).

Only modes in the window of frequencies count.  The growth rate of a mode is put lower the farther the mode is
beyond the window, so that it changes steadily where a mode enters or leaves.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linear_sum_assignment

from frictionlab.interruption import progress_bar
from frictionlab.stability.eigenproblems.eigenvalues import mode_shapes, participation_factors
from frictionlab.stability.eigenproblems.root_locus import RootLocus, modes_along_path
from frictionlab.stability.equilibrium_problem import check_path
from frictionlab.stability.state_matrices import eigenvalues_of_matrices
from frictionlab.structures.quadratic_pencil import QuadraticPencil, Spectrum
from frictionlab.structures.reduction import (
    DAMPED_SHARE,
    EDGE_SHARE,
    Point,
    Sample,
    over_box,
    reduced,
)
from frictionlab.structures.steady_friction import UnsettledStatesError
from frictionlab.structures.window_eigenvalues import (
    dense_spectrum,
    equal_values,
    has_regular_mass,
    left_vectors_of,
    state_matrices,
)

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
MOST_SCANNED = 50  # freedoms up to which full spectra are scanned
SAME_MODE = 0.6  # product of unit vectors from which two are one mode
HALVINGS = 8  # of a step, at most
MOST_ENTRIES = 4_000_000  # of state matrices that are made at once
OTHER_MODES = 8  # beside those in the window, whose eigenvalues are kept


def locus_of_structure(structure: Structure, parameter: str, values: Any) -> RootLocus:
    """The root locus of a structure, see :func:`frictionlab.root_locus`."""
    at = check_path(structure, parameter, values)
    check_masses(structure, parameter, at)
    if is_small(structure) and SmallSpectra(structure).has_matrices:
        return _full_locus(structure, parameter, at)
    points = ({parameter: float(p)} for p in progress_bar(at, "root locus"))
    found = [*Sample.where_known(structure, points)]
    known, samples = [i for i, one in enumerate(found) if one], [one for one in found if one]
    small = reduced(structure, samples)
    places = [_place(small, one, small.restricted(one.shapes)) for one in samples]
    steps = [_match(small, a, b, HALVINGS) for a, b in pairwise(places)]
    columns = _columns([len(one.values) for one in samples], steps)
    tracked: Any = np.full((len(at), len(columns)), complex(np.nan, np.nan))
    for j, column in enumerate(columns):
        for i, place in column.items():
            tracked[known[i], j] = samples[i].values[place]
    tracked = tracked[:, np.argsort(np.nanmean(tracked.imag, axis=0), kind="stable")]
    none = np.zeros((len(at), 0, tracked.shape[1]))
    return RootLocus(structure, parameter, at, tracked, (), none.astype(complex), none, _growing(found))


def _growing(samples: Iterable[Sample | None]) -> NDArray[np.intp]:
    """How many modes grow at samples, 0 where there is no equilibrium."""
    return np.array([one.growing if one else 0 for one in samples])


def spectra_over(structure: Structure, box: Mapping[str, tuple[float, float]]) -> SmallSpectra:
    """The spectra of a structure within ranges of parameters."""
    small = structure
    if not is_small(structure):
        small = reduced(structure, over_box(structure, box)[0])
    return SmallSpectra(small)


def is_small(structure: Structure) -> bool:
    """Whether full spectra are cheap."""
    return structure.size <= MOST_SCANNED


def check_masses(structure: Structure, parameter: str, values: Iterable[float]) -> None:
    """Refuse values of a parameter at which a mass is not positive."""
    if parameter in structure.M.parameters:
        for value in values:
            structure.at_values({parameter: float(value)})


def check_settling(structure: Structure, parameter: str, values: Iterable[float]) -> None:
    """Refuse values of a parameter at none of which there is an equilibrium, as states do not settle."""
    unsettled = None
    for value in values:
        try:
            structure.at_values({parameter: float(value)}).find_equilibrium()
            return
        except UnsettledStatesError as error:
            unsettled = error
        except ValueError:  # without sliding, or with open contacts, there are no eigenvalues
            pass
    if unsettled is not None:
        raise unsettled


@dataclass(frozen=True, eq=False)
class SmallSpectra:
    """Eigenvalues of a structure of few freedoms at values of its parameters, as those of models are given.

    Parameters
    ----------
    structure : Structure
    """

    structure: Structure

    def spectra(self, changes: Mapping[str, Array]) -> ComplexArray:
        """Eigenvalues (N, m), the largest growth rate first, at arrays (N,) of parameters.

        Those beyond the window are damped as much as makes m of them.
        """
        values = self._damped_beyond(self._values(changes))
        order = np.argsort(-values.real, axis=1, kind="stable")
        return np.take_along_axis(values, order, axis=1)[:, : self._count]

    def matrices(self, changes: Mapping[str, Array]) -> Array:
        """State matrices (N, m, m): of displacements, velocities and states of friction laws.

        Those of open contacts, which are gone at once, are damped as much as anything else.
        """
        return self.matrices_and_open(changes)[0]

    def matrices_and_open(self, changes: Mapping[str, Array]) -> tuple[Array, NDArray[np.bool_]]:
        """State matrices, and which rows (N, freedoms and states) are states of open contacts."""
        n = self.structure.size
        M, C, K = self.structure.stacks(changes)
        gone = (np.diagonal(C, axis1=1, axis2=2) == 0.0) & (np.arange(C.shape[1]) >= n)
        leading = np.concatenate([M[:, :, :n], C[:, :, n:]], axis=2) + gone[:, None] * np.eye(M.shape[1])
        A = state_matrices(leading, C, K, M.shape[1] - n)
        if gone.any():
            point, place = np.nonzero(gone)
            A[point, n + place, n + place] *= np.abs(A[point]).sum(axis=2).max(axis=1)
        return A, gone

    @cached_property
    def has_matrices(self) -> bool:
        """Whether state matrices have these eigenvalues: M is regular, and no stiffness complex."""
        pencil = self.structure.structural_pencil
        return not np.iscomplexobj(pencil.K.data) and has_regular_mass(pencil)

    # What `changes_on_lines` asks where a growth rate jumps: whether the equilibrium goes on there.

    def states(self, changes: Mapping[str, Array]) -> Array:
        """Static displacements (n, N); NaN where there is no equilibrium."""
        columns = np.broadcast_arrays(*map(np.ravel, changes.values()))
        x = np.full((self.structure.size, len(columns[0])), np.nan)
        for i, row in enumerate(zip(*columns, strict=True)):
            with suppress(ValueError):
                x[:, i] = self.structure.at_values(dict(zip(changes, map(float, row)))).displacements
        return x

    def _values(self, changes: Mapping[str, Array]) -> Any:
        columns = np.broadcast_arrays(*map(np.ravel, changes.values()))
        parts = range(0, max(len(columns[0]), 1), max(1, MOST_ENTRIES // self.structure.order**2))
        chunks = [{name: one[i : i + parts.step] for name, one in zip(changes, columns)} for i in parts]
        if self.has_matrices:
            return np.concatenate([_eigenvalues(self.matrices(chunk)) for chunk in chunks])
        values = np.concatenate([self._values_of_pencils(chunk) for chunk in chunks])
        largest = np.abs(values[np.isfinite(values)]).max(initial=1.0)
        return np.where(np.isfinite(values) | np.isnan(values), values, -largest)

    def _values_of_pencils(self, changes: Mapping[str, Array]) -> ComplexArray:
        """Eigenvalues (N, m) of pencils, -inf where there are fewer."""
        order, size = self.structure.order, self.structure.size
        stacks = self.structure.stacks(changes)
        # room for pairs: of a complex stiffness a mode that does not oscillate is hardly real
        values = np.full((len(stacks[0]), 2 * order), -np.inf, dtype=complex)
        for row, *full in zip(values, *stacks, strict=True):
            if np.isnan(full[-1]).any():
                row[:] = np.nan
                continue
            pencil = QuadraticPencil(*map(sparse.csc_array, full), states=order - 2 * size)
            spectrum = dense_spectrum(pencil).values
            if np.iscomplexobj(pencil.K.data):  # with the wrong sign of its damping below the real axis
                upper = spectrum[spectrum.imag > 0.0]
                spectrum = np.concatenate([upper, upper.conj(), spectrum[spectrum.imag == 0.0]])
            row[: len(spectrum)] = spectrum
        return values

    def _damped_beyond(self, values: ComplexArray) -> ComplexArray:
        if self.structure.window is None:
            return values
        low, high = (2 * np.pi * end for end in self.structure.window)
        frequencies = np.abs(values.imag)
        beyond = np.clip(np.maximum(frequencies - high, low - frequencies), 0.0, high)
        # Not steeper than frequencies change: what moves fast is looked at in short steps.
        rates = np.clip(values.real, -high, high) - beyond
        return rates + 1j * np.clip(values.imag, -2.0 * high, 2.0 * high)

    @cached_property
    def _count(self) -> int:
        """How many eigenvalues are kept: twice those in the window, and some more."""
        if self.structure.window is None:
            return self.structure.order
        try:
            found = len(self.structure.find_eigenvalues().values)
        except ValueError:  # without an equilibrium at its own values
            return self.structure.order
        return min(self.structure.order, 2 * (found + OTHER_MODES))


def _eigenvalues(matrices: Array) -> Any:
    """Eigenvalues (N, m) of state matrices (N, m, m), NaN where there is no equilibrium."""
    known = np.isfinite(matrices).all(axis=(1, 2))
    values = np.full(matrices.shape[:2], complex(np.nan, np.nan))
    values[known] = eigenvalues_of_matrices(matrices[known])
    return values


def _full_locus(structure: Structure, parameter: str, at: Array) -> RootLocus:
    """The root locus of a small structure, with shapes and participation."""
    spectra = SmallSpectra(structure)
    n = structure.size
    further = range(2 * n, structure.order)
    open_states: dict[float, NDArray[np.bool_]] = {}

    def matrices(points: Array) -> Array:
        stacked, gone = spectra.matrices_and_open({parameter: points})
        open_states.update(zip(points.tolist(), gone))
        return stacked

    path: Any = modes_along_path(at, matrices, further)
    values, unstable, known = path.values, path.unstable, np.ones(path.values.shape, dtype=bool)
    if np.isnan(values).all():
        check_settling(structure, parameter, at)
    if structure.order > 2 * n:
        gone = np.array([open_states[p] for p in at.tolist()])
        # Modes that are states of open contacts are none.
        known = (np.abs(path.right[:, n:]) ** 2 * gone[:, :, None]).sum(axis=1) <= 0.5
    if structure.window is not None:
        low, high = structure.window
        frequencies = values.imag / (2 * np.pi)
        known &= (low <= frequencies) & (frequencies <= high)
        unstable = _growing(Sample.where_known(structure, ({parameter: float(p)} for p in at)))
    chosen = known.any(axis=0)
    values = np.where(known, values, complex(np.nan, np.nan))[:, chosen]
    right, left = path.right[:, :, chosen], path.left[:, chosen]
    shapes, shares = mode_shapes(right, n), participation_factors(left, right, n)
    return RootLocus(structure, parameter, at, values, structure.coordinates, shapes, shares, unstable)


@dataclass(frozen=True, eq=False)
class Place:
    """Modes of a reduced structure at a point, with left vectors.

    Parameters
    ----------
    point : mapping of str to float
    pencil : QuadraticPencil
    right : Spectrum
    left : Spectrum
        y Q(s) = 0 and y Q'(s) x = 1.
    """

    point: Point
    pencil: QuadraticPencil
    right: Spectrum
    left: Spectrum


def _place(small: Structure, sample: Sample, shapes: ComplexArray) -> Place:
    """The modes of a sample, whose shapes are these in the coordinates of a structure."""
    pencil = small.at_values(sample.point).pencil
    right = Spectrum(sample.values, shapes)
    vectors = left_vectors_of(pencil, right, lambda: dense_spectrum(pencil.transposed()))
    return Place(sample.point, pencil, right, Spectrum(sample.values, vectors))


def _match(small: Structure, a: Place, b: Place, halvings: int) -> NDArray[np.intp]:
    """For each mode of `a` its place in `b`, -1 where it has none; the step is halved where it is unclear."""
    match = places_of_modes(a, b)
    if not halvings or not _is_unclear(small, match, a.right.values, b.right.values):
        return match
    (name,) = a.point
    try:
        between = Sample.of(small, {name: 0.5 * (a.point[name] + b.point[name])})
    except ValueError:  # without an equilibrium there
        return match
    middle = _place(small, between, between.shapes)
    first = _match(small, a, middle, halvings - 1)
    second = _match(small, middle, b, halvings - 1)
    return np.where(first >= 0, second[first], -1)


def places_of_modes(a: Place, b: Place) -> NDArray[np.intp]:
    """For each mode of `a` its place in `b`, -1 where it has none."""
    alike = _likeness(a, b)
    rows, columns = linear_sum_assignment(-alike)
    places = np.full(len(alike), -1)
    same = alike[rows, columns] >= SAME_MODE
    places[rows[same]] = columns[same]
    return places


def _likeness(a: Place, b: Place) -> Array:
    """Similarity of the modes of `a` (k,) and `b` (m,), as (k, m).

    It is the product of left with right vectors, both ways.  Modes with equal eigenvalues are compared as a
    whole, as their vectors are any of a subspace.
    """
    there = a.pencil.products_of_modes(a.left, b.right)
    back = b.pencil.products_of_modes(b.left, a.right)
    first, second = (equal_values(one.right.values).astype(float) for one in (a, b))
    size = np.minimum(first.sum(axis=1)[:, None], second.sum(axis=0))
    return np.sqrt(np.abs(first @ (there * back.T) @ second) / size)


def _is_unclear(structure: Structure, match: NDArray[np.intp], a: ComplexArray, b: ComplexArray) -> bool:
    """Whether a weakly damped mode has no match, away from the window's ends, where modes come and go."""
    low, high = structure.window or (0.0, np.inf)
    edge = EDGE_SHARE * (high - low) if structure.window else 0.0
    alone = np.concatenate([a[match < 0], np.delete(b, match[match >= 0])])
    frequencies, weakly = alone.imag / (2 * np.pi), np.abs(alone.real) < DAMPED_SHARE * np.abs(alone)
    return bool((weakly & (frequencies > low + edge) & (frequencies < high - edge)).any())


def _columns(counts: Sequence[int], steps: Sequence[NDArray[np.intp]]) -> list[dict[int, int]]:
    """For each mode its place in each sample that has it."""
    columns = [{0: i} for i in range(counts[0])]
    current = dict(enumerate(columns))
    for step, match in enumerate(steps, start=1):
        following = {int(match[i]): column for i, column in current.items() if match[i] >= 0}
        for place in range(counts[step]):
            if place not in following:
                following[place] = {}
                columns.append(following[place])
            following[place][step] = place
        current = following
    return columns
