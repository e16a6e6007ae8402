"""Basins of attraction in a plane of initial states, and their shares of random ones."""

from __future__ import annotations

from itertools import cycle
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.container import BarContainer
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.presentation import state_unit

from .appearance import add_halo, background, ink, legible, pen
from .figure import axes_or_new, legend_beside
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION, YELLOW, state_label

# Of attractors, in turn: rest has one colour in all pictures, whatever motion was found first
COLOURS_OF_REST = (SKY, BLUE, GREEN)
COLOURS_OF_MOTION = (ORANGE, YELLOW, PURPLE, VERMILLION, GREEN)
UNCLASSIFIED_COLOURS = {MotionKind.NOT_SETTLED: GREY, MotionKind.ENDED_EARLY: "#444444"}
HATCH = "////"


class BasinArtists(NamedTuple):
    """The colours of the basins, and the attractors drawn over them."""

    mesh: QuadMesh
    attractors: list[Line2D]


def plot_basins(found: Any, ax: Axes | None = None, *, legend: bool = True) -> BasinArtists:
    """Draw which attractor each initial state goes to, and those attractors that are within the axes.

    Initial states that were not computed are hatched.

    Parameters
    ----------
    found : Basins
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
    >>> found = fl.basins(model, *speeds, "near", window=10.0, progress=False)
    >>> plot_basins(found).mesh.get_array().tolist()
    [[0, 1], [0, 1]]
    """
    ax = axes_or_new(ax)
    ax.patch.set(facecolor=background(ax), edgecolor=GREY, hatch=HATCH)  # seen where the mesh has no colour
    colours = _colours(found, ax)
    norm = BoundaryNorm(np.arange(len(colours) + 1) - 0.5, max(1, len(colours)))
    mesh = ax.pcolormesh(
        found.x_values,
        found.y_values,
        np.ma.masked_less(found.labels, 0),
        cmap=ListedColormap(colours or [GREY]),
        norm=norm if colours else None,
        shading="nearest",
        rasterized=True,
    )
    limits = ax.get_xlim(), ax.get_ylim()
    lines = [line for a in found.attractors if a.settled for line in _attractor(found, a, ax)]
    ax.set(
        xlim=limits[0],
        ylim=limits[1],
        xlabel=_initial_state_label(found.x),
        ylabel=_initial_state_label(found.y),
    )
    if legend:
        legend_beside(ax, _handles(found, colours, background(ax)))
    return BasinArtists(mesh, lines)


def plot_basin_stability(found: Any, ax: Axes | None = None) -> BarContainer:
    """Draw the share of random initial states that goes to each attractor, with its standard error.

    Parameters
    ----------
    found : BasinStability
    ax : Axes or None
        None draws into a new figure, ``bars.patches[0].axes.figure``.

    Returns
    -------
    BarContainer
    """
    ax = axes_or_new(ax)
    names, shares = list(found.fractions), list(found.fractions.values())
    errors = [found.errors[name] for name in names]
    colours: dict[str, Any] = {"color": _colours(found, ax), "edgecolor": ink(ax), "ecolor": ink(ax)}
    bars = ax.bar(names, shares, yerr=errors, capsize=4.0, **colours)
    if bars.errorbar is not None:
        _, caps, spans = bars.errorbar.lines
        for line in (*caps, *spans):
            add_halo(line, ax)
    ax.set(ylim=(0.0, 1.0), ylabel="share of the initial states")
    return bars


def _colours(found: Any, ax: Axes) -> list[str]:
    rest, motion = cycle(COLOURS_OF_REST), cycle(COLOURS_OF_MOTION)
    colours = [
        UNCLASSIFIED_COLOURS[a.kind]
        if not a.settled
        else next(rest if a.kind == MotionKind.EQUILIBRIUM else motion)
        for a in found.attractors
    ]
    return [legible(colour, ax) for colour in colours]


def _attractor(found: Any, attractor: Any, ax: Axes) -> list[Line2D]:
    columns = [found.names.index(name) for name in (found.x, found.y)]
    x, y = attractor.path[:, columns].T
    style = "o" if len(x) == 1 else "-" if attractor.period > 0 else ","
    lines = ax.plot(x, y, style, label=attractor.name, **pen(BLACK, 1.4, ax))
    add_halo(lines[0], ax)
    return lines


def _initial_state_label(name: str) -> str:
    return f"initial {state_label(name)} ({state_unit(name)})"


def _handles(found: Any, colours: list[str], empty: str) -> list[Any]:
    shares = found.fractions
    handles = [
        Patch(facecolor=colour, edgecolor=GREY, label=f"{a.name}: {shares[a.name]:.1%}")
        for a, colour in zip(found.attractors, colours)
    ]
    if (found.labels < 0).any():
        handles.append(Patch(facecolor=empty, edgecolor=GREY, hatch=HATCH, label="not computed"))
    return handles
