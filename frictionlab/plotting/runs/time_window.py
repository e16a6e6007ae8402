"""The part of a run that a panel shows: window, samples, modes, and modes as shading.

A window is the last so many seconds, two times, so many periods of the model at the end, or (None) the
whole run.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import oscillation_period
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.plotting.appearance import is_dark, legible
from frictionlab.plotting.style import mode_colours
from frictionlab.validation import plain_number

Array = NDArray[np.float64]


class Periods(NamedTuple):
    """A window at the end of a run that is so many periods of the model long."""

    count: float


Window = float | tuple[float, float] | Periods | None

DEFAULT_WINDOW = Periods(7.5)  # 0.75 s of the slider on a belt
SAMPLES = 4001
SHADE, DARK_SHADE = 0.35, 0.2  # opacity of the modes behind lines, on light and on dark backgrounds
SAMPLING_RTOL = 1e-12  # share by which rounding may keep a window from holding one more whole step


def end_time(run: Any) -> float:
    """The time that the run reached."""
    return float(run.raw.t)


def check_run(run: Any) -> None:
    """Raise TypeError unless it is a run."""
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a Trajectory, got {run!r}: give what frictionlab.simulate returns")


def check_run_with_coordinates(run: Any) -> None:
    """Raise TypeError unless it is a run, ValueError unless its automaton has coordinates."""
    check_run(run)
    if not run.automaton.coordinates:
        raise ValueError("run must be of an automaton with coordinates, got none: plot run.t and run.states")


def window_limits(run: Any, window: Window = DEFAULT_WINDOW) -> tuple[float, float]:
    """Start and end of a window: the last seconds or periods, the two times given, or (None) the whole run.

    Raises
    ------
    ValueError
        If the window is empty or lies outside the run.
    TypeError
        For what is no run.
    """
    check_run(run)
    end = end_time(run)
    window = plain_number(window)
    if window is None:
        return 0.0, end
    if isinstance(window, Periods):
        window = window.count * oscillation_period(run.source)
    if isinstance(window, (int, float)):
        start, stop = max(0.0, end - window), end
    else:
        start, stop = window
    if not 0.0 <= start <= stop <= end or (start == stop and end > 0):
        raise ValueError(f"window must lie within the run, 0 to {end:g} s, got {window!r}: change its times")
    return float(start), float(stop)


def sample_times(start: float, stop: float, points: int = SAMPLES) -> Array:
    """Evenly spaced times that never leave the window by rounding."""
    return np.clip(np.linspace(start, stop, points), start, stop)


def window_text(run: Any, start: float, stop: float) -> str:
    """The window in words, for a title."""
    end = end_time(run)
    if (start, stop) == (0.0, end):
        return f"whole run, {end:.4g} s"
    if stop == end:
        return f"last {stop - start:.4g} s of {end:.4g} s"
    return f"{start:.4g} s to {stop:.4g} s of {end:.4g} s"


def mode_intervals(run: Any) -> tuple[Array, list[str]]:
    """Edges (n + 1,) of the intervals of a run spent in one mode, and their names.

    Events that lead back into the same mode, such as the re-contacts of chatter, divide nothing.
    """
    events, end = run.events, end_time(run)
    if len(events) == 0:
        names = [name for name, seconds in run.time_in_mode.items() if seconds > 0]
        return (np.array([0.0, end]), names) if names else (np.array([0.0]), [])
    modes = np.append(events.source[:1], events.target)
    starts = np.append(0.0, events.t)
    # Of several events at one instant only the mode entered last has a duration.
    lasting = np.append(starts[1:] > starts[:-1], end > starts[-1])
    modes, starts = modes[lasting], starts[lasting]
    new = np.append([True], modes[1:] != modes[:-1])[: len(modes)]
    return np.append(starts[new], end), modes[new].tolist()


def modes_at(run: Any, t: Array) -> np.ndarray:
    """Name of the mode at each time."""
    edges, names = mode_intervals(run)
    if not names:
        return np.full(len(t), "")
    return np.array(names)[np.clip(np.searchsorted(edges, t, side="right") - 1, 0, len(names) - 1)]


def shade_modes(run: Any, ax: Axes, window: Window = DEFAULT_WINDOW) -> list[PolyCollection]:
    """Shade the intervals of every mode over the whole height of a panel over time.

    Parameters
    ----------
    run : Trajectory
    ax : Axes
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run.

    Returns
    -------
    list of PolyCollection
        One for every mode that occurs, labelled with its name.
    """
    start, stop = window_limits(run, window)
    edges, names = mode_intervals(run)
    colours = mode_colours(run)
    shades = []
    for mode, colour in colours.items():
        spans = _intervals_in_window(edges, [name == mode for name in names], start, stop)
        if spans:
            options: dict[str, Any] = {"facecolors": legible(colour, ax), "linewidth": 0, "zorder": 0}
            options["alpha"] = DARK_SHADE if is_dark(ax) else SHADE
            across = ax.get_xaxis_transform()
            shades.append(ax.broken_barh(spans, (0, 1), transform=across, label=mode, **options))
    return shades


def _intervals_in_window(
    edges: Array, chosen: list[bool], start: float, stop: float
) -> list[tuple[float, float]]:
    """(start, length) of the chosen intervals, cut to the window."""
    left, right = np.maximum(edges[:-1], start), np.minimum(edges[1:], stop)
    inside = np.array(chosen, dtype=bool) & (right > left)
    return list(zip(left[inside].tolist(), (right - left)[inside].tolist(), strict=True))


def label_time_axes(
    run: Any, ax: Axes, span: tuple[float, float], shade: bool, what: str, ylabel: str
) -> None:
    """Shade the modes, if wanted, and name the axes and what is drawn in which part of the run."""
    if shade:
        shade_modes(run, ax, span)
    ax.set(xlabel="time (s)", ylabel=ylabel, title=f"{what}, {window_text(run, *span)}")
    ax.margins(x=0)
