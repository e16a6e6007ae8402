"""Recurrence of the whole state at a section: the shortest period after which a motion repeats.

Also trends of a motion that does not repeat: crossings that drift one way, an amplitude that doubles or
halves.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.analysis.motion_scales import Array, state_ranges

MIN_PERIODS_SEEN = 3  # periods that the window has to contain at least
MAX_LAG = 500  # most crossings in a period
NEAR_RECURRENCE_RTOL = 1e-3
MIN_SETTLING_FACTOR = (
    # factor from each third of the window to the next by which the deviation shrinks where the motion still
    # settles
    1.5
)
TREND_PARTS = 8  # eight random numbers are in ascending or descending order twice in 40320 times
MIN_CROSSINGS = (
    TREND_PARTS * MIN_PERIODS_SEEN
)  # crossings below which a motion that does not repeat may still do so, or drift


class Recurrence(NamedTuple):
    """How nearly a motion returns to where it was `lag` crossings of a section before.

    Parameters
    ----------
    lag : int
        Crossings in a period; 0 where there are too few to tell.
    period : float
        Mean duration of so many crossings in s, over the second half of them; NaN where `lag` is 0.
    deviation : float
        Largest difference of the state to that one period before, as a share of the motion's size, or of the
        time between the two to the last such time, as a share of the longest such time; over the second half
        of the crossings.
    shrinking : float
        Least factor by which the deviation shrinks from each third of the crossings to the next: large where
        the motion still settles.
    """

    lag: int
    period: float
    deviation: float
    shrinking: float


NO_RECURRENCE = Recurrence(0, np.nan, np.inf, 1.0)


def find_recurrence(t: Array, states: Array, size: Array, tolerance: float) -> Recurrence:
    """The shortest lag at which the motion repeats within a tolerance, or nearly and ever more closely; else
    the closest lag.

    Parameters
    ----------
    t, states : array (K,), (K, m)
        Crossings of a section.
    size : array (m,)
        Size of the motion in each state; differences are measured by it.
    tolerance : float
    """
    scaled = states / np.where(size > 0, size, 1.0)
    lags = range(1, min(len(t) // MIN_PERIODS_SEEN, MAX_LAG) + 1)
    found = [_recurrence_at_lag(t, scaled, lag) for lag in lags]
    repeating = next((r for r in found if is_periodic(r, tolerance)), None)
    if repeating is None:
        return min(found, key=lambda r: r.deviation, default=NO_RECURRENCE)
    # Where the motion spirals inwards a long lag repeats first, but the deviation at a shorter one decays
    # too.
    return next((r for r in found[: repeating.lag] if r.shrinking > MIN_SETTLING_FACTOR), repeating)


def is_periodic(found: Recurrence, tolerance: float) -> bool:
    """Whether a motion is periodic, or close to a periodic one and approaching it."""
    return found.deviation < tolerance or (
        found.deviation < NEAR_RECURRENCE_RTOL and found.shrinking > MIN_SETTLING_FACTOR
    )


def _recurrence_at_lag(t: Array, states: Array, lag: int) -> Recurrence:
    differences = np.maximum(
        np.abs(states[lag:] - states[:-lag]).max(axis=1), _time_deviations(t[lag:] - t[:-lag])
    )
    half = len(differences) // 2
    count = (len(t) - 1 - half) // lag
    period = float(t[-1] - t[-1 - count * lag]) / count
    return Recurrence(lag, period, float(differences[half:].max()), _settling_factor(differences))


def _time_deviations(times: Array) -> Array:
    """Differences of the times between returns from the last of them, as shares of the longest.

    Where a section is only touched, some returns are missed or counted twice: the state is the same at each
    crossing, but the times between differ.
    """
    longest = times.max()
    return np.abs(times - times[-1]) / longest if longest > 0.0 else np.ones(len(times))


def _settling_factor(differences: Array) -> float:
    first, second, third = (part.max(initial=0.0) for part in np.array_split(differences, 3))
    if second == 0.0 or third == 0.0:
        return np.inf
    return float(min(first / second, second / third))


def crossings_drift(states: Array, size: Array) -> bool:
    """Whether a motion that does not repeat still drifts: its crossings of a section move, or spread, in one
    direction throughout.

    Parameters
    ----------
    states : array (K, m)
        Crossings of a section.
    size : array (m,)
        Size of the motion in each state.
    """
    if len(states) < MIN_CROSSINGS:
        return False
    parts = np.array_split(states / np.where(size > 0, size, 1.0), TREND_PARTS)
    course = [[*part.mean(axis=0), part.std(axis=0).sum()] for part in parts]
    steps: Array = np.asarray(np.diff(np.array(course, dtype=float), axis=0), dtype=float)
    return bool(((steps > 0).all(axis=0) | (steps < 0).all(axis=0)).any())


def amplitude_changes(states: Array) -> bool:
    """Whether a motion's size in most states doubles, or halves, between its first and its last quarter."""
    parts = np.array_split(states, 4)
    if not len(parts[-1]):
        return False
    first, last = state_ranges(parts[0]), state_ranges(parts[-1])
    moving = np.minimum(first, last) > 0
    return bool(moving.any() and abs(np.log2(np.median(last[moving] / first[moving]))) > 1)
