"""A map of stability over two parameters."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from .figure import axes_or_new
from .legends import legend_beside
from .palette import BLACK, DASHED, GREY, ORANGE, SKY, VERMILLION
from .parameters import parameter_label

STABLE = "#F2F2F2"
GROWING = (STABLE, SKY, ORANGE, VERMILLION)  # none, one, two, more
DOTTED = (0, (1, 1.5))
HATCH = "////"


class MapArtists(NamedTuple):
    """The colours and the lines of a stability map."""

    mesh: QuadMesh
    boundary: list[Line2D]


def plot_stability_map(plane: Any, ax: Axes | None = None, *, legend: bool = True) -> MapArtists:
    """Draw how many modes grow over a plane of two parameters, and the exact boundaries between.

    Solid lines are flutter, dashed ones divergence, dotted ones where the equilibrium itself ends; where
    there is none the plane is hatched.

    Parameters
    ----------
    plane : StabilityMap
    ax : Axes or None
        None draws into a new figure, ``artists.mesh.axes.figure``.
    legend : bool
        Whether to put a legend beside the panel.

    Returns
    -------
    MapArtists
        The coloured mesh, and a line for every boundary; one that is partly flutter and partly
        divergence gives two.
    """
    ax = axes_or_new(ax)
    ax.patch.set(facecolor="white", edgecolor=GREY, hatch=HATCH)  # seen where the mesh has no colour
    artists = MapArtists(_mesh(plane, ax), _boundary(plane, ax))
    ax.set(xlabel=parameter_label(plane.model, plane.x), ylabel=parameter_label(plane.model, plane.y))
    ax.set(xlim=(plane.x_values[0], plane.x_values[-1]), ylim=(plane.y_values[0], plane.y_values[-1]))
    if legend:
        legend_beside(ax, _handles(plane, artists.boundary))
    return artists


def _mesh(plane: Any, ax: Axes) -> QuadMesh:
    counts = np.ma.masked_less(np.minimum(plane.unstable, len(GROWING) - 1), 0)
    norm = BoundaryNorm(np.arange(len(GROWING) + 1) - 0.5, len(GROWING))
    colours = ListedColormap(list(GROWING))
    return ax.pcolormesh(
        plane.x_values, plane.y_values, counts, cmap=colours, norm=norm, shading="nearest", rasterized=True
    )


def _boundary(plane: Any, ax: Axes) -> list[Line2D]:
    lines = []
    for curve in plane.boundary:
        for name, (linestyle, chosen) in _kinds(np.asarray(curve.frequencies)).items():
            if chosen.any():
                x, y = np.where(chosen[:, None], curve.points, np.nan).T
                lines += ax.plot(x, y, color=BLACK, linewidth=1.4, linestyle=linestyle, label=name)
    return lines


def _kinds(frequencies: NDArray[np.float64]) -> dict[str, tuple[Any, NDArray[np.bool_]]]:
    return {
        "flutter": ("-", frequencies > 0),
        "divergence": (DASHED, frequencies == 0),
        "end of the equilibrium": (DOTTED, np.isnan(frequencies)),
    }


def _handles(plane: Any, boundary: list[Line2D]) -> list[Any]:
    shown = np.unique(np.minimum(plane.unstable, len(GROWING) - 1))
    names = ("stable", "1 mode grows", "2 modes grow", "3 modes or more grow")
    patches = [Patch(facecolor=GROWING[i], edgecolor=GREY, label=names[i]) for i in shown if i >= 0]
    if shown[0] < 0:
        patches.append(Patch(facecolor="white", edgecolor=GREY, hatch=HATCH, label="no equilibrium"))
    return patches + list({str(line.get_label()): line for line in boundary}.values())
