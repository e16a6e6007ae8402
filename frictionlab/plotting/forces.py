"""Contact forces against time."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .figure import axes_or_new
from .palette import BLUE, VERMILLION
from .shading import shade_modes
from .windows import LAST, Window, dense_times, limits, window_text

FORCES = {"normal_force": ("$F_N$ (N)", BLUE), "friction_force": ("$F_T$ (N)", VERMILLION)}


def plot_contact_forces(
    run: Any, ax: Axes | None = None, *, window: Window = LAST, shade: bool = True
) -> list[Line2D]:
    """Draw the normal and the friction force against time, with the modes shaded behind them.

    Parameters
    ----------
    run : Trajectory
        Of an automaton with the outputs ``normal_force`` and ``friction_force``.
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run.
    shade : bool
        Whether to shade the modes.

    Returns
    -------
    list of Line2D
        F_N and F_T.
    """
    ax = axes_or_new(ax)
    start, stop = limits(run, window)
    t = dense_times(start, stop)
    lines = []
    for name, (text, colour) in FORCES.items():
        lines += ax.plot(t, run.output(name, t), label=text, color=colour, linewidth=1.2)
    if shade:
        shade_modes(run, ax, (start, stop))
    title = f"Contact forces, {window_text(run, start, stop)}"
    ax.set(xlabel="time (s)", ylabel="contact force (N)", title=title)
    ax.margins(x=0)
    return lines
