"""Steady states, periodic orbits and ends of many runs in a phase plane; how perturbations grow."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import AsinhNorm, LinearSegmentedColormap
from matplotlib.container import ErrorbarContainer
from matplotlib.lines import Line2D

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.validation import check_choice

from .appearance import font_size, ink, ink_on, legible, marker_size, pen
from .figure import axes_or_new, legend_beside
from .runs.phase_plane import label_phase_plane, plot_phase_plane
from .style import BLUE, GREY, ORANGE, SKY, state_label

SHOWN_PERIODS = 3  # periods drawn of a periodic motion
SHOWN_SECONDS = 2.0  # drawn of others
LINEAR_SHARE = 1e-3  # of the largest derivative: colours of smaller ones are linear, of others logarithmic
MAX_NUMBERED = 10  # states of a matrix whose entries are written in its cells


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
        lines = ax.plot(x, rate, "+", color=ink(ax), markersize=marker_size(9.0), label="equilibrium")
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
    lines = ax.plot(x, rate, ".", color=legible(BLUE, ax))
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
    errors = found.standard_errors[finite]
    bars = ax.errorbar(place, found.exponents[finite], errors, fmt="o", color=legible(BLUE, ax))
    ax.axhline(0.0, **pen(GREY, 0.8, ax))
    ax.set(xlabel="direction", ylabel="Lyapunov exponent (1/s)", xticks=place)
    return bars


def plot_tangent_flow(flow: Any, ax: Axes | None = None) -> QuadMesh:
    """Draw the fundamental matrix of a run in colours: what a small change of each initial state becomes.

    Parameters
    ----------
    flow : TangentFlow
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    QuadMesh
        A column for each initial state, a row for each final one; the colours are logarithmic for all but
        small derivatives.
    """
    n, labels = len(flow.matrix), [state_label(name) for name in flow.names]
    ax = axes_or_new(ax)
    top = float(np.abs(flow.matrix).max()) or 1.0
    colours = LinearSegmentedColormap.from_list("signs", [SKY, "white", ORANGE])
    norm = AsinhNorm(linear_width=LINEAR_SHARE * top, vmin=-top, vmax=top)
    mesh = ax.pcolormesh(flow.matrix, cmap=colours, norm=norm)
    if n <= MAX_NUMBERED:
        for (i, j), entry in np.ndenumerate(flow.matrix):
            text = ax.text(j + 0.5, i + 0.5, f"{entry:.2g}", ha="center", va="center")
            text.set(fontsize=font_size(7.0), color=ink_on(mesh.to_rgba(entry)))
    ax.set_xticks(np.arange(n) + 0.5, labels)
    ax.set_yticks(np.arange(n) + 0.5, labels)
    ax.invert_yaxis()
    ax.set(xlabel="initial state (SI units)", ylabel="final state (SI units)", title="Fundamental matrix")
    ax.figure.colorbar(mesh, ax=ax, label="derivative (SI units)")
    return mesh
