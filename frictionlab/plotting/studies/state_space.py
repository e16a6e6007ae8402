"""Steady states, periodic orbits and ends of many runs in a phase plane; how perturbations grow; basins of
attraction in a plane of initial states, and their shares of random initial states.
"""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import AsinhNorm, BoundaryNorm, LinearSegmentedColormap, ListedColormap
from matplotlib.container import BarContainer, ErrorbarContainer
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    YELLOW,
    add_halo,
    add_halo_to_errors,
    background,
    font_size,
    ink,
    ink_on,
    legible,
    marker_size,
    pen,
)
from frictionlab.plotting.figure import axes_or_new, legend_beside, restyle, set_title
from frictionlab.plotting.labels import state_label, with_unit
from frictionlab.plotting.overview import label_phase_plane, plot_phase_plane
from frictionlab.plotting.time_histories import Array, check_run_with_two_states
from frictionlab.plotting.turns import cut_at_turns, tick_turns, turning_angles, within_turn
from frictionlab.presentation import SI, in_units, state_unit
from frictionlab.validation import check_choice

if TYPE_CHECKING:
    from frictionlab.analysis.basins.basins import Basins, BasinStability, LabelledStates
    from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit
    from frictionlab.analysis.steady_state.steady_state import SteadyState
    from frictionlab.hybrid.variational.tangent_flow import TangentFlow

SHOWN_PERIODS = 3  # periods drawn of a periodic motion
SHOWN_SECONDS = 2.0  # drawn of others
LINEAR_SHARE = 1e-3  # of the largest derivative: the colour scale is linear below this, logarithmic above
MAX_NUMBERED = 10  # with more states the entries of a matrix are not written in its cells
# Colours of attractors, in turn; equilibria have their own, whichever attractor was found first
COLOURS_OF_REST = (SKY, BLUE, GREEN)
COLOURS_OF_MOTION = (ORANGE, YELLOW, PURPLE, VERMILLION, GREEN)
UNCLASSIFIED_COLOURS: dict[str, str] = {MotionKind.NOT_SETTLED: GREY, MotionKind.ENDED_EARLY: "#444444"}
HATCH = "////"


def plot_steady_state(
    steady: SteadyState,
    ax: Axes | None = None,
    *,
    name: str | None = None,
    **line: Any,
) -> list[Line2D]:
    """Draw what a motion settled to, in a phase plane: some periods of it, or a cross at an equilibrium.

    Parameters
    ----------
    steady : SteadyState
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One for every mode that occurs, or one cross.
    """
    run = steady.trajectory
    check_run_with_two_states(run)
    coordinate: str = run.automaton.shown_state if name is None else name
    check_choice("name", coordinate, run.automaton.shown_states)
    against = run.automaton.drawn_against(coordinate)
    alone, ax = ax is None, axes_or_new(ax)
    if steady.kind == MotionKind.EQUILIBRIUM:
        x, rate = run.final_state[[run.names.index(each) for each in (coordinate, against)]]
        x = within_turn(x) if coordinate in turning_angles(run.automaton) else x
        lines = ax.plot(x, rate, "+", color=ink(ax), markersize=marker_size(9.0), label="equilibrium")
        ax.set(ylim=(rate - 1.0, rate + 1.0))
    else:
        seconds = SHOWN_PERIODS * steady.period if steady.kind == MotionKind.PERIODIC else SHOWN_SECONDS
        lines = plot_phase_plane(run, ax, name=coordinate, window=min(seconds, float(run.raw.t)))
    label_phase_plane(run, ax, coordinate, f"Steady state: {steady.kind}")
    if alone:
        legend_beside(ax)
    return restyle(lines, line)


