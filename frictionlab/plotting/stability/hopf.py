"""A Hopf point: the small vibration that is born where flutter sets in, by its normal form."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.plotting.appearance import background, crowding, font_size, legible, marker_size, pen
from frictionlab.plotting.bifurcation import SPECIAL_POINT_STYLES
from frictionlab.plotting.figure import axes_or_new, legend_beside
from frictionlab.plotting.style import BLACK, BLUE, DASHED, parameter_label, parameter_value_text, state_label
from frictionlab.presentation import state_unit
from frictionlab.validation import check_choice

EDGE_GROWTH = 0.01  # growth in a radian, at the picture's edges: the vibration of the normal form is small
POINTS = 201  # of each line


def plot_hopf(point: Any, ax: Axes | None = None, *, name: str | None = None) -> list[Line2D]:
    """Draw the amplitude of the vibration born at a Hopf point against the parameter, and the equilibrium.

    Solid lines are stable, dashed ones are not.  The vibration is drawn up to where it first reaches stick or
    separation, at most to where the equilibrium's growth rate is one percent of the angular frequency.  At a
    degenerate point there is the equilibrium alone.

    Parameters
    ----------
    point : HopfPoint
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate; None takes the first.

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
    shown: str = point.coordinates[0] if name is None else name
    check_choice("name", shown, point.coordinates)
    ax = axes_or_new(ax)
    distance = _distance(point)
    lines = _draw_equilibrium(point, ax, distance) + _draw_vibration(point, ax, distance, shown)
    colour, marker = SPECIAL_POINT_STYLES["Hopf"]
    text = f"Hopf point, {parameter_value_text(point.model, point.parameter, point.value)}"
    style: dict[str, Any] = {"color": legible(colour, ax), "markersize": marker_size(10.0)}
    lines += ax.plot(point.value, 0.0, marker, linestyle="none", label=text, **style)
    # On the left, as on the right there may be an offset of the numbers.
    ax.set_xlabel(parameter_label(point.model, point.parameter), loc="left")
    # States of an automaton without coordinates may have any unit.
    unit = f" ({state_unit(shown)})" if point.model.coordinates else ""
    ax.set(
        ylabel=f"amplitude of {state_label(shown)}{unit}",
        title=f"{point.criticality.capitalize()} Hopf point at {point.frequency:.4g} Hz",
    )
    ax.margins(x=0)
    ax.locator_params(axis="x", nbins=round(5 / crowding()))  # the numbers are long near a critical value
    ax.xaxis.labelpad += font_size(12.0) if crowding() > 1.0 else 0.0  # else it meets the offset
    legend_beside(ax, list({str(line.get_label()): line for line in lines}.values()))
    return lines


def _distance(point: Any) -> float:
    """From the critical value to the picture's edges."""
    weak = EDGE_GROWTH * 2 * np.pi * point.frequency / abs(point.crossing_speed)
    return float(np.nanmin([weak, abs(point.valid_until - point.value)]))


def _stability_style(stable: bool) -> tuple[str, Any]:
    return ("stable", "-") if stable else ("unstable", DASHED)


def _draw_equilibrium(point: Any, ax: Axes, distance: float) -> list[Line2D]:
    lines = []
    for edge, growing in zip((-distance, distance), point.change.unstable):
        text, linestyle = _stability_style(not growing)
        ends = sorted((point.value, point.value + edge))
        style: dict[str, Any] = {"linestyle": linestyle, **pen(BLACK, 1.4, ax)}
        lines += ax.plot(ends, [0.0, 0.0], label=f"{text} equilibrium", **style)
    return lines


def _draw_vibration(point: Any, ax: Axes, distance: float, name: str) -> list[Line2D]:
    share = np.linspace(-1.0, 1.0, POINTS)
    values = point.value + distance * share * np.abs(share)  # dense where the square root is steep
    amplitudes = point.amplitude(values)[:, point.coordinates.index(name)]
    drawn = np.isfinite(amplitudes)
    if not drawn.any():
        return []
    text, linestyle = _stability_style(
        point.criticality == "supercritical" and not min(point.change.unstable)
    )
    style: dict[str, Any] = {"linestyle": linestyle, **pen(BLUE, 1.4, ax)}
    lines = ax.plot(values[drawn], amplitudes[drawn], label=f"{text} vibration", **style)
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
