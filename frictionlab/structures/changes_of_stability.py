"""Where the stability of a structure changes along a parameter.

The spectra of a structure of few freedoms are scanned as those of models.  A larger one is reduced to the
modes next to the imaginary axis (`reduction`).  Their eigenvalues and slopes are computed at some values of
the parameter.  First-order perturbation tells what each may do in between: its slope moves it, and two modes
that come near each other may push each other by sqrt(|c d|), where c and d couple them, as the eigenvalues
of [[s, c], [d, t]] are no farther from s or t.  An interval is halved until by this every growth rate keeps
its sign, or a cubic through values and slopes passes zero once.  Source: G. W. Stewart, J. Sun, "Matrix
Perturbation Theory" (1990), section IV.2.

Every change is then found again in reductions to the modes of the full structure on both sides of it.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import linear_sum_assignment

from frictionlab.interruption import progress_bar
from frictionlab.stability.boundaries.stability_changes import (
    GRID_POINTS,
    StabilityChange,
    StabilityKind,
    changes_on_lines,
)
from frictionlab.stability.equilibrium_problem import check_bounds
from frictionlab.stability.state_matrices import NEUTRAL_RTOL
from frictionlab.structures.mode_paths import (
    Place,
    SmallSpectra,
    check_masses,
    check_settling,
    is_small,
    places_of_modes,
)
from frictionlab.structures.quadratic_pencil import QuadraticPencil, Spectrum
from frictionlab.structures.reduction import DAMPED_SHARE, EXACT, Sample, over_box, reduced
from frictionlab.structures.window_eigenvalues import dense_spectrum, equal_values, left_vectors_of

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
FIRST_INTERVALS = 8
MOST_HALVINGS = 20  # of one of these: the resolution is some 1e-7 of the range
MOST_SPECTRA = 1000
SLOPE_FACTOR = 2.0  # by which slopes may grow within an interval
REACH_FACTOR = 4.0  # times their coupling: modes that are farther apart do not push each other
MARGIN_SHARE = 0.02  # of the window's upper end: modes so far beyond it are followed
SPLINE_POINTS = 17  # in an interval, at which a cubic is looked at
SPLINE_SHARE = 0.25  # of the error of a cubic in the middle: that of the two cubics of its halves
NARROW_SHARE = 0.02  # of the window's upper end: half the range of frequencies around a change
NEAR_SHARE = 1e-3  # of the range: so near to a change it is looked for again, and modes are counted
REFINEMENTS = 6
NEWTON_RTOL = 1e-7  # of the range: after so short a step of Newton's method the next is none
ROUNDING = 1e-12  # of an eigenvalue: a smaller growth rate is nothing but rounding
SETTLED_RTOL = 1e-11  # of the range of the parameter: changes that move by less are settled
SAME_RTOL = 1e-8  # of the range: changes of one mode so near to each other are one


def find_stability_changes(structure: Structure, parameter: str, bounds: Any) -> tuple[StabilityChange, ...]:
    """The changes of stability of a structure, see :func:`frictionlab.stability_changes`."""
    low, high = check_bounds(structure, parameter, bounds)
    check_masses(structure, parameter, (low, high))
    if is_small(structure):
        return changes_of_few_freedoms(structure, parameter, (low, high))
    small, samples = structure, []
    if structure.window is not None:
        wider = _beyond_window(structure)
        samples = over_box(wider, {parameter: (low, high)})[0]
        small = reduced(wider, samples).in_window(structure.window)
    candidates = Scan(small, parameter, (low, high)).candidates()
    inside = [one for one in candidates if _is_inside(structure, one.frequency)]
    changes: list[StabilityChange] = []
    for one in progress_bar(inside, "stability changes"):
        change = _settled(structure, parameter, one, (low, high))
        if change is not None and not any(_is_same(change, other, high - low) for other in changes):
            changes.append(change)
    changes.sort(key=lambda one: one.value)
    if not changes:
        check_settling(structure, parameter, np.linspace(low, high, FIRST_INTERVALS + 1))
    growing = _growing_below(structure, parameter, changes, (low, high))
    # Growing modes that enter or leave the window are no changes of stability, but count.
    crossings = [one for one in candidates if not _is_inside(structure, one.frequency)]
    real = [one for one in candidates if not one.frequency]
    _check_counts(structure, samples, [*changes, *crossings, *real])
    return with_counts(changes, growing)


def _is_inside(structure: Structure, frequency: float) -> bool:
    low, high = structure.window or (0.0, np.inf)
    return low <= frequency <= high


def _check_counts(
    structure: Structure, samples: Sequence[Sample], changes: Sequence[StabilityChange | Candidate]
) -> None:
    """Warn where other numbers of modes grow at samples than by the changes since the first one.

    A pair may become two real eigenvalues, and that is no change: where there are such, nothing is said.
    """
    if not all(one.frequency > 0.0 for one in changes):
        return
    samples = sorted(samples, key=lambda one: [*one.point.values()])
    counts = [_count_at(structure, one) for one in samples]
    for sample, known in zip(samples[1:], counts[1:]):
        ((name, value),) = sample.point.items()
        below = [one.direction for one in changes if samples[0].point[name] <= one.value < value]
        expected = counts[0] + below.count("loss") - below.count("regain")
        if known != expected:
            warnings.warn(
                f"{known} modes grow at {name} = {value:.6g}, and {expected} by the changes of stability: "
                "some were missed, so take a narrower range, or a narrower window",
                RuntimeWarning,
                4,
            )


def _count_at(structure: Structure, sample: Sample) -> int:
    """How many modes grow, where those beyond the window count as in the scan."""
    growth, _ = effective_growth(structure.window, sample.values, np.zeros_like(sample.values))
    return int((growth > 0.0).sum())


def changes_of_few_freedoms(
    structure: Structure, parameter: str, bounds: tuple[float, float]
) -> tuple[StabilityChange, ...]:
    """The changes of stability of a structure of few freedoms, in its window."""
    problem: Any = SmallSpectra(structure)  # of an equilibrium problem only the spectra are needed
    changes = changes_on_lines(problem, parameter, bounds, {})[0]
    if not changes:
        check_settling(structure, parameter, np.linspace(*bounds, GRID_POINTS))
    if structure.window is None:
        return changes
    low, high = structure.window
    inside = [one for one in changes if one.frequency <= high and (one.frequency >= low or not low)]
    return with_counts(inside, _growing_below(structure, parameter, inside, bounds))


def _growing_below(
    structure: Structure, parameter: str, changes: Sequence[StabilityChange], bounds: tuple[float, float]
) -> int:
    """How many modes grow at the lower bound, or where it has no equilibrium, just below the first change."""
    with suppress(ValueError):
        return structure.count_growing(parameter, bounds[0])
    if not changes:
        return 0
    first, following = [*(one.value for one in changes), bounds[1]][:2]
    halves = (first + (following - first) / 2.0**k for k in range(1, MOST_HALVINGS))
    (above,) = islice(filter(None, Sample.where_known(structure, ({parameter: p} for p in halves))), 1)
    return above.growing - (1 if changes[0].direction == "loss" else -1)


def with_counts(changes: Sequence[StabilityChange], growing: int) -> tuple[StabilityChange, ...]:
    """The changes with the numbers of growing modes below and above each."""
    counted = []
    for one in changes:
        after = growing + (1 if one.direction == "loss" else -1)
        counted.append(StabilityChange(one.value, one.frequency, one.kind, one.direction, (growing, after)))
        growing = after
    return tuple(counted)


def _beyond_window(structure: Structure) -> Structure:
    """The structure with a window that holds modes somewhat beyond its ends as well."""
    low, high = structure.window
    return structure.in_window((max(0.0, low - MARGIN_SHARE * high), (1.0 + MARGIN_SHARE) * high))


class Candidate(NamedTuple):
    """Where a mode seems to begin or cease to grow.

    Parameters
    ----------
    value : float
        Of the parameter.
    frequency : float
        Hz.
    direction : "loss" or "regain"
    low, high : float
        Between which it is looked for.
    """

    value: float
    frequency: float
    direction: str
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class _Modes(Place):
    """The modes of a structure next to the imaginary axis at a value of a parameter.

    Parameters
    ----------
    at : float
        The parameter.
    growth : array (m,)
        Growth rates, 1/s: put lower the farther a mode is beyond the window, and a little below zero where
        they are nothing but rounding.
    growth_slopes : array (m,)
        Their derivatives by the parameter.
    slopes : complex array (m,)
        Those of the eigenvalues.
    couplings : array (m, m)
        sqrt(|c d|) of two modes, for a change of the parameter by one.
    """

    at: float
    growth: Array
    growth_slopes: Array
    slopes: ComplexArray
    couplings: Array

    @property
    def frequencies(self) -> Array:
        """Hz, (m,)."""
        return self.right.values.imag / (2 * np.pi)

    @property
    def drifts(self) -> Array:
        """Their derivatives by the parameter."""
        return self.slopes.imag / (2 * np.pi)

    def ranges(self, step: float) -> tuple[Array, Array]:
        """How far growth rates (m,) may move within a step, and what of it is due to other modes."""
        pushes = self.couplings * step
        apart = np.abs(self.right.values[:, None] - self.right.values)
        approach = SLOPE_FACTOR * step * np.abs(self.slopes[:, None] - self.slopes)
        pushed = np.where(apart < approach + REACH_FACTOR * pushes, pushes, 0.0).sum(axis=1)
        return SLOPE_FACTOR * step * np.abs(self.growth_slopes) + pushed, pushed


@dataclass(frozen=True, eq=False)
class Scan:
    """The growth rates of a structure's modes between two values of a parameter.

    Parameters
    ----------
    structure : Structure
        Of few freedoms, or without a window.
    parameter : str
    bounds : (float, float)
    """

    structure: Structure
    parameter: str
    bounds: tuple[float, float]

    def candidates(self) -> list[Candidate]:
        """Where growth rates change sign."""
        grid = np.linspace(*self.bounds, FIRST_INTERVALS + 1)
        nodes = [(at, self.modes(at)) for at in map(float, grid)]
        intervals = [(*pair, 0) for pair in pairwise(nodes)]
        found: list[Candidate] = []
        spectra, widest = len(nodes), 0.0
        while intervals:
            (low, a), (high, b), halvings = intervals.pop(0)
            at = 0.5 * (low + high)
            middle = self.modes(at)
            spectra += 1
            passes = _passes(a, middle, b)
            if passes is not None:
                found += passes
            elif halvings < MOST_HALVINGS and spectra < MOST_SPECTRA:
                ends = (low, a), (at, middle), (high, b)
                intervals += [(*pair, halvings + 1) for pair in pairwise(ends)]
            else:
                found += _differences(a, b)
                widest = max(widest, high - low if halvings < MOST_HALVINGS else 0.0)
        if widest:
            warnings.warn(
                f"changes of stability closer than {widest:.2g} in {self.parameter} were not all told apart: "
                "take a narrower range, or a narrower window",
                RuntimeWarning,
                4,
            )
        return found

    def modes(self, at: float) -> _Modes | None:
        """The modes at a value of the parameter; none where there is no equilibrium."""
        there = self.structure.at_values({self.parameter: at})
        try:
            pencil, derivative = there.pencil, there.pencil_derivative(self.parameter)
        except ValueError:
            return None
        right, left = _pairs(pencil)
        chosen = np.flatnonzero(self._matters(right.values))
        right = Spectrum(right.values[chosen], right.vectors[:, chosen])
        left = Spectrum(right.values, left[:, chosen])
        products = left.vectors.T @ derivative.products(*right)
        right, left, products = _separated(right, left, products)
        slopes = -np.diagonal(products)
        couplings = np.sqrt(np.abs(products * products.T))
        np.fill_diagonal(couplings, 0.0)
        growth = effective_growth(self.structure.window, right.values, slopes)
        return _Modes({self.parameter: at}, pencil, right, left, at, *growth, slopes, couplings)

    def _matters(self, values: ComplexArray) -> NDArray[np.bool_]:
        """Which modes are next to the imaginary axis, and to the window."""
        low, high = self.structure.window or (0.0, np.inf)
        margin = MARGIN_SHARE * high if self.structure.window else 0.0
        frequencies = values.imag / (2 * np.pi)
        chosen = (frequencies >= max(0.0, low - margin)) & (frequencies <= high + margin)
        if np.iscomplexobj(self.structure.structural_pencil.K.data):
            chosen &= values.imag > 0.0
        return chosen & (values.real > -DAMPED_SHARE * 2 * np.pi * high)


def effective_growth(
    window: tuple[float, float] | None, values: ComplexArray, slopes: ComplexArray
) -> tuple[Array, Array]:
    """Growth rates (m,) as `_Modes` has them, and their derivatives."""
    rates, rises = values.real.copy(), slopes.real.copy()
    largest = np.abs(values).max(initial=0.0)
    if window is not None:
        low, high = (2 * np.pi * end for end in window)
        above, below = values.imag > high, values.imag < low
        rates -= np.where(above, values.imag - high, 0.0) + np.where(below, low - values.imag, 0.0)
        rises += np.where(below, slopes.imag, 0.0) - np.where(above, slopes.imag, 0.0)
        largest = max(high, largest)
    neutral = np.abs(rates) < NEUTRAL_RTOL * largest
    return np.where(neutral, -NEUTRAL_RTOL * largest, rates), np.where(neutral, 0.0, rises)


def _pairs(pencil: QuadraticPencil) -> tuple[Spectrum, Any]:
    """All eigenvalues with their vectors, and left vectors (n, m), y Q'(s) x = 1."""
    right = dense_spectrum(pencil)
    if not pencil.states and len(right.values) == 2 * pencil.size:
        states = np.vstack([right.vectors, right.values * right.vectors])
        with np.errstate(all="ignore"):
            try:
                rows = np.linalg.inv(states)[:, pencil.size :]
                return right, np.linalg.solve(pencil.M.T.toarray(), rows.T)
            except np.linalg.LinAlgError:  # modes coalesce
                pass
    return right, left_vectors_of(pencil, right, lambda: dense_spectrum(pencil.transposed()))


