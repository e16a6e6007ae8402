"""Modes of a structure along a parameter: its root locus, and where its stability changes.

Of a few freedoms full spectra are cheap, and the analyses of models answer.  Of more the eigenvalues in the
window are found at some values of the parameter.  Modes of neighbouring values are matched by the modal
assurance criterion (MAC) of their shapes.  Where that is not clear, or where a growth rate may pass zero
unseen, the step is halved.  Each change of sign is then solved for by Newton's method: the eigenvalue, its
left and its right vector are refined together, and give its exact slope.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from frictionlab.interruption import progress_bar
from frictionlab.stability.boundaries.stability_changes import (
    StabilityChange,
    StabilityKind,
    changes_on_lines,
)
from frictionlab.stability.eigenproblems.eigenvalues import mode_shapes, participation_factors
from frictionlab.stability.eigenproblems.root_locus import Modes, RootLocus, modes_of_matrices, track_modes
from frictionlab.stability.state_matrices import eigenvalues_of_matrices
from frictionlab.structures.quadratic_pencil import QuadraticPencil, factorised
from frictionlab.structures.window_eigenvalues import has_regular_mass
from frictionlab.validation import abbreviate, check_limits, float_array

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
MOST_SCANNED = 50  # freedoms up to which full spectra are scanned
SAME_MODE = 0.6  # MAC from which two shapes are one mode
EDGE_SHARE = 0.02  # of the window's width: modes so near to its ends may enter or leave it
DAMPED_SHARE = 0.05  # a mode with a larger damping ratio does not grow soon, and may be lost sight of
HALVINGS = 3  # of a step, at most
FIRST_POINTS = 9  # of the search for changes of stability
NEAR_ZERO = 4.0  # times the bend of a growth rate over a step: farther from zero it cannot pass it unseen
NEWTON_STEPS = 30
ROOT_RTOL = 1e-12  # of the range of the parameter
COALESCED_SHARE = 1e-7  # of an eigenvalue: rounding parts two that coalesce by the root of its share
COALESCENCE_STEPS = 60
REFINEMENTS = 6
SETTLED_RTOL = 1e-14  # of an eigenvalue: its last refinement


@dataclass(frozen=True, eq=False)
class Sample:
    """The modes with Im > 0, and real ones that grow, at one value of a parameter.

    Parameters
    ----------
    at : float
    values : complex array (k,)
    shapes : complex array (n, k)
        Of length 1.
    """

    at: float
    values: ComplexArray
    shapes: ComplexArray

    @property
    def growing(self) -> int:
        """How many modes grow."""
        return int((self.values.real > 0.0).sum())


def follow_modes(structure: Structure, parameter: str, values: Any) -> RootLocus:
    """The root locus of a structure, see :func:`frictionlab.root_locus`."""
    structure.check_parameter(parameter)
    at = float_array("values", values, f"give those of {parameter}", finite=True).ravel()
    if not len(at):
        raise ValueError(
            f"values must be one number or more, got {abbreviate(values)}: give those of {parameter}"
        )
    if _is_scanned(structure, parameter, at):
        return _full_locus(structure, parameter, at)
    samples = [sample(structure, parameter, value) for value in progress_bar(at, "root locus")]
    steps = [_match(structure, parameter, a, b, HALVINGS) for a, b in pairwise(samples)]
    columns = _columns(samples, steps)
    tracked: Any = np.full((len(at), len(columns)), complex(np.nan, np.nan))
    for j, column in enumerate(columns):
        for i, place in column.items():
            tracked[i, j] = samples[i].values[place]
    tracked = tracked[:, np.argsort(np.nanmean(tracked.imag, axis=0), kind="stable")]
    none = np.zeros((len(at), 0, tracked.shape[1]))
    unstable = np.array([one.growing for one in samples])
    itself: Any = structure  # to type checkers no model
    return RootLocus(itself, parameter, at, tracked, (), none.astype(complex), none, unstable)


def find_stability_changes(structure: Structure, parameter: str, bounds: Any) -> tuple[StabilityChange, ...]:
    """The changes of stability of a structure, see :func:`frictionlab.stability_changes`."""
    structure.check_parameter(parameter)
    low, high = check_limits("bounds", bounds, "give (low, high)")
    if _is_scanned(structure, parameter, (low, high)):
        problem: Any = _FullSpectra(structure)  # of an equilibrium problem only the spectra are needed
        return changes_on_lines(problem, parameter, (low, high), {})[0]
    samples = _scan(structure, parameter, (low, high))
    changes = []
    for a, b in pairwise(samples):
        for i, j in _pairs(_match_by_shape(structure, a, b)):
            if (a.values[i].real > 0.0) != (b.values[j].real > 0.0):
                changes.append(_change(structure, parameter, (a, i), (b, j)))
    return _with_counts(sorted(changes, key=lambda one: one.value), samples[0].growing)


def _is_scanned(structure: Structure, parameter: str, values: Iterable[float]) -> bool:
    """Whether full spectra are cheap and right: every motion has mass, no stiffness is complex."""
    if structure.size > MOST_SCANNED or np.iscomplexobj(structure.pencil.K.data):
        return False
    moved = [structure.replace(**{parameter: float(value)}) for value in values]
    checked = moved if parameter in structure.M.parameters else moved[:1]
    return all(has_regular_mass(one.pencil) for one in checked)


def sample(structure: Structure, parameter: str, value: float) -> Sample:
    """The modes at a value of a parameter."""
    found = structure.replace(**{parameter: float(value)}).find_eigenvalues()
    chosen = (found.values.imag > 0.0) | (found.values.real > 0.0)
    chosen &= found.values.imag >= 0.0
    shapes = found.vectors[: structure.size, chosen]
    return Sample(float(value), found.values[chosen], shapes / np.linalg.norm(shapes, axis=0))


def _match(structure: Structure, parameter: str, a: Sample, b: Sample, halvings: int) -> NDArray[np.intp]:
    """For each mode of `a` its place in `b`, -1 where it has none; the step is halved where it is unclear."""
    match = _match_by_shape(structure, a, b)
    if not halvings or not _unmatched(structure, match, a, b):
        return match
    middle = sample(structure, parameter, 0.5 * (a.at + b.at))
    first = _match(structure, parameter, a, middle, halvings - 1)
    second = _match(structure, parameter, middle, b, halvings - 1)
    return np.where(first >= 0, second[first], -1)


def _match_by_shape(structure: Structure, a: Sample, b: Sample) -> NDArray[np.intp]:
    """For each mode of `a` (k,) the mode of `b` with the same shape, -1 where none has it."""
    likeness = np.abs(a.shapes.conj().T @ b.shapes) ** 2
    rows, columns = linear_sum_assignment(-likeness)
    match = np.full(len(a.values), -1)
    same = likeness[rows, columns] >= SAME_MODE
    match[rows[same]] = columns[same]
    return match


def _unmatched(structure: Structure, match: NDArray[np.intp], a: Sample, b: Sample) -> bool:
    """Whether a weakly damped mode has no match, away from the window's ends, where modes come and go."""
    low, high = structure.window or (0.0, np.inf)
    edge = EDGE_SHARE * (high - low) if structure.window else 0.0
    alone = np.concatenate([a.values[match < 0], np.delete(b.values, match[match >= 0])])
    frequencies, weakly = alone.imag / (2 * np.pi), np.abs(alone.real) < DAMPED_SHARE * np.abs(alone)
    return bool((weakly & (frequencies > low + edge) & (frequencies < high - edge)).any())


