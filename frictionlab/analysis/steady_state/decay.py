"""Slow decay, told by the linear map from sample to sample (dynamic mode decomposition).

Near an equilibrium, or a periodic motion, that map is linear in what is left of the transient.  The part
along each of its eigenvectors shrinks in every step, while coordinates beat.  Source: P. J. Schmid, "Dynamic
mode decomposition of numerical and experimental data", J. Fluid Mechanics 656 (2010) 5-28.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import Array

from .recurrence import TREND_PARTS

# share of the largest singular value below which a direction in the samples is rounding
SAMPLE_RANK_RTOL = 1e-10
MIN_LOSS_SHARE = 1e-9  # share of its square that a decaying part has to lose
MIN_RATE_RATIO = (
    0.5  # least rate of decay, as a share of the largest, where events between samples disturb the linear map
)
# the same where nothing is left in the end: a motion approaches a cycle ever more slowly
SINGLE_RATE_RATIO = 0.99
SIGNIFICANT_SHARE = 1e-6  # share of the motion's square above which a part of it has to decay as well


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