def _separated(
    right: Spectrum, left: Spectrum, products: ComplexArray
) -> tuple[Spectrum, Spectrum, ComplexArray]:
    """Of equal eigenvalues the vectors that have slopes of their own; y (dQ/dp) x (m, m) of all."""
    values, m = right.values, len(right.values)
    mix = np.eye(m, dtype=complex)
    for group in {tuple(np.flatnonzero(row)) for row in equal_values(values) if row.sum() > 1}:
        places = np.ix_(group, group)
        mix[places] = np.linalg.eig(products[places])[1]
    if (mix == np.eye(m)).all():
        return right, left, products
    back = np.linalg.pinv(mix)
    return (
        Spectrum(values, right.vectors @ mix),
        Spectrum(values, left.vectors @ back.T),
        back @ products @ mix,
    )


def _passes(a: _Modes | None, middle: _Modes | None, b: _Modes | None) -> list[Candidate] | None:
    """Where growth rates change sign between `a` and `b`; None where this is not clear."""
    if a is None or middle is None or b is None:
        return [] if a is middle is b else None
    step = 0.5 * (b.at - a.at)
    nodes = a, middle, b
    ranges, pushes = zip(*(one.ranges(step) for one in nodes))
    doubtful = [np.abs(one.growth) <= reach for one, reach in zip(nodes, ranges)]
    chains = _chains(nodes, doubtful)
    if chains is None:
        return None
    columns = np.array(chains, dtype=np.intp).reshape(-1, 3).T
    others = [np.delete(one.growth, column) for one, column in zip(nodes, columns)]
    if len({int((rest > 0.0).sum()) for rest in others}) > 1:
        return None
    found = []
    for chain in chains:
        pushed = max(push[i] for push, i in zip(pushes, chain))
        change = _pass_of(nodes, chain, pushed)
        if change is None:
            return None
        found += change
    return found