def _pairs(match: NDArray[np.intp]) -> list[tuple[int, int]]:
    return [(i, int(j)) for i, j in enumerate(match) if j >= 0]


def _columns(samples: Sequence[Sample], steps: Sequence[NDArray[np.intp]]) -> list[dict[int, int]]:
    """For each mode its place in each sample that has it."""
    columns = [{0: i} for i in range(len(samples[0].values))]
    current = dict(enumerate(columns))
    for step, match in enumerate(steps, start=1):
        following = {int(match[i]): column for i, column in current.items() if match[i] >= 0}
        for place in range(len(samples[step].values)):
            if place not in following:
                following[place] = {}
                columns.append(following[place])
            following[place][step] = place
        current = following
    return columns


def _scan(structure: Structure, parameter: str, bounds: tuple[float, float]) -> list[Sample]:
    """Samples between which no growth rate passes zero twice, as far as their bends tell."""
    grid = np.linspace(*bounds, FIRST_POINTS)
    samples = {float(p): sample(structure, parameter, p) for p in progress_bar(grid, "stability changes")}
    least = (bounds[1] - bounds[0]) / (FIRST_POINTS - 1) / 2**HALVINGS
    waiting = list(zip(grid[::2], grid[1::2], grid[2::2], strict=False))
    while waiting:
        a, m, b = map(float, waiting.pop())
        if b - a <= 2 * least or _is_settled(structure, samples[a], samples[m], samples[b]):
            continue
        for low, high in (a, m), (m, b):
            middle = 0.5 * (low + high)
            samples[middle] = sample(structure, parameter, middle)
            waiting.append((low, middle, high))
    return [samples[p] for p in sorted(samples)]


