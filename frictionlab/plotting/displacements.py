"""Displacements against time."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .figure import axes_or_new
from .palette import beside, label, left_label, line_style, unit
from .time_panel import finish
from .windows import LAST, Window, dense_times, limits


def plot_displacements(
    run: Any, ax: Axes | None = None, *, window: Window = LAST, shade: bool = True
) -> list[Line2D]:
    """Draw all coordinates against time, with the modes shaded behind them.

    Lengths belong to the axis on the left; an angle (named phi, theta or psi) is dashed, as it has another
    unit and size, and where there are lengths belongs to an axis on the right.

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
    t = dense_times(start, stop)
    states, names = run(t), run.names[: run.automaton.coordinates]
    angles = beside(names)
    right = _angle_axis(ax) if angles else ax
    for axis in (ax, right):
        axis.ticklabel_format(axis="y", scilimits=(-3, 4))  # 1e-4 once rather than 0.00012 at every tick
    lines = []
    for i, name in enumerate(names):
        axis, text = right if name in angles else ax, f"{label(name)} ({unit(name)})"
        lines += axis.plot(t, states[:, i], label=text, **line_style(i, name))
    finish(run, ax, (start, stop), shade, "Displacements", left_label(names))
    return lines


def _angle_axis(ax: Axes) -> Axes:
    right = ax.twinx()
    right.set_ylabel("angle (rad), dashed")
    right.margins(x=0)
    return right
