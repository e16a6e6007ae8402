"""How long an oscillation takes, about: by it pictures choose what they show."""

from __future__ import annotations

from math import floor, log10
from typing import Any

from frictionlab.models import Model

USUAL = 0.1  # s, of the slider on a belt


def period_of(source: Any) -> float:
    """That of a model, s; of an automaton that of the slider on a belt."""
    return source.period if isinstance(source, Model) else USUAL


def round_period_of(source: Any) -> float:
    """The same as 1, 2 or 5 times a power of ten, from below."""
    period = period_of(source) * (1 + 1e-9)
    power = 10.0 ** floor(log10(period))
    return next(round(s * power, 12) for s in (5.0, 2.0, 1.0) if s * power <= period)