def plot_orbit(
    orbit: PeriodicOrbit, ax: Axes | None = None, *, name: str | None = None, **line: Any
) -> list[Line2D]:
    """Draw a periodic orbit in a phase plane, coloured by mode.

    Parameters
    ----------
    orbit : PeriodicOrbit
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One for every mode that occurs.
    """
    alone, ax = ax is None, axes_or_new(ax)
    lines = plot_phase_plane(orbit.trajectory, ax, name=name, window=None)
    kind = "Stable" if orbit.stable else "Unstable"
    set_title(ax, f"{kind} orbit of period {orbit.period:.6g} s")
    if alone:
        legend_beside(ax)
    return restyle(lines, line)


def plot_ends(ends: Any, ax: Axes | None = None, *, name: str | None = None, **line: Any) -> list[Line2D]:
    """Draw where the runs of an ensemble ended, in a phase plane.

    Parameters
    ----------
    ends : BatchResult
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        The points.
    """
    coordinates = [each for each in ends.names if f"{each}'" in ends.names]
    coordinate = coordinates[0] if name is None else name
    check_choice("name", coordinate, coordinates)
    rate_name = f"{coordinate}'"
    x, rate = (ends.states[:, ends.names.index(each)] for each in (coordinate, rate_name))
    ax, turns = axes_or_new(ax), coordinate in turning_angles(ends)
    lines = ax.plot(within_turn(x) if turns else x, rate, ".", color=legible(BLUE, ax))
    units = dict(zip(ends.names, ends.units))
    ax.set(xlabel=with_unit(coordinate, units[coordinate]), ylabel=with_unit(rate_name, units[rate_name]))
    if turns:
        tick_turns(ax.xaxis)
    set_title(ax, f"Ends of {len(x)} runs")
    return restyle(lines, line)


def plot_lyapunov(lyapunov: Any, ax: Axes | None = None) -> ErrorbarContainer:
    """Draw Lyapunov exponents, the largest first, with their standard errors; infinite ones are left out.

    Parameters
    ----------
    lyapunov : LyapunovSpectrum
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    ErrorbarContainer
    """
    ax = axes_or_new(ax)
    finite = np.isfinite(lyapunov.exponents)
    place = 1 + np.flatnonzero(finite)
    errors = lyapunov.standard_errors[finite]
    bars = ax.errorbar(place, lyapunov.exponents[finite], errors, fmt="o", color=legible(BLUE, ax))
    ax.axhline(0.0, **pen(GREY, 0.8, ax))
    ax.set(xlabel="direction", ylabel="Lyapunov exponent (1/s)", xticks=place)
    return bars


def plot_tangent_flow(flow: TangentFlow, ax: Axes | None = None) -> QuadMesh:
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
    ax.set(xlabel="initial state (SI units)", ylabel="final state (SI units)")
    set_title(ax, "Fundamental matrix")
    ax.figure.colorbar(mesh, ax=ax, label="derivative (SI units)")
    return mesh


class BasinArtists(NamedTuple):
    """The colours of the basins, and the attractors drawn over them."""

    mesh: QuadMesh
    attractors: list[Line2D]


def plot_basins(basins: Basins, ax: Axes | None = None, *, legend: bool = True) -> BasinArtists:
    """Draw which attractor each initial state goes to, and over it the attractors within the axes.

    Initial states that were not computed are hatched.

    Parameters
    ----------
    basins : Basins
    ax : Axes or None
        None draws into a new figure, ``artists.mesh.axes.figure``.
    legend : bool
        Whether to put a legend, with the shares, beside the panel.

    Returns
    -------
    BasinArtists

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> speeds = ("x1'", [0.0, 0.5]), ("y1'", [0.0, 0.1])
    >>> basins = fl.basins(model, *speeds, "near", window=10.0, progress=False)
    >>> plot_basins(basins).mesh.get_array().tolist()
    [[0, 1], [0, 1]]
    """
    ax = axes_or_new(ax)
    ax.patch.set(facecolor=background(ax), edgecolor=GREY, hatch=HATCH)  # seen where the mesh has no colour
    colours = _colours(basins, ax)
    norm = BoundaryNorm(np.arange(len(colours) + 1) - 0.5, max(1, len(colours)))
    mesh = ax.pcolormesh(
        basins.x_values,
        basins.y_values,
        np.ma.masked_less(basins.labels, 0),
        cmap=ListedColormap(colours or [GREY]),
        norm=norm if colours else None,
        shading="nearest",
        rasterized=True,
    )
    limits = ax.get_xlim(), ax.get_ylim()
    lines = [line for a in basins.attractors if a.settled for line in _attractor(basins, a, ax)]
    ax.set(
        xlim=limits[0],
        ylim=limits[1],
        xlabel=_initial_state_label(basins, basins.x),
        ylabel=_initial_state_label(basins, basins.y),
    )
    if legend:
        legend_beside(ax, _handles(basins, colours, background(ax)))
    return BasinArtists(mesh, lines)


