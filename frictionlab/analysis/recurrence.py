"""Does a motion repeat?  Recurrence of the whole state at a section."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SHORTEST = 3  # periods that have to be seen at least
NEARLY = 1e-3
SETTLING = 2.0  # a deviation that shrinks so much from the window's first half to its second still settles


class Recurrence(NamedTuple):
    """How nearly a motion returns to where it was `lag` crossings of a section before.

    Parameters
    ----------
    lag : int
        Crossings in a period; 0 where there are too few to tell.
    period : float
        Mean time of them in s; NaN where `lag` is 0.
    deviation : float
        Largest difference of the state to that one period before, over the second half of the crossings,
        as a share of the motion's size.
    shrinking : float
        The same over the first half of them, divided by it: large where the motion still settles.
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
    found = [_at_lag(t, scaled, lag) for lag in range(1, len(t) // SHORTEST + 1)]
    repeating = (r for r in found if repeats(r, tolerance))
    return next(repeating, min(found, key=lambda r: r.deviation, default=NEVER))


def repeats(found: Recurrence, tolerance: float) -> bool:
    """Whether a motion is periodic, or approaches a periodic one and is near."""
    return found.deviation < tolerance or (found.deviation < NEARLY and found.shrinking > SETTLING)


def _at_lag(t: Array, states: Array, lag: int) -> Recurrence:
    differences = np.abs(states[lag:] - states[:-lag]).max(axis=1)
    half, count = len(differences) // 2, (len(t) - 1) // lag
    early, late = float(differences[:half].max(initial=0.0)), float(differences[half:].max())
    period = float(t[-1] - t[-1 - count * lag]) / count
    return Recurrence(lag, period, late, early / late if late > 0 else np.inf)


def sizes(states: Any) -> Array:
    """Range of each state over a motion."""
    return np.ptp(np.asarray(states, dtype=float), axis=0)
