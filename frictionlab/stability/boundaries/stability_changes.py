"""`fl.stability_changes`, `fl.critical_value`, `fl.critical_curve`: every loss and regain of stability in a
range, or the first for each of many values of other parameters.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from frictionlab.models.model import ModelOrAutomaton, check_parameter_name
from frictionlab.presentation import Drawable, Kind, count, span
from frictionlab.stability.equilibrium_points.equilibria import Equilibrium, equilibrium_problem
from frictionlab.stability.equilibrium_problem import (
    EquilibriumProblem,
    check_bounds,
    check_parameter,
)
from frictionlab.stability.large_system import LargeSystem
from frictionlab.stability.state_matrices import NEUTRAL_RTOL, growth_rates, growth_scales, unstable_pairs
from frictionlab.validation import abbreviate, check_pair, float_array

from .sign_changes import Brackets, Evaluate, bracket_sign_changes, resolved_sign_changes

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
# Shares of the largest eigenvalue: a growth rate that is larger at a root, or just inside it, has jumped.
FOLD_RATE_AT_ROOT, FOLD_RATE_INSIDE = 1e-6, 1e-4
OUTSIDE_SHARES = np.array([0.0, 1e-3, 1.0])  # of a bracket: how far outside it decay is looked for
INSIDE_SHARE = 1e-9  # of a bracket: how far "just inside" is
MIN_INSIDE_RTOL = 1e-12  # of the root: the least that this may be
DECAY_RTOL = 1e-13  # share of the largest eigenvalue: a rate below minus this decays
# Shares of the way from a regain to a loss.  If the mode grows there by more than rounding, its growth rate
# only touches zero.
TOUCH_SHARES = (0.25, 0.75)
OUTSIDE_TOUCH_SHARES = (-0.25, 1.25)  # of the same way: beside it
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
    model: ModelOrAutomaton | LargeSystem[Any],
    parameter: str,
    bounds: Any,
    *,
    equilibrium: Equilibrium | None = None,
) -> tuple[StabilityChange, ...]:
    """Every change of stability of one equilibrium as a parameter grows.

    It is followed from the model's own value of the parameter, as far as it exists.  If it ends and no other
    takes over, that is no change of stability: :class:`FoldValue` tells where it ends.

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
    problem = equilibrium_problem(model, equilibrium)
    low, high = check_bounds(problem.model, parameter, bounds)
    return changes_on_lines(problem, parameter, (low, high), {})[0]