def _chains(nodes: Sequence[_Modes], doubtful: Sequence[NDArray[np.bool_]]) -> list[tuple[int, ...]] | None:
    """Places in three nodes of the modes that are doubtful, or whose growth changes sign; None if unclear."""
    first, middle, last = nodes
    before, after = places_of_modes(middle, first), places_of_modes(middle, last)
    chains = []
    for i, (j, k) in enumerate(zip(before, after, strict=True)):
        unclear = doubtful[1][i] or (j >= 0 and doubtful[0][j]) or (k >= 0 and doubtful[2][k])
        if j >= 0 and k >= 0:
            signs = np.sign([first.growth[j], middle.growth[i], last.growth[k]])
            if unclear or len({*signs}) > 1:
                chains.append((int(j), i, int(k)))
        elif unclear:
            return None
    for ends, match in ((doubtful[0], before), (doubtful[2], after)):
        if ends[np.setdiff1d(np.arange(len(ends)), match)].any():
            return None
    return chains


def _pass_of(nodes: Sequence[_Modes], chain: Sequence[int], pushed: float) -> list[Candidate] | None:
    """Whether a mode's growth rate changes sign between nodes, by cubics; None where this is not clear."""
    at = np.array([one.at for one in nodes])
    growth, slopes = _columns(nodes, chain, "growth", "growth_slopes")
    whole = CubicHermiteSpline(at[::2], growth[::2], slopes[::2])
    error = SPLINE_SHARE * abs(float(whole(at[1])) - growth[1]) + pushed
    spline = CubicHermiteSpline(at, growth, slopes)
    shape = spline(np.linspace(at[0], at[2], SPLINE_POINTS))
    if np.abs(shape).min() > error and len({*np.sign(shape)}) == 1:
        return []
    steps = np.diff(shape)
    monotonous = (steps > 0.0).all() or (steps < 0.0).all()
    if (
        not monotonous
        or pushed
        or min(abs(growth[0]), abs(growth[2])) <= error
        or growth[0] * growth[2] > 0.0
    ):
        return None
    value = float(spline.roots(extrapolate=False)[0])
    frequencies, drifts = _columns(nodes, chain, "frequencies", "drifts")
    frequency = float(CubicHermiteSpline(at, frequencies, drifts)(value))
    direction = "loss" if growth[2] > 0.0 else "regain"
    return [Candidate(value, max(frequency, 0.0), direction, float(at[0]), float(at[2]))]


