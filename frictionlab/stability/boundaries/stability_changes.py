"""`fl.stability_changes`, `fl.critical_value`, `fl.critical_curve`: every loss and regain of stability in a
range, or the first for each of many values of other parameters.

The growth rates are sorted, the largest first: the k-th is a continuous function of the parameter, and its
sign changes exactly where the number of growing eigenvalues passes k.  Brackets of these changes are found by
halving intervals; in each the change is solved for.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from frictionlab.models.model import ModelOrAutomaton, check_parameter_name
from frictionlab.presentation import Drawable, Kind, count, span
from frictionlab.stability.equilibrium_points.equilibria import (
    Equilibrium,
    equilibrium_problem,
)
from frictionlab.stability.equilibrium_problem import (
    EquilibriumProblem,
    check_bounds,
    check_parameter,
)
from frictionlab.stability.large_system import LargeSystem
from frictionlab.stability.state_matrices import (
    NEUTRAL_RTOL,
    ComplexArray,
    eigenvalue_distances,
    equal_eigenvalues,
    growth_rates,
    growth_scales,
    unstable_pairs,
)
from frictionlab.validation import abbreviate, check_pair, float_array

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]
GRID_POINTS, MAX_HALVINGS = 129, 24
COARSE_POINTS, COARSE_HALVINGS = 5, 18  # for lines on which few changes are expected
# Most intervals, over those of the first grid: two modes may share one eigenvalue everywhere.
MAX_INTERVAL_FACTOR = 8
NO_CHANGE_RTOL = 1e-9  # share of the largest eigenvalue: one that moves by less counts as unmoved
# Shares of the largest eigenvalue: a growth rate that is larger at a root, or just inside it, has jumped.
FOLD_RATE_AT_ROOT, FOLD_RATE_INSIDE = 1e-6, 1e-4
OUTSIDE_SHARES = np.array([0.0, 1e-3, 1.0])  # of a bracket: how far outside it decay is looked for
INSIDE_SHARE = 1e-9  # of a bracket: how far "just inside" is
MIN_INSIDE_RTOL = 1e-12  # of the root: the least that this may be
DECAY_RTOL = 1e-13  # share of the largest eigenvalue: a rate below minus this decays
# Shares of the way from a regain to a loss.  If the mode grows there by more than rounding, its growth rate
# only touches zero.
TOUCH_SHARES = np.array([0.25, 0.75])
OUTSIDE_TOUCH_SHARES = np.array([-0.25, 1.25])  # of the same way: beside it
TOUCH_RTOL = 0.01 * NEUTRAL_RTOL  # of the largest eigenvalue
MAX_ROOT_STEPS = 200
MANY_LINES = 192  # of so many the critical points are searched in long intervals first
ROOT_STEPS = 60  # for one of them
SIDE_RTOL = 1e-7  # share of the bounds: how far from such a root, on either side, growth is checked
ROOT_RATE_RTOL = 1e-9  # of the largest eigenvalue: a growth rate that is larger at such a root has jumped
# Share of a root, or of the bounds.  If an equilibrium does not exist so far beyond a root, it ends there.
# When two equilibria annihilate each other, rounding lets one seem to exist up to some 1e-9 beyond the root.
END_RTOL = 1e-8
BORDER_RTOL = 1e-5  # share of the state by which an equilibrium may move over so short a way


class StabilityKind(Kind):
    """Kind of a change of stability."""

    FLUTTER = "flutter"
    DIVERGENCE = "divergence"
    FOLD = "fold"
    BORDER = "border"


@dataclass(frozen=True)
class StabilityChange:
    """A value of a parameter at which one mode becomes unstable, or stable again.

    Parameters
    ----------
    value : float
        The parameter's.
    frequency : float
        Of the mode, Hz; zero for divergence.
    kind : "flutter", "divergence", "fold" or "border"
        Flutter: a complex pair crosses the imaginary axis, as where modes couple.  Divergence: a real
        eigenvalue passes zero.  Fold: the equilibrium ends and another takes over.  Border: it passes the
        border of a law in pieces, where eigenvalues jump.
    direction : "loss" or "regain"
    unstable : (int, int)
        Number of growing pairs of eigenvalues below and above the value; two real ones count as a pair,
        one alone too.
    """

    value: float
    frequency: float
    kind: StabilityKind
    direction: str
    unstable: tuple[int, int]


def stability_changes(
    model: ModelOrAutomaton,
    parameter: str,
    bounds: Any,
    *,
    equilibrium: Equilibrium | None = None,
) -> tuple[StabilityChange, ...]:
    """Every change of stability of one equilibrium as a parameter grows.

    It is followed from the model's own value of the parameter, as far as it exists; where there is none, or a
    fold, from the nearest of 9 values in the range that has one.  If it ends and no other takes over, that is
    no change of stability: :class:`FoldValue` tells where it ends.

    The range is scanned.  The scan is finer where growth rates come near zero or two eigenvalues near each
    other, down to some 1e-9 of the range.  Each change is then solved for to rounding.

    Parameters
    ----------
    model : Model, HybridAutomaton or Structure
        Of a structure the modes within its window count.  Of one of more than 50 freedoms the weakly damped
        modes are followed in a reduction (:func:`reduce`); each change is that of the full structure.
    parameter : str
    bounds : (float, float)
    equilibrium : Equilibrium, optional
        One of ``equilibria(model)``; by default that of :func:`equilibrium`: of a SliderOnBelt the one with
        F_N > 0 and the smallest penetration, found anew at each value; of other models the one nearest to the
        origin.

    Returns
    -------
    tuple of StabilityChange
        By ascending value.

    Raises
    ------
    TypeError
        For an unknown parameter, or what is no model.
    ValueError
        For bounds that are not two ascending numbers or break the parameter's rule, or an equilibrium of
        another model.

    Warns
    -----
    RuntimeWarning
        For a structure, if changes were not told apart, or some were missed.

    Examples
    --------
    >>> import frictionlab as fl
    >>> [f"{c.kind} at {c.value:.5f}" for c in fl.stability_changes(fl.SliderOnBelt(), "mu_k", (0, 3))]
    ['flutter at 1.51378']
    """
    if isinstance(model, LargeSystem):
        return model.find_stability_changes(parameter, bounds)
    limits = check_bounds(model, parameter, bounds)
    problem = equilibrium_problem(model, equilibrium, {parameter: limits})
    return changes_on_lines(problem, parameter, limits, {})[0]


def critical_value(
    model: ModelOrAutomaton,
    parameter: str,
    bounds: Any,
    *,
    equilibrium: Equilibrium | None = None,
) -> float | None:
    """The first value at which one equilibrium loses stability as a parameter grows, or becomes stable.

    It is a loss if the equilibrium is stable at the lower bound, as where friction grows, and a regain if it
    is unstable there, as where a belt runs faster.  :func:`stability_changes` tells which, and what follows.
    None where neither happens in the range: the equilibrium is stable as far as it exists, or unstable, of
    which a warning tells.

    Parameters
    ----------
    model : Model, HybridAutomaton or Structure
    parameter : str
    bounds : (float, float)
    equilibrium : Equilibrium, optional
        As for :func:`stability_changes`.

    Raises
    ------
    TypeError, ValueError
        As :func:`stability_changes`.

    Warns
    -----
    RuntimeWarning
        Where the equilibrium is unstable in all of the range.

    Examples
    --------
    >>> import frictionlab as fl
    >>> round(fl.critical_value(fl.SliderOnBelt(), "mu_k", bounds=(0, 4)), 8)
    1.51378354
    """
    if isinstance(model, LargeSystem):
        subject, limits = model, bounds
        changes = model.find_stability_changes(parameter, bounds)
    else:
        limits = check_bounds(model, parameter, bounds)
        subject = equilibrium_problem(model, equilibrium, {parameter: limits})
        changes = changes_on_lines(subject, parameter, limits, {})[0]
    critical = critical_change(changes)
    if critical is not None:
        return critical.value
    if why := unstable_all_along(subject, parameter, limits[0], changes):
        warnings.warn(f"{why}: there is no critical value", RuntimeWarning, 2)
    return None


def unstable_all_along(
    subject: EquilibriumProblem | LargeSystem[Any],
    parameter: str,
    low: float,
    changes: tuple[StabilityChange, ...],
) -> str:
    """What to say of an equilibrium without a critical change that is unstable from the lower bound on.

    "" where it is stable.
    """
    if not changes and not subject.count_growing(parameter, low):
        return ""
    return f"the equilibrium is unstable from {parameter} = {low:g} on, in all of the range"


@dataclass(frozen=True, eq=False)
class CriticalCurve(Drawable):
    """Critical values of one parameter against another.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter, over : str
        The critical parameter, and the other one.
    at : array (N,)
        Values of `over`.
    values : array (N,)
        Critical values of `parameter`; NaN where there is none in the range.
    """

    drawn_by = "plot_critical"

    model: ModelOrAutomaton
    parameter: str
    over: str
    at: Array
    values: Array

    def __repr__(self) -> str:
        ranges = f"{self.parameter} {span(self.values)} over {self.over} {span(self.at)}"
        none = int(np.isnan(self.values).sum())
        return f"CriticalCurve({ranges}, {count(len(self.at), 'value')}{f', {none} without' if none else ''})"


def critical_curve(
    model: ModelOrAutomaton, parameter: str, bounds: Any, *, over: tuple[str, Any]
) -> CriticalCurve:
    """:func:`critical_value` for each value of another parameter, all at once.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    bounds : (float, float)
    over : (str, array_like (N,))
        The other parameter and its values.

    Raises
    ------
    ValueError
        As :func:`stability_changes`, for both parameters; if they are the same, or there are no values.

    Warns
    -----
    RuntimeWarning
        Where some values have no critical one: how many, and why.
    """
    curve, gaps = curve_and_gaps(model, parameter, bounds, over=over)
    if gaps:
        warnings.warn(gaps, RuntimeWarning, 2)
    return curve


def curve_and_gaps(
    model: ModelOrAutomaton, parameter: str, bounds: Any, *, over: tuple[str, Any]
) -> tuple[CriticalCurve, str]:
    """The curve of :func:`critical_curve`, and what to say of values without a critical one."""
    low, high = check_bounds(model, parameter, bounds)
    cure = 'give for example ("F", [100, 200])'
    name, numbers = check_pair("over", over, "a parameter and its values", cure)
    check_parameter_name(model, name)
    at = float_array("over", numbers, cure).ravel()
    check_parameter(model, name, at.tolist())
    if name == parameter or not at.size:
        raise ValueError(
            f"over must be another parameter than {parameter!r} and at least one value of it, "
            f"got {abbreviate(over)}: {cure}"
        )
    problem = equilibrium_problem(model, within={parameter: (low, high), name: at})
    critical = critical_points(problem, parameter, (low, high), {name: at})
    curve = CriticalCurve(model, parameter, name, at, critical.values)
    return curve, _gaps(problem, curve, low, high)


def _gaps(problem: EquilibriumProblem, curve: CriticalCurve, low: float, high: float) -> str:
    """How many values of a curve have no critical one, and why; "" where all have."""
    missing = np.isnan(curve.values)
    if not missing.any():
        return ""
    spectra = problem.spectra({curve.over: curve.at[missing], curve.parameter: np.full(missing.sum(), low)})
    exists, growing = np.isfinite(growth_rates(spectra)[:, 0]), unstable_pairs(spectra) > 0
    at_low = f"{curve.parameter} = {low:g}"
    reasons = {
        f"without an equilibrium at {at_low}": ~exists,
        f"unstable from {at_low} on": exists & growing,
        f"stable up to {high:g}, or as far as the equilibrium exists": exists & ~growing,
    }
    counted = [f"{int(flags.sum())} {why}" for why, flags in reasons.items() if flags.any()]
    return (
        f"no critical {curve.parameter} in {low:g} to {high:g} at {int(missing.sum())} of "
        f"{count(len(curve.at), 'value')} of {curve.over}: {', '.join(counted)}; they are NaN"
    )


def critical_change(changes: tuple[StabilityChange, ...]) -> StabilityChange | None:
    """The first change between no growing mode and one or more; None without one."""
    for change in changes:
        if 0 in change.unstable:
            return change
    return None


class CriticalPoints(NamedTuple):
    """Critical points on L lines: the parameter's value, and the frequency there in Hz; NaN for none."""

    values: Array
    frequencies: Array


