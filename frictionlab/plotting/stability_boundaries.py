"""Where stability is lost: critical values of one parameter against another, and maps over two parameters;
and the small vibration born at a Hopf point, where flutter sets in, by its normal form.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    DASHED,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    add_halo,
    background,
    crowding,
    font_size,
    in_print,
    is_dark,
    legible,
    line_style,
    marker_size,
    pen,
)
from frictionlab.plotting.figure import axes_or_new, legend_beside, restyle, set_title, wrap_label
from frictionlab.plotting.labels import (
    check_compared,
    distinguishing_labels,
    parameter_label,
    parameter_value_text,
    state_with_unit,
)
from frictionlab.plotting.studies.sweeps import SPECIAL_POINT_STYLES
from frictionlab.validation import check_choice

if TYPE_CHECKING:
    from frictionlab.stability.boundaries.hopf import HopfPoint
    from frictionlab.stability.boundaries.stability_map import StabilityMap

STABLE_COLOUR, STABLE_ON_DARK = "#F2F2F2", "#333333"
COUNT_COLOURS = (STABLE_COLOUR, SKY, ORANGE, VERMILLION)  # none, one, two, more
PRINTED_COUNT_COLOURS = (STABLE_COLOUR, ORANGE, VERMILLION, PURPLE)  # ever darker
DOTTED = (0, (1, 1.5))
HATCH = "////"
LABEL_LENGTH = 45  # letters that fit along the height of a figure
EDGE_GROWTH = 0.01  # growth rate / angular frequency at the picture's edges: small, as a normal form needs
POINTS = 201  # of each line


def plot_critical(
    curves: Any,
    ax: Axes | None = None,
    *,
    labels: Sequence[str] | None = None,
    legend: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw critical values of a parameter against another: below a line steady sliding is stable.

    Parameters
    ----------
    curves : CriticalCurve, or a sequence of them
        Of the same two parameters.
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    labels : sequence of str or None
        A label for each curve; None takes what their models differ in.
    legend : bool
        Whether to put a legend beside the panel, where there is more than one curve.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One for every curve, broken where there is no critical value (NaN).

    Raises
    ------
    ValueError
        Where the curves are of different parameters, or there are not as many labels as curves.

    Examples
    --------
    >>> import frictionlab as fl
    >>> from frictionlab.plotting import plot_critical
    >>> curve = fl.critical_curve(fl.SliderOnBelt(), "mu_k", (0, 3), over=("F", [200.0, 400.0]))
    >>> [line.axes.get_xlabel() for line in plot_critical(curve)]
    ['preload on the slider $F$ (N)']
    """
    curves = [curves] if hasattr(curves, "over") else list(curves)
    labels = _curve_labels(curves) if labels is None else list(labels)
    check_compared("curves", [f"{curve.parameter} over {curve.over}" for curve in curves], labels)
    ax = axes_or_new(ax)
    lines = []
    for i, (curve, label) in enumerate(zip(curves, labels)):
        lines += ax.plot(curve.at, curve.values, label=label, **line_style(i, ax))
    first = curves[0]
    ylabel = wrap_label(f"critical {parameter_label(first.model, first.parameter)}", LABEL_LENGTH)
    ax.set(xlabel=parameter_label(first.model, first.over), ylabel=ylabel)
    ax.margins(x=0)
    if legend and len(curves) > 1:
        legend_beside(ax)
    return restyle(lines, line)


def _curve_labels(curves: list[Any]) -> list[str]:
    varied = {name for curve in curves for name in (curve.parameter, curve.over)}
    return distinguishing_labels([curve.model for curve in curves], varied) if curves else []


class MapArtists(NamedTuple):
    """The colours and the lines of a stability map."""

    mesh: QuadMesh
    boundary: list[Line2D]