def _is_settled(structure: Structure, a: Sample, m: Sample, b: Sample) -> bool:
    """Whether all modes are matched, and none may grow between the samples where it does not at them."""
    before, after = _match_by_shape(structure, m, a), _match_by_shape(structure, m, b)
    if _unmatched(structure, before, m, a) or _unmatched(structure, after, m, b):
        return False
    for j in np.flatnonzero((before >= 0) & (after >= 0)):
        rates = np.array([a.values[before[j]].real, m.values[j].real, b.values[after[j]].real])
        bend = abs(rates[1] - 0.5 * (rates[0] + rates[2]))
        for pair in rates[:2], rates[1:]:
            if (pair[0] > 0.0) == (pair[1] > 0.0) and np.abs(pair).min() < NEAR_ZERO * bend / 4:
                return False
    return True


def _change(
    structure: Structure, parameter: str, start: tuple[Sample, int], end: tuple[Sample, int]
) -> StabilityChange:
    """Where the growth rate of a mode is zero between two samples."""
    (a, i), (b, j) = start, end
    low, high = a.at, b.at
    rates = a.values[i].real, b.values[j].real
    rises = rates[1] > rates[0]
    if _is_mirrored(structure.replace(**{parameter: 0.5 * (low + high)}).pencil):
        at, value = _coalescence(structure, parameter, a.at if rises else b.at, end if rises else start)
        return _described(at, value, rises)
    at = low + (high - low) * rates[0] / (rates[0] - rates[1])
    nearer, place = (a, i) if at - low < high - at else (b, j)
    value, shape = (
        a.values[i] + (at - low) / (high - low) * (b.values[j] - a.values[i]),
        nearer.shapes[:, place],
    )
    for _ in range(NEWTON_STEPS):
        mode = refine_mode(structure.replace(**{parameter: at}), value, shape)
        value, shape = mode.value, mode.right
        if (value.real > 0.0) == rises:
            high = at
        else:
            low = at
        slope = mode.slope(structure.replace(**{parameter: at}).pencil_derivative(parameter))
        step = -value.real / slope.real if slope.real else np.inf
        if abs(step) <= ROOT_RTOL * (b.at - a.at):
            break
        inside = low < at + step < high
        value = value + slope * step if inside else value
        at = at + step if inside else 0.5 * (low + high)
    return _described(at, value, rises)


def _described(at: float, value: complex, rises: bool) -> StabilityChange:
    kind = StabilityKind.FLUTTER if abs(value.imag) > abs(value.real) else StabilityKind.DIVERGENCE
    frequency = abs(value.imag) / (2 * np.pi) if kind is StabilityKind.FLUTTER else 0.0
    return StabilityChange(float(at), float(frequency), kind, "loss" if rises else "regain", (0, 0))


def _is_mirrored(pencil: QuadraticPencil) -> bool:
    """Whether -conj(s) is an eigenvalue where s is, as without damping.

    Growth rates are then zeros until two modes coalesce, where they have no slope.
    """
    C, K = pencil.C, pencil.K
    if np.iscomplexobj(K.data):
        return False
    return not C.count_nonzero() or not ((C + C.T).count_nonzero() or (K - K.T).count_nonzero())


def _coalescence(
    structure: Structure, parameter: str, still: float, start: tuple[Sample, int]
) -> tuple[float, complex]:
    """Where two modes coalesce, between where they are still and where one grows, and the eigenvalue there.

    Squares of growth rates are linear there, so the secant of two is followed; where it does not help the
    interval is halved.
    """
    sampled, place = start
    growing, value, shape = sampled.at, complex(sampled.values[place]), sampled.shapes[:, place]
    width, at, slope = abs(growing - still), 0.5 * (growing + still), 0.0
    for _ in range(COALESCENCE_STEPS):
        at_once = sample(structure, parameter, at)
        likeness = np.abs(shape.conj() @ at_once.shapes) ** 2
        grows = at_once.values.real > COALESCED_SHARE * np.abs(at_once.values)
        places = np.flatnonzero(grows & (likeness >= SAME_MODE))
        if len(places):
            best = places[likeness[places].argmax()]
            new, shape = complex(at_once.values[best]), at_once.shapes[:, best]
            slope = (value.real**2 - new.real**2) / (growing - at)
            growing, value = at, new
        else:
            still, slope = at, 0.0
        ahead = growing - value.real**2 / slope if slope else still
        inside = min(still, growing) < ahead < max(still, growing)
        if min(abs(growing - still), abs(growing - ahead) if inside else np.inf) <= ROOT_RTOL * width:
            return ahead if inside else growing, value
        at = ahead if inside else 0.5 * (growing + still)
    return growing, value