def critical_points(
    problem: EquilibriumProblem, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Array]
) -> CriticalPoints:
    """The first critical point on each of L lines, along which `parameter` varies, and `fixed` (L,) do not.

    A scan takes some 300 spectra for a line, as it looks for every change, however narrow its window.  Many
    lines are searched in long intervals first, which takes a fifth.  As in any scan, an interval is halved if
    growth rates come near zero or eigenvalues near each other.  A line on which this does not find exactly
    one change, by flutter, or does not resolve all intervals, is scanned.
    """
    lines = Lines(problem, parameter, bounds, fixed)
    points = CriticalPoints(*np.full((2, lines.count), np.nan))
    rest = np.arange(lines.count)
    if lines.count >= MANY_LINES:
        rest = rest[~_single_changes(lines, points)]
    if len(rest):
        some = {name: column[rest] for name, column in fixed.items()}
        for line, changes in zip(rest, changes_on_lines(problem, parameter, bounds, some), strict=True):
            if (change := critical_change(changes)) is not None:
                points.values[line], points.frequencies[line] = change.value, change.frequency
    return points


class Lines(NamedTuple):
    """L lines in the space of the parameters: along them `parameter` varies, and `fixed` (L,) do not."""

    problem: EquilibriumProblem
    parameter: str
    bounds: tuple[float, float]
    fixed: Mapping[str, Array]

    @property
    def count(self) -> int:
        """How many there are."""
        return max(map(len, self.fixed.values()), default=1)

    def spectra(self, line: Any, values: Array) -> ComplexArray:
        """Sorted spectra (..., m) at values (...) on lines of these indices; NaN without an equilibrium."""
        line = np.broadcast_to(line, values.shape).ravel()
        fixed = {name: column[line] for name, column in self.fixed.items()}
        spectra = self.problem.spectra({**fixed, self.parameter: values.ravel()})
        return spectra.reshape(*values.shape, spectra.shape[-1])