def _columns(nodes: Sequence[_Modes], chain: Sequence[int], *names: str) -> list[Array]:
    """Numbers of a mode at nodes, by name."""
    return [np.array([getattr(one, name)[i] for one, i in zip(nodes, chain)]) for name in names]


def _differences(a: _Modes | None, b: _Modes | None) -> list[Candidate]:
    """The changes in an interval that is too short to be halved: modes that grow at one end only."""
    if a is None or b is None:
        return []
    more, fewer, direction = (b, a, "loss") if _growing(b) > _growing(a) else (a, b, "regain")
    values, others = more.right.values[more.growth > 0.0], fewer.right.values[fewer.growth > 0.0]
    if len(others):
        _, known = linear_sum_assignment(np.abs(others[:, None] - values))
        values = np.delete(values, known)
    middle, ends = 0.5 * (a.at + b.at), (2.0 * a.at - b.at, 2.0 * b.at - a.at)
    return [Candidate(middle, float(value.imag) / (2 * np.pi), direction, *ends) for value in values]


def _growing(modes: _Modes) -> int:
    return int((modes.growth > 0.0).sum())


def _settled(
    structure: Structure, parameter: str, candidate: Candidate, bounds: tuple[float, float]
) -> StabilityChange | None:
    """A change of the full structure, where a candidate is one, by Newton's method."""
    width = bounds[1] - bounds[0]
    value, guess = candidate.value, 2j * np.pi * candidate.frequency
    for _ in range(REFINEMENTS):
        there = structure.at_values({parameter: value})
        try:
            mode = there.pencil.mode_at(guess)
        except ValueError:  # without an equilibrium there
            break
        if mode is None:
            break
        slope = there.pencil_derivative(parameter).slope_of(mode)
        if (slope.real > 0.0) != (candidate.direction == "loss"):
            break
        step = mode.value.real / slope.real
        value, guess = value - step, mode.value - step * slope
        if not candidate.low <= value <= candidate.high:
            break
        if abs(step) <= NEWTON_RTOL * width or abs(mode.value.real) <= ROUNDING * abs(mode.value):
            kind = StabilityKind.FLUTTER if guess.imag else StabilityKind.DIVERGENCE
            return StabilityChange(value, abs(guess.imag) / (2 * np.pi), kind, candidate.direction, (0, 0))
    return _settled_by_reductions(structure, parameter, candidate, bounds)