def plot_stability_map(plane: StabilityMap, ax: Axes | None = None, *, legend: bool = True) -> MapArtists:
    """Draw how many modes grow over a plane of two parameters, and the exact boundaries between.

    Solid lines are flutter, dashed ones divergence, and at dotted ones the equilibrium itself ends; where
    there is no equilibrium the plane is hatched.

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
    ax.patch.set(facecolor=background(ax), edgecolor=GREY, hatch=HATCH)  # seen where the mesh has no colour
    artists = MapArtists(_draw_mesh(plane, ax), _draw_boundary(plane, ax))
    ax.set(xlabel=parameter_label(plane.model, plane.x), ylabel=parameter_label(plane.model, plane.y))
    ax.set(xlim=(plane.x_values[0], plane.x_values[-1]), ylim=(plane.y_values[0], plane.y_values[-1]))
    if legend:
        legend_beside(ax, _map_legend_handles(plane, artists.boundary, ax))
    return artists


def _draw_mesh(plane: StabilityMap, ax: Axes) -> QuadMesh:
    counts = np.ma.masked_less(np.minimum(plane.unstable, len(COUNT_COLOURS) - 1), 0)
    norm = BoundaryNorm(np.arange(len(COUNT_COLOURS) + 1) - 0.5, len(COUNT_COLOURS))
    colours = ListedColormap(_count_colours(ax))
    return ax.pcolormesh(
        plane.x_values, plane.y_values, counts, cmap=colours, norm=norm, shading="nearest", rasterized=True
    )


def _count_colours(ax: Axes) -> list[str]:
    if in_print():
        return [legible(colour, ax) for colour in PRINTED_COUNT_COLOURS]
    return [STABLE_ON_DARK if is_dark(ax) else STABLE_COLOUR, *COUNT_COLOURS[1:]]


def _draw_boundary(plane: StabilityMap, ax: Axes) -> list[Line2D]:
    lines = []
    for curve in plane.boundary:
        for name, (linestyle, of_kind) in _boundary_kinds(np.asarray(curve.frequencies)).items():
            if of_kind.any():
                x, y = np.where(of_kind[:, None], curve.points, np.nan).T
                lines += ax.plot(x, y, linestyle=linestyle, label=name, **pen(BLACK, 1.4, ax))
                add_halo(lines[-1], ax)
    return lines


def _boundary_kinds(frequencies: NDArray[np.float64]) -> dict[str, tuple[Any, NDArray[np.bool_]]]:
    return {
        "flutter": ("-", frequencies > 0),
        "divergence": (DASHED, frequencies == 0),
        "end of the equilibrium": (DOTTED, np.isnan(frequencies)),
    }


def _map_legend_handles(plane: StabilityMap, boundary: list[Line2D], ax: Axes) -> list[Any]:
    counts = np.unique(np.minimum(plane.unstable, len(COUNT_COLOURS) - 1))
    names = ("stable", "1 mode grows", "2 modes grow", "3 modes or more grow")
    colours = _count_colours(ax)
    patches = [Patch(facecolor=colours[i], edgecolor=GREY, label=names[i]) for i in counts if i >= 0]
    if counts[0] < 0:
        patches.append(Patch(facecolor=background(ax), edgecolor=GREY, hatch=HATCH, label="no equilibrium"))
    return [*patches, *boundary]


def plot_hopf(
    point: HopfPoint, ax: Axes | None = None, *, name: str | None = None, **line: Any
) -> list[Line2D]:
    """Draw the amplitude of the vibration born at a Hopf point against the parameter, and the equilibrium.

    Solid lines are stable, dashed ones are not.  The vibration is drawn up to where it first reaches stick or
    separation, at most to where the equilibrium's growth rate is one percent of the angular frequency.  At a
    degenerate point only the equilibrium is drawn.

    Parameters
    ----------
    point : HopfPoint
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        The equilibrium below and above the critical value, the vibration, its end where it reaches stick or
        separation, and the critical point.

    Raises
    ------
    ValueError
        For an unknown coordinate.

    Examples
    --------
    >>> import frictionlab as fl
    >>> point = fl.hopf(fl.SliderOnBelt(), "mu_k", bounds=(0, 4))
    >>> [line.get_linestyle() for line in plot_hopf(point)[:3]]
    ['-', '--', '--']
    """
    coordinate: str = point.coordinates[0] if name is None else name
    check_choice("name", coordinate, point.coordinates)
    ax = axes_or_new(ax)
    distance = _distance(point)
    lines = _draw_equilibrium(point, ax, distance) + _draw_vibration(point, ax, distance, coordinate)
    colour, marker = SPECIAL_POINT_STYLES["Hopf"]
    text = f"Hopf point, {parameter_value_text(point.model, point.parameter, point.value)}"
    style: dict[str, Any] = {"color": legible(colour, ax), "markersize": marker_size(10.0)}
    lines += ax.plot(point.value, 0.0, marker, linestyle="none", label=text, **style)
    # On the left, as the axis may show an offset of its numbers on the right.
    ax.set_xlabel(parameter_label(point.model, point.parameter), loc="left")
    ax.set_ylabel(f"amplitude of {state_with_unit(point.model, coordinate)}")
    set_title(ax, f"{point.criticality.capitalize()} Hopf point at {point.frequency:.4g} Hz")
    ax.margins(x=0)
    ax.locator_params(axis="x", nbins=round(5 / crowding()))  # the numbers are long near a critical value
    ax.xaxis.labelpad += font_size(12.0) if crowding() > 1.0 else 0.0  # else it meets the offset
    legend_beside(ax, lines)
    return restyle(lines, line)


def _distance(point: HopfPoint) -> float:
    """Distance of the picture's edges from the critical value."""
    weak = EDGE_GROWTH * 2 * np.pi * point.frequency / abs(point.crossing_speed)
    return float(np.nanmin([weak, abs(point.valid_until - point.value)]))


def _stability_style(stable: bool) -> tuple[str, Any]:
    return ("stable", "-") if stable else ("unstable", DASHED)


def _draw_equilibrium(point: HopfPoint, ax: Axes, distance: float) -> list[Line2D]:
    lines = []
    for edge, growing in zip((-distance, distance), point.change.unstable):
        text, linestyle = _stability_style(not growing)
        ends = sorted((point.value, point.value + edge))
        style: dict[str, Any] = {"linestyle": linestyle, **pen(BLACK, 1.4, ax)}
        lines += ax.plot(ends, [0.0, 0.0], label=f"{text} equilibrium", **style)
    return lines


def _draw_vibration(point: HopfPoint, ax: Axes, distance: float, name: str) -> list[Line2D]:
    share = np.linspace(-1.0, 1.0, POINTS)
    values = point.value + distance * share * np.abs(share)  # dense where the square root is steep
    amplitudes = point.amplitude(values)[:, point.coordinates.index(name)]
    finite = np.isfinite(amplitudes)
    if not finite.any():
        return []
    text, linestyle = _stability_style(
        point.criticality == "supercritical" and not min(point.change.unstable)
    )
    style: dict[str, Any] = {"linestyle": linestyle, **pen(BLUE, 1.4, ax)}
    lines = ax.plot(values[finite], amplitudes[finite], label=f"{text} vibration", **style)
    if distance == abs(point.valid_until - point.value):
        end = int(np.nanargmax(amplitudes))
        hollow: dict[str, Any] = {
            "color": legible(BLUE, ax),
            "markerfacecolor": background(ax),
            "linestyle": "none",
            "clip_on": False,
        }
        lines += ax.plot(values[end], amplitudes[end], "o", label="reaches stick or separation", **hollow)
    return lines
