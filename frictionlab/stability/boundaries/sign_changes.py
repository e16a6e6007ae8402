"""Where growth rates change sign along lines of a parameter: brackets, found by halving intervals.

The growth rates are sorted, the largest first: the k-th is a continuous function of the parameter, and its
sign changes exactly where the number of growing eigenvalues passes k.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.state_matrices import (
    Array,
    ComplexArray,
    eigenvalue_distances,
    equal_eigenvalues,
    growth_rates,
    growth_scales,
)

Flags = NDArray[np.bool_]
Evaluate = Callable[[NDArray[np.intp], Array], ComplexArray]
GRID_POINTS, MAX_HALVINGS = 129, 24
COARSE_POINTS, COARSE_HALVINGS = 5, 18  # for lines on which few changes are expected
# Most intervals, over those of the first grid: two modes may share one eigenvalue everywhere.
MAX_INTERVAL_FACTOR = 8
NO_CHANGE_RTOL = 1e-9  # share of the largest eigenvalue: one that moves by less counts as unmoved


class Intervals(NamedTuple):
    """Intervals of lines."""

    line: NDArray[np.intp]  # index of the line
    low: Array  # its ends
    high: Array
    at_low: ComplexArray  # the spectra there, the largest growth rate first
    at_high: ComplexArray

    # items of a tuple are its fields; here they are the intervals, as in an array
    def __getitem__(self, index: Any) -> Intervals:  # type: ignore[override]
        parts: Any = tuple(self)  # as a plain tuple, since indexing this class would call this method again
        return Intervals(*(part[index] for part in parts))


class Brackets(NamedTuple):
    """Intervals in which one growth rate changes its sign."""

    line: NDArray[np.intp]  # index of the line
    low: Array  # its ends
    high: Array
    rank: NDArray[np.intp]  # the growth rate's index among the sorted


def bracket_sign_changes(evaluate: Evaluate, low: Array, high: Array) -> Brackets:
    """All changes of sign on lines from `low` to `high` (L,), by line and ascending parameter.

    `evaluate` takes indices of lines and values of the parameter and gives sorted spectra; NaN where there
    is no equilibrium.
    """
    pieces = _grid(evaluate, low, high, GRID_POINTS)
    most = MAX_INTERVAL_FACTOR * len(pieces.line)
    brackets, pieces = _refined(evaluate, pieces, MAX_HALVINGS, most)
    clusters = pieces if len(pieces.line) > most else _join_neighbours(pieces)
    brackets.append(_brackets_of(clusters[_sign_changes(clusters.at_low, clusters.at_high).any(axis=1)]))
    return _sort_brackets(brackets)


def resolved_sign_changes(evaluate: Evaluate, low: Array, high: Array) -> tuple[Brackets, Flags]:
    """As :func:`bracket_sign_changes` with fewer spectra, and on which lines (L,) these are all changes.

    The first intervals are long.  If growth rates come near zero in one, or two eigenvalues near each other,
    it may hide a change.  It is halved, up to a limit.  A line on which such an interval is left is not
    resolved.
    """
    pieces = _grid(evaluate, low, high, COARSE_POINTS)
    brackets, left = _refined(evaluate, pieces, COARSE_HALVINGS, MAX_INTERVAL_FACTOR * len(pieces.line))
    resolved = np.ones(len(low), dtype=bool)
    resolved[left.line] = False
    return _sort_brackets(brackets), resolved


def _refined(
    evaluate: Evaluate, pieces: Intervals, halvings: int, most: int
) -> tuple[list[Brackets], Intervals]:
    """Halve intervals until each has no change or a single one; the changes, and the intervals left over."""
    brackets: list[Brackets] = []
    for _ in range(halvings):
        middle = 0.5 * (pieces.low + pieces.high)
        at_middle = evaluate(pieces.line, middle)
        clear, single = _classify_intervals(pieces, at_middle)
        brackets.append(_brackets_of(pieces[single & ~clear]))
        pieces = _halve(pieces, middle, at_middle, ~clear & ~single)
        if not pieces.line.size or len(pieces.line) > most:
            break
    return brackets, pieces


def _grid(evaluate: Evaluate, low: Array, high: Array, count: int) -> Intervals:
    share = np.linspace(0.0, 1.0, count)
    points = low[:, None] + (high - low)[:, None] * share
    line = np.repeat(np.arange(len(low)), count)
    spectra = evaluate(line, points.ravel()).reshape(len(low), count, -1)
    m = spectra.shape[-1]
    return Intervals(
        np.repeat(np.arange(len(low)), count - 1),
        points[:, :-1].ravel(),
        points[:, 1:].ravel(),
        spectra[:, :-1].reshape(-1, m),
        spectra[:, 1:].reshape(-1, m),
    )


def _classify_intervals(pieces: Intervals, at_middle: ComplexArray) -> tuple[Flags, Flags]:
    """Whether no growth rate changes sign in an interval; whether exactly one does, or that of one pair."""
    a, b, c = growth_rates(pieces.at_low), growth_rates(at_middle), growth_rates(pieces.at_high)
    unknown = np.isnan(a[:, 0]) | np.isnan(b[:, 0]) | np.isnan(c[:, 0])
    absent = np.isnan(a[:, 0]) & np.isnan(b[:, 0]) & np.isnan(c[:, 0])
    same_sign = (np.sign(a) == np.sign(b)) & (np.sign(b) == np.sign(c))
    # A parabola through the three values dips below the least of them by at most an eighth of this.
    bend = np.abs(a - 2 * b + c)
    least = np.minimum(np.minimum(np.abs(a), np.abs(b)), np.abs(c))
    room = same_sign & (least > bend)
    passes = ~same_sign & (((a <= b) & (b <= c)) | ((a >= b) & (b >= c)))
    distinct = ~_may_coalesce(pieces, at_middle, least)
    one = _one_mode(passes, pieces.at_low, pieces.at_high)
    return absent | (~unknown & distinct & room.all(axis=1)), ~unknown & distinct & one & (room | passes).all(
        axis=1
    )


def _one_mode(passes: Flags, at_low: ComplexArray, at_high: ComplexArray) -> Flags:
    """Whether the growth rates that pass zero are those of one mode: a real one, or a conjugate pair."""
    count, first = passes.sum(axis=1), passes.argmax(axis=1)
    rows, second = np.arange(len(passes)), np.minimum(first + 1, passes.shape[1] - 1)
    pair = passes[rows, second]
    for spectrum in (at_low, at_high):
        pair = pair & (spectrum[rows, first] == np.conj(spectrum[rows, second]))
    return (count == 1) | ((count == 2) & pair)


def _may_coalesce(pieces: Intervals, at_middle: ComplexArray, least: Array) -> Flags:
    """Whether two eigenvalues may coalesce unseen while growth rates are near zero.

    The weaker two modes couple, the narrower is the window in which they are unstable.
    """
    ends = (pieces.at_low, pieces.at_high)
    distance = np.maximum(*(eigenvalue_distances(at_middle, end).min(axis=2) for end in ends))
    between = eigenvalue_distances(at_middle, at_middle)
    between[:, range(distance.shape[1]), range(distance.shape[1])] = np.inf
    # A pair that is about to become two real eigenvalues is close to its conjugate, which does not matter.
    between[at_middle.imag[:, :, None] * at_middle.imag[:, None, :] < 0] = np.inf
    # Nor do modes with equal eigenvalues throughout.
    between[equal_eigenvalues(at_middle) & _stay_equal(at_middle, *ends)[:, :, None]] = np.inf
    distance[distance < NO_CHANGE_RTOL * growth_scales(at_middle)] = 0.0
    close = between < 2 * (distance[:, :, None] + distance[:, None, :])
    within_reach = between + distance[:, :, None] > least.min(axis=1)[:, None, None]
    return (close & within_reach & np.isfinite(between)).any(axis=(1, 2))


def _stay_equal(at_middle: ComplexArray, *ends: ComplexArray) -> Flags:
    """Whether an eigenvalue (N, m) has an equal one at both ends as well."""
    near = (eigenvalue_distances(at_middle, end).argmin(axis=2) for end in ends)
    stay = [np.take_along_axis(equal_eigenvalues(end).any(axis=2), n, axis=1) for end, n in zip(ends, near)]
    return stay[0] & stay[1]


def _halve(pieces: Intervals, middle: Array, at_middle: ComplexArray, selection: Flags) -> Intervals:
    first = Intervals(pieces.line, pieces.low, middle, pieces.at_low, at_middle)[selection]
    second = Intervals(pieces.line, middle, pieces.high, at_middle, pieces.at_high)[selection]
    both: Any = zip(first, second)
    return Intervals(*(np.concatenate(parts) for parts in both))


def _join_neighbours(pieces: Intervals) -> Intervals:
    """Join neighbouring intervals: changes that are too close to be resolved count as simultaneous."""
    if not pieces.line.size:
        return pieces
    order = np.lexsort((pieces.low, pieces.line))
    pieces = pieces[order]
    new = np.append(True, (pieces.line[1:] != pieces.line[:-1]) | (pieces.low[1:] > pieces.high[:-1]))
    last = np.append(np.flatnonzero(new)[1:] - 1, len(new) - 1)
    return Intervals(
        pieces.line[new], pieces.low[new], pieces.high[last], pieces.at_low[new], pieces.at_high[last]
    )


def _sign_changes(at_low: ComplexArray, at_high: ComplexArray) -> Flags:
    """Which growth rates change sign; none do where the equilibrium itself begins or ends."""
    finite = np.isfinite(at_low) & np.isfinite(at_high)
    return finite & ((growth_rates(at_low) > 0) != (growth_rates(at_high) > 0))


def _brackets_of(pieces: Intervals) -> Brackets:
    rank = _sign_changes(pieces.at_low, pieces.at_high).argmax(axis=1)
    return Brackets(pieces.line, pieces.low, pieces.high, rank)


def _sort_brackets(brackets: list[Brackets]) -> Brackets:
    parts: Any = [np.concatenate(part) for part in zip(*brackets)]
    order = np.lexsort((parts[1], parts[0]))
    return Brackets(*(part[order] for part in parts))