@dataclass(frozen=True, eq=False)
class RefinedMode:
    """An eigenvalue with right and left vector (n,), to rounding, y Q'(s) x = 1."""

    value: complex
    right: ComplexArray
    left: ComplexArray

    def slope(self, derivative: QuadraticPencil) -> complex:
        """The derivative of the eigenvalue by a parameter, from that of the matrices."""
        return complex(-self.left @ derivative.products(np.array([self.value]), self.right[:, None])[:, 0])


def refine_mode(structure: Structure, value: complex, shape: ComplexArray) -> RefinedMode:
    """A mode near an eigenvalue and a shape, by inverse iteration with Rayleigh quotients of both sides."""
    pencil = structure.pencil
    right: Any = shape
    left: Any = shape.conj()
    solve = factorised(pencil.at(value * (1.0 + SETTLED_RTOL)))
    transposed = factorised(pencil.transposed().at(value * (1.0 + SETTLED_RTOL)))
    slope_at = value  # a vector's weight in Q'(s), which need not be refined
    for _ in range(REFINEMENTS):
        if solve is None or transposed is None:  # the value is an eigenvalue to the last bit
            break
        right = solve(2 * slope_at * (pencil.M @ right) + pencil.C @ right)
        left = transposed(2 * slope_at * (pencil.M.T @ left) + pencil.C.T @ left)
        right, left = right / np.linalg.norm(right), left / np.linalg.norm(left)
        step = -_rayleigh_step(pencil, value, left, right)
        value = value + step
        if abs(step) <= SETTLED_RTOL * abs(value):
            break
    product = left @ (2 * value * (pencil.M @ right) + pencil.C @ right)
    return RefinedMode(complex(value), right, left / product)


def _rayleigh_step(
    pencil: QuadraticPencil, value: complex, left: ComplexArray, right: ComplexArray
) -> complex:
    """By how much y Q(s) x = 0 puts the eigenvalue lower, to first order."""
    at = pencil.products(np.array([value]), right[:, None])[:, 0]
    return complex(left @ at / (left @ (2 * value * (pencil.M @ right) + pencil.C @ right)))


def _with_counts(changes: list[StabilityChange], growing: int) -> tuple[StabilityChange, ...]:
    """The changes with the numbers of growing modes below and above each."""
    counted = []
    for one in changes:
        after = growing + (1 if one.direction == "loss" else -1)
        counted.append(StabilityChange(one.value, one.frequency, one.kind, one.direction, (growing, after)))
        growing = after
    return tuple(counted)


@dataclass(frozen=True, eq=False)
class _FullSpectra:
    """All eigenvalues of a small structure at values of its parameters, as those of models are given."""

    structure: Structure

    def matrices(self, changes: dict[str, Array]) -> Array:
        """State matrices (N, m, m)."""
        count = max(np.size(values) for values in changes.values())
        values = {name: np.full(count, value) for name, value in self.structure.parameters.items()}
        values |= {name: np.broadcast_to(np.ravel(column), (count,)) for name, column in changes.items()}
        n = self.structure.size
        M, C, K = (sum(one.stack(values, count) for one in terms) for terms in self.structure.terms)
        A = np.zeros((count, 2 * n, 2 * n))
        A[:, :n, n:] = np.eye(n)
        A[:, n:, :n], A[:, n:, n:] = -np.linalg.solve(M, K), -np.linalg.solve(M, C + np.zeros_like(K))
        return A

    def spectra(self, changes: dict[str, Array]) -> Any:
        """Eigenvalues (N, m), the largest growth rate first."""
        values = eigenvalues_of_matrices(self.matrices(changes))
        return np.take_along_axis(values, np.argsort(-values.real, axis=1), axis=1)


def _full_locus(structure: Structure, parameter: str, at: Array) -> RootLocus:
    """The root locus of a small structure, with shapes and participation."""
    spectra = _FullSpectra(structure)

    def modes(points: Array) -> Modes:
        return modes_of_matrices(points, spectra.matrices({parameter: points}))

    path: Any = track_modes(modes(at), modes)
    n = structure.size
    shapes, shares = mode_shapes(path.right, n), participation_factors(path.left, path.right, n)
    itself: Any = structure  # to type checkers no model
    return RootLocus(itself, parameter, at, path.values, structure.coordinates, shapes, shares, path.unstable)
