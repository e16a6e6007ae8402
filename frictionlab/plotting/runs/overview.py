"""`fl.plot_run`: a run in four panels; a coordinate against its rate, coloured by mode; the amplitude
spectrum of a state over the second half of a run.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from frictionlab.analysis.spectrum import Spectrum, amplitude_spectrum, highest_frequency
from frictionlab.plotting.appearance import crowding, font_size, legible, pen
from frictionlab.plotting.figure import axes_or_new, new_figure, set_long_title
from frictionlab.plotting.runs.time_histories import (
    DEFAULT_WINDOW,
    Array,
    Periods,
    Window,
    check_run,
    check_run_with_coordinates,
    force_outputs,
    modes_at,
    plot_contact_forces,
    plot_displacements,
    plot_rates,
    sample_times,
    window_limits,
    window_text,
)
from frictionlab.plotting.style import BLACK, mode_colours, state_label
from frictionlab.presentation import state_unit
from frictionlab.validation import check_choice

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


DECADES = 5


def plot_spectrum(
    run: Any, ax: Axes | None = None, *, name: str | None = None, f_max: float | None = None
) -> list[Line2D]:
    """Draw the amplitude spectrum of a state over the second half of a run.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure.
    name : str or None
        The state; None takes the first.
    f_max : float or None
        Right end of the frequency axis, Hz; None takes six times about the model's own frequency.

    Returns
    -------
    list of Line2D
        The spectrum; empty where the run is too short for one, which the panel then says.
    """
    check_run(run)
    shown: str = run.names[0] if name is None else name
    f_max = f_max or highest_frequency(run.source)
    found = amplitude_spectrum(run, shown, f_max=f_max)
    ax = axes_or_new(ax)
    if found is None:
        ax.set(
            xlabel="frequency (Hz)",
            ylabel=f"amplitude of {state_label(shown)} ({state_unit(shown)})",
            xlim=(0, f_max),
        )
        ax.set_title(f"Spectrum of {state_label(shown)}")
        ax.text(
            0.5, 0.5, "the run is too short\nfor a spectrum", ha="center", va="center", transform=ax.transAxes
        )
        return []
    lines = plot_amplitudes(found, ax)
    ax.set_xlim(0, f_max)
    return lines


def plot_amplitudes(found: Spectrum, ax: Axes | None = None) -> list[Line2D]:
    """Draw an amplitude spectrum.

    Parameters
    ----------
    found : Spectrum
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    list of Line2D
    """
    ax = axes_or_new(ax)
    lines = ax.plot(found.frequencies, found.amplitudes, **pen(BLACK, 1.0, ax))
    _logarithmic(ax, found.amplitudes)
    ax.set(
        xlabel="frequency (Hz)",
        ylabel=f"amplitude of {state_label(found.name)} ({state_unit(found.name)})",
        xlim=(0.0, found.frequencies[-1]),
    )
    set_long_title(ax, _spectrum_title(found.name, found))
    return lines


def _logarithmic(ax: Axes, amplitudes: Array) -> None:
    top = float(amplitudes.max())
    if top > 0:  # a state at rest has no logarithm
        ax.set_yscale("log")
        ax.set_ylim(top * 10.0**-DECADES, top * 2)


def _spectrum_title(name: str, found: Spectrum) -> str:
    digits = max(0, math.ceil(-math.log10(found.resolution)))
    strongest = f"strongest line {found.strongest:.{digits}f} Hz" if found.amplitudes.any() else "at rest"
    part = f"{found.start:.4g} s to {found.stop:.4g} s, Hann window"
    return f"Spectrum of {state_label(name)}, {part}\nresolution {found.resolution:.2g} Hz, {strongest}"


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
