"""A coordinate against its rate, coloured by mode."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.plotting.appearance import crowding, pen
from frictionlab.plotting.figure import axes_or_new
from frictionlab.plotting.style import mode_colours, state_label
from frictionlab.presentation import state_unit
from frictionlab.validation import check_choice

from .time_window import (
    Periods,
    Window,
    check_run_with_coordinates,
    modes_at,
    sample_times,
    window_limits,
    window_text,
)

PHASE_PLANE_WINDOW = Periods(20.0)  # long enough to tell a cycle that closes from one that does not


def plot_phase_plane(
    run: Any, ax: Axes | None = None, *, name: str | None = None, window: Window = PHASE_PLANE_WINDOW
) -> list[Line2D]:
    """Draw a coordinate against its rate, coloured by mode.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run; without it some twenty periods.

    Returns
    -------
    list of Line2D
        One line for every mode that occurs, broken (NaN) where the run is in other modes.

    Raises
    ------
    TypeError
        For what is no run.
    ValueError
        For a name that is no coordinate's, or a window outside the run.
    """
    check_run_with_coordinates(run)
    shown: str = run.names[0] if name is None else name
    check_choice("name", shown, run.names[: run.automaton.coordinates])
    start, stop = window_limits(run, window)
    ax = axes_or_new(ax, (5.0, 4.5))
    t = sample_times(start, stop, 12001)
    column, n = run.names.index(shown), run.automaton.coordinates
    states = run(t)[:, [column, column + n]]
    here = modes_at(run, t)
    lines = []
    for mode, colour in mode_colours(run).items():
        x, rate = _masked_states(states, here == mode)
        if not np.isnan(x).all():
            lines += ax.plot(x, rate, label=mode, **pen(colour, ax=ax))
    label_phase_plane(ax, shown, f"Phase plane of {state_label(shown)}, {window_text(run, start, stop)}")
    ax.locator_params(axis="x", nbins=round(6 / crowding()))  # small numbers have long labels
    return lines


def label_phase_plane(ax: Axes, name: str, title: str) -> None:
    """Label the axes with a coordinate and its rate."""
    x, rate = (f"{state_label(each)} ({state_unit(each)})" for each in (name, f"{name}'"))
    ax.set(xlabel=x, ylabel=rate, title=title)


def _masked_states(states: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The two columns, NaN outside the chosen samples and the one after each, so that lines meet."""
    kept = chosen | np.append(False, chosen[:-1])
    return np.where(kept[:, None], states, np.nan).T