def critical_value(
    model: ModelOrAutomaton | LargeSystem[Any],
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
        changes = model.find_stability_changes(parameter, bounds)
        why = _growth_all_along(model.count_growing, parameter, bounds[0], changes)
    else:
        problem = equilibrium_problem(model, equilibrium)
        limits = check_bounds(problem.model, parameter, bounds)
        changes = changes_on_lines(problem, parameter, limits, {})[0]
        why = unstable_all_along(problem, parameter, limits, changes)
    critical = critical_change(changes)
    if critical is None and why:
        warnings.warn(f"{why}: there is no critical value", RuntimeWarning, 2)
    return None if critical is None else critical.value


def unstable_all_along(
    problem: EquilibriumProblem,
    parameter: str,
    bounds: tuple[float, float],
    changes: tuple[StabilityChange, ...],
) -> str:
    """What to say of an equilibrium that is unstable in all of a range; "" where it is not."""

    def count_growing(name: str, value: float) -> int:
        return int(unstable_pairs(problem.spectra({name: value}))[0])

    return _growth_all_along(count_growing, parameter, bounds[0], changes)


def _growth_all_along(
    count_growing: Callable[[str, float], int],
    parameter: str,
    low: float,
    changes: tuple[StabilityChange, ...],
) -> str:
    if critical_change(changes) is not None or not (changes or count_growing(parameter, low)):
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
    problem = equilibrium_problem(model)
    low, high = check_bounds(problem.model, parameter, bounds)
    cure = 'give for example ("F", [100, 200])'
    name, numbers = check_pair("over", over, "a parameter and its values", cure)
    check_parameter_name(problem.model, name)
    at = float_array("over", numbers, cure).ravel()
    check_parameter(problem.model, name, at.tolist())
    if name == parameter or not at.size:
        raise ValueError(
            f"over must be another parameter than {parameter!r} and at least one value of it, "
            f"got {abbreviate(over)}: {cure}"
        )
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
    return next((c for c in changes if 0 in c.unstable), None)


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
    count = max((len(column) for column in fixed.values()), default=1)
    points = CriticalPoints(np.full(count, np.nan), np.full(count, np.nan))
    left = np.arange(count)
    if count >= MANY_LINES:
        left = left[~_single_changes(problem, parameter, bounds, fixed, points)]
    if len(left):
        some = {name: column[left] for name, column in fixed.items()}
        for line, changes in zip(left, changes_on_lines(problem, parameter, bounds, some), strict=True):
            if (change := critical_change(changes)) is not None:
                points.values[line], points.frequencies[line] = change.value, change.frequency
    return points


def _single_changes(
    problem: EquilibriumProblem,
    parameter: str,
    bounds: tuple[float, float],
    fixed: Mapping[str, Array],
    points: CriticalPoints,
) -> Any:
    """Solve the lines on which there is one change, by flutter; returns which of them these are."""
    count = len(points.values)

    def spectra(line: Any, at: Array) -> Any:
        lines = np.asarray(line, dtype=int)
        return problem.spectra({**{name: column[lines] for name, column in fixed.items()}, parameter: at})

    changes, resolved = resolved_sign_changes(spectra, *(np.full(count, bound) for bound in bounds))
    alone = np.bincount(changes.line, minlength=count) == 1
    held = (resolved & alone)[changes.line]  # of the changes
    line, ends = changes.line[held], (changes.low[held], changes.high[held])
    roots = find_root(
        lambda at, line: spectra(line, at)[:, 0].real, ends, args=(line.astype(float),), maxiter=ROOT_STEPS
    ).x
    line, roots = line[np.isfinite(roots)], roots[np.isfinite(roots)]
    at, side = spectra(line, roots), SIDE_RTOL * (bounds[1] - bounds[0])
    before, after = ((growth_rates(spectra(line, roots + shift)) > 0).sum(axis=1) for shift in (-side, side))
    passes = (np.minimum(before, after) == 0) & (np.maximum(before, after) == 2) & (at[:, 0].imag != 0.0)
    passes &= np.abs(at[:, 0].real) <= ROOT_RATE_RTOL * growth_scales(at)[:, 0]  # else it jumps there
    points.values[line[passes]] = roots[passes]
    points.frequencies[line[passes]] = np.abs(at[passes, 0].imag) / (2 * np.pi)
    return np.isin(np.arange(count), line[passes])


def changes_on_lines(
    problem: EquilibriumProblem, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Array]
) -> list[tuple[StabilityChange, ...]]:
    """The changes on each of L lines, along which `parameter` varies and `fixed` (L,) do not."""
    count = max((len(column) for column in fixed.values()), default=1)

    def evaluate(line: Indices, at: Array) -> Any:
        return problem.spectra({**{name: column[line] for name, column in fixed.items()}, parameter: at})

    low, high = (np.full(count, bound) for bound in bounds)
    brackets = bracket_sign_changes(evaluate, low, high)
    roots = _roots(evaluate, brackets, bounds)
    real = _is_there_beyond(evaluate, brackets, roots, bounds) & ~_only_touches(evaluate, brackets, roots)
    columns: Any = (column[real] for column in brackets)
    brackets, roots = Brackets(*columns), roots[real]
    changes = _describe_changes(evaluate, brackets, roots, bounds)
    for i, line in enumerate(brackets.line):
        if changes[i].kind == StabilityKind.FOLD:
            at = {name: column[[line]] for name, column in fixed.items()}
            if _goes_on(problem, changes[i].value, parameter, at, bounds):
                changes[i] = replace(changes[i], kind=StabilityKind.BORDER)
    return [
        tuple(c for c, line in zip(changes, brackets.line, strict=True) if line == i) for i in range(count)
    ]


