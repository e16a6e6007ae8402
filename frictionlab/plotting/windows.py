"""Which part of a run a panel shows, and dense samples of it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.timescale import period_of
from frictionlab.hybrid.trajectory import Trajectory

Array = NDArray[np.float64]


class Periods(NamedTuple):
    """A window at the end of a run that is so many periods of the model long."""

    count: float


Window = float | tuple[float, float] | Periods | None

LAST = Periods(7.5)  # 0.75 s of the slider on a belt
POINTS = 4001


def end_of(run: Any) -> float:
    """The time that the run reached."""
    return float(run.raw.t)


def refuse_no_run(run: Any) -> None:
    """Raise TypeError unless it is a run."""
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a Trajectory, got {run!r}: give what frictionlab.simulate returns")


def refuse_no_coordinates(run: Any) -> None:
    """Raise TypeError unless it is a run, ValueError unless its automaton has coordinates."""
    refuse_no_run(run)
    if not run.automaton.coordinates:
        raise ValueError("run must be of an automaton with coordinates, got none: plot run.t and run.states")


def limits(run: Any, window: Window = LAST) -> tuple[float, float]:
    """Start and end of a window: the last seconds or periods, the two times given, or (None) the whole run.

    Raises
    ------
    ValueError
        If the window is empty or lies outside the run.
    TypeError
        For what is no run.
    """
    refuse_no_run(run)
    end = end_of(run)
    if window is None:
        return 0.0, end
    if isinstance(window, Periods):
        window = window.count * period_of(run.source)
    if isinstance(window, (int, float)):
        start, stop = max(0.0, end - window), end
    else:
        start, stop = window
    if not 0.0 <= start <= stop <= end or (start == stop and end > 0):
        raise ValueError(f"window must lie within the run, 0 to {end:g} s, got {window!r}: change its times")
    return float(start), float(stop)


def dense_times(start: float, stop: float, points: int = POINTS) -> Array:
    """Evenly spaced times that never leave the window by rounding."""
    return np.clip(np.linspace(start, stop, points), start, stop)


def window_text(run: Any, start: float, stop: float) -> str:
    """The window in words, for a title."""
    end = end_of(run)
    if (start, stop) == (0.0, end):
        return f"whole run, {end:.4g} s"
    if stop == end:
        return f"last {stop - start:.4g} s of {end:.4g} s"
    return f"{start:.4g} s to {stop:.4g} s of {end:.4g} s"