def _single_changes(lines: Lines, points: CriticalPoints) -> Any:
    """Solve the lines on which there is one change, by flutter; returns which of them these are."""
    changes, resolved = _resolved_sign_changes(lines)
    alone = np.bincount(changes.line, minlength=lines.count) == 1
    held = (resolved & alone)[changes.line]  # of the changes
    line, ends = changes.line[held], (changes.still[held], changes.growing[held])
    roots = find_root(
        lambda at, line: lines.spectra(line.astype(int), at)[:, 0].real,
        ends,
        args=(line,),
        maxiter=ROOT_STEPS,
    ).x
    line, roots = line[np.isfinite(roots)], roots[np.isfinite(roots)]
    at, side = lines.spectra(line, roots), SIDE_RTOL * np.ptp(lines.bounds)
    growing = (growth_rates(lines.spectra(line, np.array([roots - side, roots + side]))) > 0).sum(axis=-1)
    passes = (growing.min(axis=0) == 0) & (growing.max(axis=0) == 2) & (at[:, 0].imag != 0.0)
    passes &= np.abs(at[:, 0].real) <= ROOT_RATE_RTOL * growth_scales(at)[:, 0]  # else it jumps there
    points.values[line[passes]] = roots[passes]
    points.frequencies[line[passes]] = np.abs(at[passes, 0].imag) / (2 * np.pi)
    return np.isin(np.arange(lines.count), line[passes])