def plot_basin_stability(stability: BasinStability, ax: Axes | None = None) -> BarContainer:
    """Draw the share of random initial states that goes to each attractor, with its standard error.

    Parameters
    ----------
    stability : BasinStability
    ax : Axes or None
        None draws into a new figure, ``bars.patches[0].axes.figure``.

    Returns
    -------
    BarContainer
    """
    ax = axes_or_new(ax)
    names, shares = list(stability.fractions), list(stability.fractions.values())
    errors = [stability.errors[name] for name in names]
    colours: dict[str, Any] = {"color": _colours(stability, ax), "edgecolor": ink(ax), "ecolor": ink(ax)}
    bars = ax.bar(names, shares, yerr=errors, capsize=4.0, **colours)
    if bars.errorbar is not None:
        add_halo_to_errors(bars.errorbar, ax)
    ax.set(ylim=(0.0, 1.0), ylabel="share of the initial states")
    return bars


def _colours(basins: LabelledStates, ax: Axes) -> list[str]:
    rest, motion = cycle(COLOURS_OF_REST), cycle(COLOURS_OF_MOTION)
    colours = [
        UNCLASSIFIED_COLOURS[a.kind]
        if not a.settled
        else next(rest if a.kind == MotionKind.EQUILIBRIUM else motion)
        for a in basins.attractors
    ]
    return [legible(colour, ax) for colour in colours]


def _attractor(basins: Basins, attractor: Any, ax: Axes) -> list[Line2D]:
    columns = [basins.names.index(name) for name in (basins.x, basins.y)]
    x, y = attractor.path[:, columns].T
    turning = turning_angles(basins)
    if basins.x in turning:
        x, y = _cut(x, y, basins.x_values)
    if basins.y in turning:
        y, x = _cut(y, x, basins.y_values)
    style = "o" if len(attractor.path) == 1 else "-" if attractor.period > 0 else ","
    lines = ax.plot(x, y, style, label=attractor.name, **pen(BLACK, 1.4, ax))
    add_halo(lines[0], ax)
    return lines


def _cut(angle: Array, other: Array, values: Array) -> tuple[Array, Array]:
    """An angle within the turn about the middle of its initial values, cut with what is drawn over it."""
    middle = float(values.min() + values.max()) / 2
    shown, other = cut_at_turns(angle - middle, other)
    return shown + middle, other


def _initial_state_label(basins: Basins, name: str) -> str:
    about = basins.specification["model"]  # a structure's has its units beside its parameters
    unit = "" if "automaton" in about else in_units(about.get("units", SI), state_unit(name))
    return f"initial {with_unit(name, unit)}"


def _handles(basins: Basins, colours: list[str], empty: str) -> list[Any]:
    shares = basins.fractions
    handles = [
        Patch(facecolor=colour, edgecolor=GREY, label=f"{a.name}: {shares[a.name]:.1%}")
        for a, colour in zip(basins.attractors, colours)
    ]
    if (basins.labels < 0).any():
        handles.append(Patch(facecolor=empty, edgecolor=GREY, hatch=HATCH, label="not computed"))
    return handles
