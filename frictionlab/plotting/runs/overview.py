"""`fl.plot_run`: a run in four panels."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from frictionlab.plotting.appearance import crowding, font_size, legible
from frictionlab.plotting.figure import new_figure
from frictionlab.plotting.style import mode_colours

from .phase_plane import plot_phase_plane
from .spectrum import plot_spectrum
from .time_histories import force_outputs, plot_contact_forces, plot_displacements, plot_rates
from .time_window import DEFAULT_WINDOW, Window, check_run_with_coordinates

SIZE = (12.0, 7.0)
FONT_SIZE = 9.0


def plot_run(run: Any, figure: Figure | None = None, *, window: Window = DEFAULT_WINDOW) -> Figure:
    """Draw a run: displacements and contact forces against time, phase plane and spectrum of a coordinate.

    Phase plane and spectrum are of the first coordinate.  Without contact forces there are rates instead.

    Parameters
    ----------
    run : Trajectory
        Of a model, or of an automaton with coordinates.
    figure : Figure or None
        Where to draw; None makes a new figure that belongs to no window.
    window : float, (float, float) or None
        What the panels over time show: the last so many seconds, from one time to another, or the whole
        run; without it some eight periods.

    Returns
    -------
    Figure
        With the axes displacements, phase plane, forces, spectrum, in this order, and last the one of the
        angle beside the displacements, if there is one; a notebook shows the figure.

    Examples
    --------
    >>> import frictionlab as fl
    >>> figure = fl.plot_run(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.3))
    >>> [ax.get_xlabel() for ax in figure.axes[:4]]
    ['time (s)', '$x_{1}$ (m)', 'time (s)', 'frequency (Hz)']
    """
    check_run_with_coordinates(run)
    figure = new_figure(*SIZE) if figure is None else figure
    panels = figure.subplots(2, 2, width_ratios=(1.5, 1))
    (displacements, phase), (forces, spectrum) = panels
    coordinates = plot_displacements(run, displacements, window=window)
    plot_phase_plane(run, phase)
    draw = plot_contact_forces if force_outputs(run.automaton) else plot_rates
    contact = draw(run, forces, window=window)
    plot_spectrum(run, spectrum)
    # An angle has its axis next to the panel; the legends stand to the right of it.
    right = 1.0 + 0.17 * crowding() if any(line.axes is not displacements for line in coordinates) else 1.0
    _legend_right_of(displacements, coordinates, right)
    _legend_right_of(forces, contact, right)
    for ax in panels.flat:
        ax.title.set_fontsize(font_size(FONT_SIZE + 1) / crowding())
    _title(figure, run)
    return figure


def _legend_right_of(ax: Axes, lines: list[Line2D], x: float) -> None:
    """A legend of the lines to the right of the panel, where it covers nothing."""
    place: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (x, 0.5)}
    ax.legend(handles=lines, frameon=False, fontsize=font_size(FONT_SIZE), **place)


def _title(figure: Figure, run: Any) -> None:
    colours = mode_colours(run)
    # Modes entered for a few thousandths of the time are listed too, though too short to be visible.
    modes = [name for name, seconds in run.time_in_mode.items() if seconds > 0]
    handles = [Patch(facecolor=legible(colours[name]), alpha=0.6, label=name) for name in modes]
    what = "run" if run.source is None else repr(run.source)
    state = "" if run.status.ok else f" ({run.status.name.lower().replace('_', ' ')})"
    about = run.description.get("method", {})
    method = about.get("integrator", about.get("name", ""))
    size = font_size(FONT_SIZE + 3) / crowding()
    figure.suptitle(f"{what}, {run.raw.t:.4g} s, {method}{state}", fontsize=size, wrap=True)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles) or 1, frameon=False)