def _goes_on(
    problem: EquilibriumProblem,
    value: float,
    parameter: str,
    fixed: Mapping[str, Array],
    bounds: tuple[float, float],
) -> bool:
    """Whether an equilibrium is the same on both sides of a value at which a growth rate jumps."""
    step = END_RTOL * max(abs(value), bounds[1] - bounds[0])
    sides = np.clip(value + step * np.array([-1.0, 1.0]), *bounds)
    x = problem.solve(*problem.at({**{name: one.repeat(2) for name, one in fixed.items()}, parameter: sides}))
    return bool(np.abs(x[:, 1] - x[:, 0]).max() <= BORDER_RTOL * np.abs(x).max())


def _roots(evaluate: Evaluate, brackets: Brackets, bounds: tuple[float, float]) -> Array:
    if not brackets.line.size:
        return np.zeros(0)
    still, growing = _bracket_sides(evaluate, brackets)
    outside = np.clip(still + OUTSIDE_SHARES[:, None] * (still - growing), *bounds)
    start, shift = _starts(evaluate, brackets, still, outside)

    def rate(at: Array, line: Any, rank: Any, shift: Any) -> Array:
        return eigenvalue_at_rank(evaluate(line.astype(int), at), rank.astype(int)).real - shift

    root = find_root(
        rate, (start, growing), args=(brackets.line, brackets.rank, shift), maxiter=MAX_ROOT_STEPS
    )
    # Where there is no root, the equilibrium ends.
    return np.where(np.isfinite(root.x), root.x, 0.5 * (brackets.low + brackets.high))


def _is_there_beyond(
    evaluate: Evaluate, brackets: Brackets, roots: Array, bounds: tuple[float, float]
) -> Any:
    """Whether an equilibrium exists on both sides of each root; if not, stability does not change there."""
    if not brackets.line.size:
        return np.zeros(0, dtype=bool)
    step = END_RTOL * np.maximum(np.abs(roots), bounds[1] - bounds[0])
    sides = (evaluate(brackets.line, np.clip(roots + sign * step, *bounds)) for sign in (-1, 1))
    return np.logical_and(*(np.isfinite(growth_rates(side)[:, 0]) for side in sides))


def _only_touches(evaluate: Evaluate, brackets: Brackets, roots: Array) -> Any:
    """Which changes are no changes: a regain and a loss, and the mode grows in between.

    A growth rate may come down to zero and rise again, as (p - a)^2 does.  Within some 1e-5 on either side of
    a it is too small to be told from zero, but it does not become negative.  So stability does not change.

    A slow mode is judged by its own size, but for where its eigenvalue comes out as zero.  Such a zero is one
    of rounding if just outside, too, the growth would count as zero beside the fastest mode.
    """
    touches = np.zeros(len(roots), dtype=bool)
    if len(roots) < 2:
        return touches
    still, growing = _bracket_sides(evaluate, brackets)
    regain = still > 0.5 * (brackets.low + brackets.high)
    pairs = (brackets.line[1:] == brackets.line[:-1]) & (brackets.rank[1:] == brackets.rank[:-1])
    first = np.flatnonzero(pairs & regain[:-1] & ~regain[1:])
    line, rank, start, width = brackets.line[first], brackets.rank[first], roots[first], np.diff(roots)[first]
    ends = growing[first], growing[first + 1]
    outside = [
        eigenvalue_at_rank(evaluate(line, np.clip(start + share * width, *ends)), rank).real
        for share in OUTSIDE_TOUCH_SHARES
    ]
    grows = np.ones(len(first), dtype=bool)
    for share in TOUCH_SHARES:
        spectra = evaluate(line, start + share * width)
        rate, scale = eigenvalue_at_rank(spectra, rank).real, eigenvalue_at_rank(growth_scales(spectra), rank)
        rounding = (rate >= -DECAY_RTOL * scale) & (np.maximum(*outside) < NEUTRAL_RTOL * scale)
        grows &= rounding | (rate > TOUCH_RTOL * scale)
    touches[first[grows]] = touches[first[grows] + 1] = True
    return touches


