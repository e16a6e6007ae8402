"""What the reference says about a case, and how far: runs nearby show where it ceases to be predictable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.differential.case import Case
from tests.differential.twin import initial, twin
from tests.reference.hybrid import Happening, Motion, Undecided, integrate

SAMPLES = 33
NEAR = 1e-9  # share by which runs nearby differ in every number: the accuracy asked for at the default
SLACK = 10.0  # the same in tolerances: of a looser one, a series that ends at tol leaves so much in a run
FAR = 0.05  # runs nearby that are so far apart, in sizes or periods, foretell nothing more
FAINT = (
    1e-4  # impacts below this, by the fastest, are left out: where they pile up, their number means nothing
)
UNBOUNDED = 1e6


@dataclass(frozen=True, eq=False)
class Prediction:
    """Events and states up to a horizon, with the amounts by which runs nearby differ from them."""

    events: list[Happening]
    time_spread: np.ndarray
    t: np.ndarray
    states: np.ndarray
    state_spread: np.ndarray
    horizon: float


def near(tol: float) -> float:
    """By how much a run nearby differs."""
    return max(NEAR, SLACK * tol)


def predict(case: Case) -> Prediction:
    """The reference's motion and its spread.

    Raises
    ------
    Undecided
        Where the reference cannot tell.
    """
    times = np.linspace(0.0, case.t_end, SAMPLES)
    exact, shift = _motion(case, times, 0.0), near(case.tol)
    others = [_motion(case, times, sign * shift) for sign in (1, -1)]
    events, period = distinct(exact.events), twin(case.model).period
    spread, horizon = _times(events, [distinct(other.events) for other in others], case.t_end, period)
    time_spread = np.maximum.accumulate(spread) + shift * period if len(spread) else spread
    states = np.array(exact.states)
    size = sizes(states)
    apart = np.max([np.abs(np.array(other.states) - states) for other in others], axis=0)
    apart[~clear(times, events, time_spread, case.t_end)] = 0.0
    state_spread = np.maximum.accumulate(_grouped(apart), axis=0) + shift * size
    lost = (state_spread > FAR * size).any(axis=1)
    horizon = min(horizon, times[lost].min(initial=case.t_end))
    return Prediction(events, time_spread, times, states, state_spread, float(horizon))


def _motion(case: Case, times: np.ndarray, shift: float) -> Motion:
    rtol = max(1e-13, 1e-3 * abs(shift))
    found = integrate(twin(case.model, shift), initial(case.model, case.x0, shift), times, rtol)
    if not np.abs(found.states).max() < UNBOUNDED:
        raise Undecided("the motion is unbounded")
    return found


def distinct(events: list[Happening]) -> list[Happening]:
    """Events without the faint impacts that another one follows."""
    fastest = max((e.speed for e in events if np.isfinite(e.speed)), default=0.0)
    return [e for e in events if e.source != e.target or e.speed > FAINT * fastest]


def _times(events: list[Happening], others: Any, t_end: float, period: float) -> tuple[np.ndarray, float]:
    """Spread of the times of the events, and when runs nearby take another course."""
    spread, horizon = np.zeros(len(events)), t_end
    for other in others:
        for i in range(max(len(events), len(other))):
            pair = [e[i] for e in (events, other) if i < len(e)]
            if len(pair) == 2 and pair[0][1:3] == pair[1][1:3]:
                spread[i] = max(spread[i], abs(pair[0].t - pair[1].t))
                if spread[i] <= FAR * period:
                    continue
            horizon = min(horizon, *(e.t for e in pair))
            break
    return spread, horizon


def sizes(states: np.ndarray) -> np.ndarray:
    """Largest coordinate and velocity of a run, each for its group."""
    return _grouped(np.abs(states)).max(axis=0)


def _grouped(amounts: np.ndarray) -> np.ndarray:
    half = amounts.shape[1] // 2
    return np.repeat(
        np.stack([amounts[:, :half].max(axis=1), amounts[:, half:].max(axis=1)], axis=1), half, axis=1
    )


def clear(times: np.ndarray, events: list[Happening], spread: np.ndarray, t_end: float) -> np.ndarray:
    """Which times no event comes so near to that it may be on either side."""
    clear = np.ones(len(times), dtype=bool)
    for event, width in zip(events, spread, strict=True):
        clear &= np.abs(times - event.t) > 10 * width
    return clear