def changes_on_lines(
    problem: EquilibriumProblem, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Array]
) -> list[tuple[StabilityChange, ...]]:
    """The changes on each of L lines, along which `parameter` varies and `fixed` (L,) do not."""
    lines = Lines(problem, parameter, bounds, fixed)
    brackets = _bracket_sign_changes(lines)
    changes: list[StabilityChange] = []
    if brackets.line.size:
        roots = _roots(lines, brackets)
        real = _is_there_beyond(lines, brackets, roots) & ~_only_touches(lines, brackets, roots)
        brackets = brackets.select(real)
        changes = _describe_changes(lines, brackets, roots[real])
    ends = np.searchsorted(brackets.line, np.arange(lines.count + 1)).tolist()
    return [tuple(changes[first:last]) for first, last in pairwise(ends)]


def _goes_on(lines: Lines, line: Any, value: float) -> bool:
    """Whether an equilibrium is the same on both sides of a value at which a growth rate jumps."""
    step = END_RTOL * max(abs(value), np.ptp(lines.bounds))
    sides = np.clip(value + step * np.array([-1.0, 1.0]), *lines.bounds)
    fixed = {name: column[[line, line]] for name, column in lines.fixed.items()}
    x = lines.problem.states({**fixed, lines.parameter: sides})
    return bool(np.abs(x[:, 1] - x[:, 0]).max() <= BORDER_RTOL * np.abs(x).max())


