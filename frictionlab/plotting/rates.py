"""Rates of the coordinates against time."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .figure import axes_or_new
from .palette import is_angle, label, line_style, unit
from .time_panel import finish
from .windows import LAST, Window, dense_times, limits


def plot_rates(
    run: Any, ax: Axes | None = None, *, window: Window = LAST, shade: bool = True
) -> list[Line2D]:
    """Draw the rates of all coordinates against time, with the modes shaded behind them.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run; without it some eight periods.
    shade : bool
        Whether to shade the modes.

    Returns
    -------
    list of Line2D
        One line for every coordinate, in SI units.
    """
    ax = axes_or_new(ax)
    start, stop = limits(run, window)
    t, n = dense_times(start, stop), run.automaton.coordinates
    states, lines = run(t), []
    names = run.names[n : 2 * n]
    for i, name in enumerate(names):
        text = f"{label(name)} ({unit(name)})"
        lines += ax.plot(t, states[:, n + i], label=text, **line_style(i, name))
    finish(run, ax, (start, stop), shade, "Rates", "rate" if any(map(is_angle, names)) else "velocity (m/s)")
    return lines
