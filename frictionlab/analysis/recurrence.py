"""Does a motion repeat?  Recurrence of the whole state at a section."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SHORTEST = 3  # periods that have to be seen at least
LONGEST = 500  # crossings in a period that are looked for at most
NEARLY = 1e-3
SETTLING = 1.5  # a deviation that shrinks so much from each third of the window to the next still settles
PARTS = 8  # by chance, eight numbers are in ascending or descending order twice in 40320 times
FEWEST = PARTS * SHORTEST  # crossings below which a motion that does not repeat may do so yet, or go one way


class Recurrence(NamedTuple):
    """How nearly a motion returns to where it was `lag` crossings of a section before.

    Parameters
    ----------
    lag : int
        Crossings in a period; 0 where there are too few to tell.
    period : float
        Mean time of them in s, over the second half of the crossings; NaN where `lag` is 0.
    deviation : float
        Largest difference of the state to that one period before, as a share of the motion's size, or of
        the time between the two to the last such time, as a share of the longest; over the second half of
        the crossings.
    shrinking : float
        By which factor at least it shrinks from each third of them to the next: large where the motion
        still settles.
    """

    lag: int
    period: float
    deviation: float
    shrinking: float


NEVER = Recurrence(0, np.nan, np.inf, 1.0)


def recurrence(t: Array, states: Array, size: Array, tolerance: float) -> Recurrence:
    """The shortest period that repeats within a tolerance, or nearly and ever better; else the nearest lag.

    Parameters
    ----------
    t, states : array (K,), (K, m)
        Crossings of a section.
    size : array (m,)
        Size of the motion in each state; differences are measured by it.
    tolerance : float
    """
    scaled = states / np.where(size > 0, size, 1.0)
    lags = range(1, min(len(t) // SHORTEST, LONGEST) + 1)
    found = [_at_lag(t, scaled, lag) for lag in lags]
    repeating = next((r for r in found if repeats(r, tolerance)), None)
    if repeating is None:
        return min(found, key=lambda r: r.deviation, default=NEVER)
    # Where the motion spirals inwards a long lag repeats first, but what a shorter one misses dies away too.
    return next((r for r in found[: repeating.lag] if r.shrinking > SETTLING), repeating)


def repeats(found: Recurrence, tolerance: float) -> bool:
    """Whether a motion is periodic, or approaches a periodic one and is near."""
    return found.deviation < tolerance or (found.deviation < NEARLY and found.shrinking > SETTLING)


def _at_lag(t: Array, states: Array, lag: int) -> Recurrence:
    differences = np.maximum(np.abs(states[lag:] - states[:-lag]).max(axis=1), _late(t[lag:] - t[:-lag]))
    half = len(differences) // 2
    count = (len(t) - 1 - half) // lag
    period = float(t[-1] - t[-1 - count * lag]) / count
    return Recurrence(lag, period, float(differences[half:].max()), _shrinking(differences))


def _late(times: Array) -> Array:
    """How far times between returns are from the last of them, as shares of the longest.

    A section that is only touched misses some of the returns, and a state may come upon it twice at once: it
    is the same state at each crossing, though not after the same time.
    """
    longest = times.max()
    return np.abs(times - times[-1]) / longest if longest > 0.0 else np.ones(len(times))


def _shrinking(differences: Array) -> float:
    first, second, third = (part.max(initial=0.0) for part in np.array_split(differences, 3))
    if second == 0.0 or third == 0.0:
        return np.inf
    return float(min(first / second, second / third))


def drifts(states: Array, size: Array) -> bool:
    """Whether a motion that does not repeat is still on its way: its crossings of a section move, or spread,
    one way all along.

    Parameters
    ----------
    states : array (K, m)
        Crossings of a section.
    size : array (m,)
        Size of the motion in each state.
    """
    if len(states) < FEWEST:
        return False
    parts = np.array_split(states / np.where(size > 0, size, 1.0), PARTS)
    course = [[*part.mean(axis=0), part.std(axis=0).sum()] for part in parts]
    steps: Array = np.asarray(np.diff(np.array(course, dtype=float), axis=0), dtype=float)
    return bool(((steps > 0).all(axis=0) | (steps < 0).all(axis=0)).any())


def swells(states: Array) -> bool:
    """Whether a motion's size in most states doubles, or halves, between its first and its last quarter."""
    parts = np.array_split(states, 4)
    if not len(parts[-1]):
        return False
    first, last = sizes(parts[0]), sizes(parts[-1])
    moving = np.minimum(first, last) > 0
    return bool(moving.any() and abs(np.log2(np.median(last[moving] / first[moving]))) > 1)


def sizes(states: Any) -> Array:
    """Range of each state over a motion; zero where there is none."""
    states = np.asarray(states, dtype=float)
    return states.max(axis=0) - states.min(axis=0) if len(states) else np.zeros(states.shape[1])