def _roots(lines: Lines, brackets: Brackets) -> Array:
    start, shift = _starts(lines, brackets)

    def rate(at: Array, line: Any, rank: Any, shift: Any) -> Array:
        return eigenvalue_at_rank(lines.spectra(line.astype(int), at), rank.astype(int)).real - shift

    root = find_root(
        rate, (start, brackets.growing), args=(brackets.line, brackets.rank, shift), maxiter=MAX_ROOT_STEPS
    )
    # Where there is no root, the equilibrium ends.
    return np.where(np.isfinite(root.x), root.x, 0.5 * (brackets.still + brackets.growing))


def _is_there_beyond(lines: Lines, brackets: Brackets, roots: Array) -> Any:
    """Whether an equilibrium exists on both sides of each root; if not, stability does not change there."""
    step = END_RTOL * np.maximum(np.abs(roots), np.ptp(lines.bounds))
    sides = lines.spectra(brackets.line, np.clip([roots - step, roots + step], *lines.bounds))
    return np.isfinite(sides).all(axis=(0, 2))


def _only_touches(lines: Lines, brackets: Brackets, roots: Array) -> Any:
    """Which changes are no changes: a regain and a loss, and the mode grows in between.

    A growth rate may come down to zero and rise again, as (p - a)^2 does.  Within some 1e-5 on either side of
    a it is too small to be told from zero, but it does not become negative.  So stability does not change.

    A slow mode is judged by its own size, but for where its eigenvalue comes out as zero.  Such a zero is one
    of rounding if just outside, too, the growth would count as zero beside the fastest mode.
    """
    touches = np.zeros(len(roots), dtype=bool)
    if len(roots) < 2:
        return touches
    regain = brackets.still > brackets.growing
    pairs = (brackets.line[1:] == brackets.line[:-1]) & (brackets.rank[1:] == brackets.rank[:-1])
    first = np.flatnonzero(pairs & regain[:-1] & ~regain[1:])
    line, rank, start, width = brackets.line[first], brackets.rank[first], roots[first], np.diff(roots)[first]
    beside = start + OUTSIDE_TOUCH_SHARES[:, None] * width
    beside = np.clip(beside, brackets.growing[first], brackets.growing[first + 1])
    outside = eigenvalue_at_rank(lines.spectra(line, beside), rank).real.max(axis=0)
    spectra = lines.spectra(line, start + TOUCH_SHARES[:, None] * width)
    rate, scale = eigenvalue_at_rank(spectra, rank).real, eigenvalue_at_rank(growth_scales(spectra), rank)
    rounding = (rate >= -DECAY_RTOL * scale) & (outside < NEUTRAL_RTOL * scale)
    grows = (rounding | (rate > TOUCH_RTOL * scale)).all(axis=0)
    touches[first[grows]] = touches[first[grows] + 1] = True
    return touches