def _settled_by_reductions(
    structure: Structure, parameter: str, candidate: Candidate, bounds: tuple[float, float]
) -> StabilityChange | None:
    """A change where growth rates have no slope, as where modes coalesce without damping.

    It is found in a reduction to modes of a narrow range of frequencies, at both sides of it and at its own
    place, where the reduction is exact.
    """
    narrow, width = structure, bounds[1] - bounds[0]
    scale = candidate.frequency or 1.0
    if structure.window is not None:
        half = NARROW_SHARE * structure.window[1]
        ends = max(structure.window[0], candidate.frequency - half), candidate.frequency + half
        narrow, scale = structure.in_window((ends[0], min(ends[1], structure.window[1]))), half
    value, change = candidate.value, None
    near = (max(value - NEAR_SHARE * width, bounds[0]), min(value + NEAR_SHARE * width, bounds[1]))
    samples = [one for one in Sample.where_known(narrow, ({parameter: at} for at in near)) if one]
    for _ in range(REFINEMENTS):
        local = reduced(narrow, samples, EXACT)
        alike = [
            one
            for one in changes_of_few_freedoms(local, parameter, near)
            if one.direction == candidate.direction
        ]
        if not alike:
            return None
        before = value
        change = min(
            alike,
            key=lambda one: (
                abs(one.frequency - candidate.frequency) / scale + abs(one.value - before) / width
            ),
        )
        value = change.value
        if abs(value - before) <= SETTLED_RTOL * width:
            break
        samples.append(Sample.of(narrow, {parameter: value}))
    return change


def _is_same(a: StabilityChange, b: StabilityChange, width: float) -> bool:
    same = abs(a.value - b.value) <= SAME_RTOL * width and a.direction == b.direction
    return same and abs(a.frequency - b.frequency) <= SAME_RTOL * max(a.frequency, b.frequency)
