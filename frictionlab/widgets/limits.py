"""Limits of an axis that stay while a slider moves: only where they change the axes are drawn anew."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

Limits = tuple[float, float]
FILLED = 0.35  # share of the axis that the data have to fill, else it shrinks
MARGIN = 0.06
LEAST = 1e-3  # of the largest value: what varies less is drawn as the constant it is
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
TICKS = 5
DECADES = 5.0


def extent(arrays: Iterable[Any]) -> Limits | None:
    """Smallest and largest finite number; None where there is none."""
    finite = [a[np.isfinite(a)] for a in (np.asarray(a, dtype=float).ravel() for a in arrays)]
    kept = [a for a in finite if a.size]
    return (float(min(a.min() for a in kept)), float(max(a.max() for a in kept))) if kept else None


def linear(now: Limits | None, found: Limits | None) -> Limits:
    """The limits there are, if the data are inside and fill them well enough; else round ones."""
    if found is None:
        return now or (0.0, 1.0)
    low, high = _widened(*found)
    if now and now[0] <= found[0] and found[1] <= now[1] and high - low >= FILLED * (now[1] - now[0]):
        return now
    margin = MARGIN * (high - low)
    step = _round_step((high - low + 2 * margin) / TICKS)
    return math.floor((low - margin) / step) * step, math.ceil((high + margin) / step) * step


def logarithmic(now: Limits | None, found: Limits | None) -> Limits:
    """Limits of a logarithmic axis: five decades below the largest value, in whole decades."""
    if found is None or found[1] <= 0:
        return now or (10.0**-DECADES, 1.0)
    top = math.log10(found[1])
    if now and math.log10(now[1]) - 1.5 < top < math.log10(now[1]):
        return now
    high = math.floor(top) + 1.0
    return 10.0 ** (high - DECADES), 10.0**high


def _widened(low: float, high: float) -> Limits:
    least = max(LEAST * max(abs(low), abs(high)), 1e-12)
    missing = max(0.0, least - (high - low)) / 2
    return low - missing, high + missing


def _round_step(step: float) -> float:
    power = 10.0 ** math.floor(math.log10(step))
    return next(s for s in STEPS if s * power >= step * (1 - 1e-9)) * power