def _starts(lines: Lines, brackets: Brackets) -> tuple[Array, Array]:
    """One end of the search for each root, and the growth rate that is solved for.

    In general the mode decays at this end, and the growth rate that is solved for is zero.  The end may lie
    outside the bracket, since the growth rate is as good as zero near a root.  Without damping no mode
    decays.  Then the end is that where the mode does not grow, and the growth rate is the least that counts
    as growth.
    """
    still = brackets.still
    outside = np.clip(still + OUTSIDE_SHARES[:, None] * (still - brackets.growing), *lines.bounds)
    spectra = lines.spectra(brackets.line, outside)
    scale = eigenvalue_at_rank(growth_scales(spectra), brackets.rank)
    decays = eigenvalue_at_rank(spectra, brackets.rank).real < -DECAY_RTOL * scale
    nearest = outside[decays.argmax(axis=0), np.arange(len(still))]
    some = decays.any(axis=0)
    return np.where(some, nearest, still), np.where(some, 0.0, NEUTRAL_RTOL * scale[-1])


def eigenvalue_at_rank(spectra: Any, rank: Indices) -> Any:
    """The eigenvalue (..., N) with the `rank`-th largest growth rate of each of N spectra (..., N, m)."""
    return spectra[..., np.arange(len(rank)), rank]


def _describe_changes(lines: Lines, brackets: Brackets, roots: Array) -> list[StabilityChange]:
    step = brackets.growing - roots
    # A bracket may be as narrow as rounding.
    least = np.minimum(MIN_INSIDE_RTOL * np.abs(roots), np.abs(step))
    inside = roots + np.copysign(np.maximum(INSIDE_SHARE * np.abs(step), least), step)
    low, high = (np.full_like(roots, bound) for bound in lines.bounds)
    spectra = lines.spectra(brackets.line, np.array([inside, roots, low, high]))
    # Just inside: at the root itself all growth rates may be zero, or a real eigenvalue part of a pair.
    critical, at_root = eigenvalue_at_rank(spectra[:2], brackets.rank)
    size = np.nanmax(np.abs(spectra[1:]), axis=(0, 2), initial=0.0)
    # A growth rate that is not small at its root jumps there, because the equilibrium ends.
    smooth = np.abs(at_root.real) <= FOLD_RATE_AT_ROOT * size
    smooth &= np.abs(critical.real) <= FOLD_RATE_INSIDE * size
    frequencies = np.where(smooth, np.abs(critical.imag) / (2 * np.pi), 0.0).tolist()
    below, above = (growth_rates(brackets.spectra) > 0).sum(axis=-1)
    unstable = unstable_pairs(brackets.spectra).T.tolist()
    changes = []
    for i, root in enumerate(roots.tolist()):
        if smooth[i]:
            kind = StabilityKind.FLUTTER if frequencies[i] else StabilityKind.DIVERGENCE
        else:
            kind = StabilityKind.BORDER if _goes_on(lines, brackets.line[i], root) else StabilityKind.FOLD
        direction = "loss" if below[i] < above[i] else "regain"
        changes.append(StabilityChange(root, frequencies[i], kind, direction, tuple(unstable[i])))
    return changes


class Intervals(NamedTuple):
    """N intervals of lines."""

    line: Indices  # (N,) index of the line
    ends: Array  # (2, N)
    spectra: ComplexArray  # (2, N, m) at the ends, the largest growth rate first

    def select(self, some: Any) -> Intervals:
        """Some of the intervals."""
        return Intervals(self.line[some], self.ends[:, some], self.spectra[:, some])