def _bracket_sides(evaluate: Evaluate, brackets: Brackets) -> tuple[Array, Array]:
    """The ends of the brackets where the mode does not grow, and those where it does."""
    before, after = (
        eigenvalue_at_rank(evaluate(brackets.line, end), brackets.rank).real
        for end in (brackets.low, brackets.high)
    )
    rises = after > before
    return np.where(rises, brackets.low, brackets.high), np.where(rises, brackets.high, brackets.low)


def _starts(evaluate: Evaluate, brackets: Brackets, still: Array, outside: Array) -> tuple[Array, Array]:
    """One end of the search for each root, and the growth rate that is solved for.

    In general the mode decays at this end, and the growth rate that is solved for is zero.  The end may lie
    outside the bracket, since the growth rate is as good as zero near a root.  Without damping no mode
    decays.  Then the end is `still`, and the growth rate is the least that counts as growth.
    """
    start, shift = still.copy(), np.full(still.shape, np.nan)
    for at in outside:
        spectra = evaluate(brackets.line, at)
        scale = eigenvalue_at_rank(growth_scales(spectra), brackets.rank)
        decays = np.isnan(shift) & (eigenvalue_at_rank(spectra, brackets.rank).real < -DECAY_RTOL * scale)
        start[decays], shift[decays] = at[decays], 0.0
    return start, np.where(np.isnan(shift), NEUTRAL_RTOL * scale, shift)


def eigenvalue_at_rank(spectra: Any, rank: Indices) -> Any:
    """The eigenvalue with the `rank`-th largest growth rate of each row."""
    return np.take_along_axis(spectra, rank[:, None], axis=1)[:, 0]


def _describe_changes(
    evaluate: Evaluate, brackets: Brackets, roots: Array, bounds: tuple[float, float]
) -> list[StabilityChange]:
    if not brackets.line.size:
        return []
    _, growing = _bracket_sides(evaluate, brackets)
    step = growing - roots
    # A bracket may be as narrow as rounding.
    least = np.minimum(MIN_INSIDE_RTOL * np.abs(roots), np.abs(step))
    inside = evaluate(
        brackets.line, roots + np.copysign(np.maximum(INSIDE_SHARE * np.abs(step), least), step)
    )
    before, at, after = (evaluate(brackets.line, p) for p in (brackets.low, roots, brackets.high))
    # Just inside: at the root itself all growth rates may be zero, or a real eigenvalue part of a pair.
    critical = eigenvalue_at_rank(inside, brackets.rank)
    far = np.concatenate(
        [at, *(evaluate(brackets.line, np.full(len(roots), bound)) for bound in bounds)], axis=1
    )
    size = np.nanmax(np.abs(far), axis=1)
    jumps = _is_fold(eigenvalue_at_rank(at, brackets.rank), size, FOLD_RATE_AT_ROOT) | _is_fold(
        critical, size, FOLD_RATE_INSIDE
    )
    lost = (growth_rates(before) > 0).sum(axis=1) < (growth_rates(after) > 0).sum(axis=1)
    rows = zip(roots, critical, jumps, lost, unstable_pairs(before), unstable_pairs(after))
    return [
        _change(float(root), value, bool(jump), bool(loss), a, b) for root, value, jump, loss, a, b in rows
    ]


def _is_fold(critical: Any, size: Array, max_growth: float) -> Any:
    """Whether a growth rate is not small at a root: it jumps there, because the equilibrium ends."""
    return ~(np.abs(critical.real) <= max_growth * size)


def _change(
    root: float, critical: complex, jump: bool, loss: bool, before: Any, after: Any
) -> StabilityChange:
    smooth = StabilityKind.FLUTTER if critical.imag else StabilityKind.DIVERGENCE
    kind = StabilityKind.FOLD if jump else smooth
    frequency = 0.0 if jump else abs(critical.imag) / (2 * np.pi)
    direction = "loss" if loss else "regain"
    return StabilityChange(root, float(frequency), kind, direction, (int(before), int(after)))
