"""Steady states, periodic orbits and ends of many runs in a phase plane; Lyapunov exponents."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.lines import Line2D

from frictionlab.analysis.steady_state.motion_kind import MotionKind
from frictionlab.validation import check_choice

from .figure import axes_or_new, legend_beside
from .runs.phase_plane import label_phase_plane, plot_phase_plane
from .style import BLACK, BLUE, GREY

SHOWN_PERIODS = 3  # periods drawn of a periodic motion
SHOWN_SECONDS = 2.0  # drawn of others


def plot_steady_state(found: Any, ax: Axes | None = None, *, name: str | None = None) -> list[Line2D]:
    """Draw what a motion settled to in a phase plane: some periods of it, or a cross at an equilibrium.

    Parameters
    ----------
    found : SteadyState
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.

    Returns
    -------
    list of Line2D
        One for every mode that occurs, or one cross.
    """
    run = found.trajectory
    shown: str = run.names[0] if name is None else name
    check_choice("name", shown, run.names[: run.automaton.coordinates])
    alone, ax = ax is None, axes_or_new(ax)
    if found.kind == MotionKind.EQUILIBRIUM:
        column = run.names.index(shown)
        x, rate = run.final_state[[column, column + run.automaton.coordinates]]
        lines = ax.plot(x, rate, "+", color=BLACK, markersize=9.0, label="equilibrium")
        ax.set(ylim=(-1.0, 1.0))
    else:
        seconds = SHOWN_PERIODS * found.period if found.kind == MotionKind.PERIODIC else SHOWN_SECONDS
        lines = plot_phase_plane(run, ax, name=shown, window=min(seconds, float(run.raw.t)))
    label_phase_plane(ax, shown, f"Steady state: {found.kind}")
    if alone:
        legend_beside(ax)
    return lines


def plot_orbit(orbit: Any, ax: Axes | None = None, *, name: str | None = None) -> list[Line2D]:
    """Draw a periodic orbit in a phase plane, coloured by mode.

    Parameters
    ----------
    orbit : PeriodicOrbit
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.

    Returns
    -------
    list of Line2D
        One for every mode that occurs.
    """
    alone, ax = ax is None, axes_or_new(ax)
    lines = plot_phase_plane(orbit.trajectory, ax, name=name, window=None)
    kind = "Stable" if orbit.stable else "Unstable"
    ax.set_title(f"{kind} orbit of period {orbit.period:.6g} s")
    if alone:
        legend_beside(ax)
    return lines


def plot_ends(ends: Any, ax: Axes | None = None, *, name: str | None = None) -> list[Line2D]:
    """Draw where the runs of an ensemble ended, in a phase plane.

    Parameters
    ----------
    ends : BatchResult
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.

    Returns
    -------
    list of Line2D
        The points.
    """
    coordinates = [each for each in ends.names if f"{each}'" in ends.names]
    shown = coordinates[0] if name is None else name
    check_choice("name", shown, coordinates)
    x, rate = (ends.states[:, ends.names.index(each)] for each in (shown, f"{shown}'"))
    ax = axes_or_new(ax)
    lines = ax.plot(x, rate, ".", color=BLUE)
    label_phase_plane(ax, shown, f"Ends of {len(x)} runs")
    return lines


def plot_lyapunov(found: Any, ax: Axes | None = None) -> ErrorbarContainer:
    """Draw Lyapunov exponents, the largest first, with their standard errors; infinite ones are left out.

    Parameters
    ----------
    found : LyapunovSpectrum
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    ErrorbarContainer
    """
    ax = axes_or_new(ax)
    finite = np.isfinite(found.exponents)
    place = 1 + np.flatnonzero(finite)
    bars = ax.errorbar(place, found.exponents[finite], found.standard_errors[finite], fmt="o", color=BLUE)
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    ax.set(xlabel="direction", ylabel="Lyapunov exponent (1/s)", xticks=place)
    return bars