class Brackets(NamedTuple):
    """N intervals in each of which one growth rate changes its sign."""

    line: Indices  # (N,) index of the line
    rank: Indices  # (N,) the growth rate's index among the sorted
    still: Array  # (N,) the end where the mode does not grow
    growing: Array  # (N,) that where it does
    spectra: ComplexArray  # (2, N, m) at the lower and the upper end

    def select(self, some: Flags) -> Brackets:
        """Some of the brackets."""
        rows = self.line[some], self.rank[some], self.still[some], self.growing[some]
        return Brackets(*rows, self.spectra[:, some])


def _bracket_sign_changes(lines: Lines) -> Brackets:
    """All changes of sign within the bounds, by line and ascending parameter."""
    pieces = _grid(lines, GRID_POINTS)
    most = MAX_INTERVAL_FACTOR * len(pieces.line)
    single, pieces = _refined(lines, pieces, MAX_HALVINGS, most)
    clusters = pieces if len(pieces.line) > most else _join_neighbours(pieces)
    return _brackets([*single, clusters.select(_sign_changes(clusters.spectra).any(axis=1))])


def _resolved_sign_changes(lines: Lines) -> tuple[Brackets, Flags]:
    """As :func:`_bracket_sign_changes` with fewer spectra, and on which lines (L,) these are all changes.

    The first intervals are long.  If growth rates come near zero in one, or two eigenvalues near each other,
    it may hide a change.  It is halved, up to a limit.  A line on which such an interval is left is not
    resolved.
    """
    pieces = _grid(lines, COARSE_POINTS)
    single, unclear = _refined(lines, pieces, COARSE_HALVINGS, MAX_INTERVAL_FACTOR * len(pieces.line))
    resolved = np.ones(lines.count, dtype=bool)
    resolved[unclear.line] = False
    return _brackets(single), resolved


def _grid(lines: Lines, points: int) -> Intervals:
    """The intervals between so many points, the same on all lines."""
    low, high = lines.bounds
    at = np.tile(low + (high - low) * np.linspace(0.0, 1.0, points), (lines.count, 1))
    line = np.arange(lines.count)[:, None]
    spectra = lines.spectra(line, at)
    ends = np.array([at[:, :-1], at[:, 1:]]).reshape(2, -1)
    at_ends = np.array([spectra[:, :-1], spectra[:, 1:]]).reshape(*ends.shape, -1)
    return Intervals(line.repeat(points - 1), ends, at_ends)


def _refined(lines: Lines, pieces: Intervals, halvings: int, most: int) -> tuple[list[Intervals], Intervals]:
    """Halve intervals until each has no change or a single one; those with one, and those left over."""
    singles: list[Intervals] = []
    for _ in range(halvings):
        middle = 0.5 * (pieces.ends[0] + pieces.ends[1])
        at_middle = lines.spectra(pieces.line, middle)
        clear, single = _classify_intervals(pieces.spectra, at_middle)
        singles.append(pieces.select(single))
        unclear = ~clear & ~single
        line, (low, high), (at_low, at_high) = pieces.select(unclear)
        middle, at_middle = middle[unclear], at_middle[unclear]
        ends = np.array([[low, middle], [middle, high]]).reshape(2, -1)
        spectra = np.array([[at_low, at_middle], [at_middle, at_high]])
        pieces = Intervals(np.tile(line, 2), ends, spectra.reshape(*ends.shape, spectra.shape[-1]))
        if not pieces.line.size or len(pieces.line) > most:
            break
    return singles, pieces


def _classify_intervals(spectra: ComplexArray, at_middle: ComplexArray) -> tuple[Flags, Flags]:
    """Whether no growth rate changes sign in an interval; whether exactly one does, or that of one pair."""
    rates = growth_rates(np.array([spectra[0], at_middle, spectra[1]]))
    missing = np.isnan(rates[:, :, 0])
    a, b, c = rates
    same_sign = (np.sign(a) == np.sign(b)) & (np.sign(b) == np.sign(c))
    # A parabola through the three values dips below the least of them by at most an eighth of this.
    bend = np.abs(a - 2 * b + c)
    least = np.abs(rates).min(axis=0)
    room = same_sign & (least > bend)
    passes = ~same_sign & (((a <= b) & (b <= c)) | ((a >= b) & (b >= c)))
    known = ~missing.any(axis=0) & ~_may_coalesce(spectra, at_middle, least)
    single = known & _one_mode(passes, spectra) & (room | passes).all(axis=1)
    return missing.all(axis=0) | (known & room.all(axis=1)), single


