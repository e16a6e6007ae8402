"""Recurrence of the whole state at a section: the shortest period after which a motion repeats.

Also trends of a motion that does not repeat: crossings that drift one way, an amplitude that doubles or
halves, and slow decay, told by the linear map from sample to sample (dynamic mode decomposition).  Near an
equilibrium, or a periodic motion, that map is linear in what is left of the transient.  The part along each
of its eigenvectors shrinks in every step, while coordinates beat.  Source: P. J. Schmid, "Dynamic mode
decomposition of numerical and experimental data", J. Fluid Mechanics 656 (2010) 5-28.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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

# share of the largest singular value below which a direction in the samples is rounding
SAMPLE_RANK_RTOL = 1e-10
MIN_LOSS_SHARE = 1e-9  # share of its square that a decaying part has to lose
MIN_RATE_RATIO = (
    0.5  # least rate of decay, as a share of the largest, where events between samples disturb the linear map
)
# the same where nothing is left in the end: a motion approaches a cycle ever more slowly
SINGLE_RATE_RATIO = 0.99
SIGNIFICANT_SHARE = 1e-6  # share of the motion's square above which a part of it has to decay as well


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


class EigenvectorSquares(NamedTuple):
    """Mean squares (TREND_PARTS, k) of the motion along k eigenvectors, and which of these shrink under the
    map."""

    squares: Array
    inside: NDArray[np.bool_]

    @property
    def whole(self) -> float:
        """The largest square of all parts together."""
        return float(self.squares.sum(axis=1).max())


def part_decays(samples: Array, size: Array, *, evenly: bool = False) -> bool:
    """Whether some part of a motion decays, or grows, throughout.

    Parameters
    ----------
    samples : array (N, m)
        States at even times, or at the crossings of a section.
    size : array (m,)
        Size of the motion in each state.
    evenly : bool
        Whether it has to do so at about a constant rate: beats of a motion with events may look like decay
        for a while.
    """
    found = _eigenvector_squares(samples, size)
    if found is None:
        return False
    least, share = MIN_LOSS_SHARE * found.whole, MIN_RATE_RATIO * evenly
    shrinking, growing = (found.squares[:, chosen].sum(axis=1) for chosen in (found.inside, ~found.inside))
    return _decreases(shrinking, least, share) or _decreases(growing[::-1], least, share)


def all_parts_decay(samples: Array, size: Array) -> bool:
    """Whether all parts of a motion decay, each at a rate of its own."""
    found = _eigenvector_squares(samples, size)
    if found is None:
        return False
    notable = found.squares.T[found.squares.max(axis=0) > SIGNIFICANT_SHARE * found.whole]
    return all(_decreases(course, MIN_LOSS_SHARE * found.whole, SINGLE_RATE_RATIO) for course in notable)


def _decreases(course: Array, least: float, share: float) -> bool:
    if not (np.diff(course) < 0.0).all() or course[0] - course[-1] <= least:
        return False
    rates = -np.diff(np.log(course))
    return bool(rates.min() > share * rates.max())


def _eigenvector_squares(samples: Array, size: Array) -> EigenvectorSquares | None:
    """None where there are too few samples to tell."""
    steps = np.diff(samples / np.where(size > 0, size, 1.0), axis=0)
    if len(steps) < TREND_PARTS:
        return None
    shares, spread, _ = np.linalg.svd(steps, full_matrices=False)
    kept = spread > SAMPLE_RANK_RTOL * spread[0]
    shares, spread = shares[:, kept], spread[kept]
    if not len(spread) or len(steps) <= 2 * len(spread):
        return None
    first, later = shares[:-1], shares[1:]
    step = np.linalg.solve(first.T @ first, first.T @ later)  # the columns are nearly orthonormal
    factors, modes = np.linalg.eig(step)
    lengths = (np.abs(np.linalg.pinv(modes) * spread) ** 2).sum(axis=1)
    parts = np.array_split(np.abs(shares @ modes) ** 2 * lengths, TREND_PARTS)
    return EigenvectorSquares(np.array([part.mean(axis=0) for part in parts]), np.abs(factors) < 1.0)