def _one_mode(passes: Flags, spectra: ComplexArray) -> Flags:
    """Whether the growth rates that pass zero are those of one mode: a real one, or a conjugate pair."""
    count, first = passes.sum(axis=1), passes.argmax(axis=1)
    second = np.minimum(first + 1, passes.shape[1] - 1)
    conjugate = eigenvalue_at_rank(spectra, first) == np.conj(eigenvalue_at_rank(spectra, second))
    pair = eigenvalue_at_rank(passes, second) & conjugate.all(axis=0)
    return (count == 1) | ((count == 2) & pair)


def _may_coalesce(spectra: ComplexArray, at_middle: ComplexArray, least: Array) -> Flags:
    """Whether two eigenvalues may coalesce unseen while growth rates are near zero.

    The weaker two modes couple, the narrower is the window in which they are unstable.
    """
    to_ends = eigenvalue_distances(at_middle, spectra)
    distance = to_ends.min(axis=-1).max(axis=0)
    between = eigenvalue_distances(at_middle, at_middle)
    between[:, range(distance.shape[1]), range(distance.shape[1])] = np.inf
    # A pair that is about to become two real eigenvalues is close to its conjugate, which does not matter.
    between[at_middle.imag[:, :, None] * at_middle.imag[:, None, :] < 0] = np.inf
    equal = equal_eigenvalues(at_middle)
    if equal.any():  # nor do modes whose eigenvalues are equal at the ends too
        at_ends = equal_eigenvalues(spectra).any(axis=-1)
        stay: Any = np.take_along_axis(at_ends, to_ends.argmin(axis=-1), axis=-1).all(axis=0)
        between[equal & stay[:, :, None]] = np.inf
    distance[distance < NO_CHANGE_RTOL * growth_scales(at_middle)] = 0.0
    close = between < 2 * (distance[:, :, None] + distance[:, None, :])
    within_reach = between + distance[:, :, None] > least.min(axis=1)[:, None, None]
    return (close & within_reach & np.isfinite(between)).any(axis=(1, 2))


def _join_neighbours(pieces: Intervals) -> Intervals:
    """Join neighbouring intervals: changes that are too close to be resolved count as simultaneous."""
    if not pieces.line.size:
        return pieces
    line, (low, high), spectra = pieces.select(np.lexsort((pieces.ends[0], pieces.line)))
    new = np.append(True, (line[1:] != line[:-1]) | (low[1:] > high[:-1]))
    last = np.append(np.flatnonzero(new)[1:] - 1, len(new) - 1)
    return Intervals(
        line[new], np.array([low[new], high[last]]), np.array([spectra[0, new], spectra[1, last]])
    )


def _sign_changes(spectra: ComplexArray) -> Flags:
    """Which growth rates (N, m) change sign; none do where the equilibrium itself begins or ends."""
    grows = growth_rates(spectra) > 0
    return np.isfinite(spectra).all(axis=0) & (grows[0] != grows[1])


def _brackets(intervals: list[Intervals]) -> Brackets:
    """The intervals as brackets, by line and ascending parameter."""
    lines, ends, spectra = zip(*intervals)
    every = Intervals(np.concatenate(lines), np.concatenate(ends, axis=1), np.concatenate(spectra, axis=1))
    line, (low, high), spectra = every.select(np.lexsort((every.ends[0], every.line)))
    rank = _sign_changes(spectra).argmax(axis=1)
    before, after = eigenvalue_at_rank(spectra, rank).real
    rises = after > before
    return Brackets(line, rank, np.where(rises, low, high), np.where(rises, high, low), spectra)
