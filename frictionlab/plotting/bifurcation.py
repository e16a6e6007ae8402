"""Steady states against a parameter: section points, and the intensity of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from frictionlab.analysis.kinds import ENDED

from .figure import axes_or_new
from .legends import legend_beside
from .palette import BLACK, BLUE, GREY, VERMILLION, label, line_style, unit
from .parameters import parameter_label

Array = NDArray[np.float64]
STYLES: dict[str, dict[str, Any]] = {
    "periodic": {"color": BLUE, "marker": ".", "markersize": 4.0},
    "non-periodic": {"color": VERMILLION, "marker": ".", "markersize": 2.0},
    "not settled yet": {"color": GREY, "marker": ".", "markersize": 3.0},
    "ended early": {"color": GREY, "marker": "x", "markersize": 3.0},
    "equilibrium": {"color": BLACK, "marker": "_", "markersize": 6.0},
}
AT_REST = "equilibrium"
FOOT = 0.03  # of the axes' height: where marks are of what ended early, mostly for having grown beyond bounds
SPAN = 30.0  # largest over smallest intensity above which the axis is logarithmic


def plot_bifurcation(
    result: Any, ax: Axes | None = None, *, name: str | None = None, legend: bool = True
) -> list[Line2D]:
    """Draw a state at the points of the section against the parameter, and the equilibria.

    Parameters
    ----------
    result : Bifurcation
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The state, e.g. "x1" or "x1'"; None takes the first.
    legend : bool
        Whether to put a legend beside the panel.

    Returns
    -------
    list of Line2D
        The points of every kind of motion that occurs; what ended early is marked at the foot.

    Raises
    ------
    ValueError
        For an unknown state.
    """
    state: str = name or result.names[0]
    groups = {kind: result.section(state, kind) for kind in STYLES}
    ax = axes_or_new(ax)
    lines = []
    for kind, (values, states) in groups.items():
        if kind == ENDED:
            states, where = np.full(len(values), FOOT), ax.get_xaxis_transform()
        else:
            where = ax.transData
        if len(values):
            lines += ax.plot(values, states, linestyle="none", label=kind, transform=where, **STYLES[kind])
    ax.set(xlabel=_parameter(result), ylabel=f"{label(state)} at {_where(result)} ({unit(state)})")
    if legend:
        legend_beside(ax)
    return lines


def plot_intensity(
    results: Any, ax: Axes | None = None, *, labels: Sequence[str] | None = None, legend: bool = True
) -> list[Line2D]:
    """Draw the intensity L_s of the motion, Eq. (20), against the parameter.

    Where the intensities of what moves span decades the axis is logarithmic above the least of them, and
    linear below, so that the zero of equilibria, which are hollow, is at its foot.

    Parameters
    ----------
    results : Bifurcation, or a sequence of them
        Over the same parameter.
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    labels : sequence of str or None
        A name for each; None says where they start from.
    legend : bool
        Whether to put a legend beside the panel, where there is more than one line.

    Returns
    -------
    list of Line2D
        One for each result, broken where there is no intensity.

    Raises
    ------
    ValueError
        Where the parameters differ, or there are not as many labels as results.
    """
    results = [results] if hasattr(results, "kinds") else list(results)
    labels = [_start(result) for result in results] if labels is None else list(labels)
    _refuse_mixed(results, labels)
    ax = axes_or_new(ax)
    lines = []
    for i, (result, text) in enumerate(zip(results, labels)):
        style = line_style(i, "")
        lines += ax.plot(result.values, result.intensities, ".", label=text, **style)
        resting = np.array(result.kinds) == AT_REST
        hollow = {"color": style["color"], "markerfacecolor": "white", "linestyle": "none", "markersize": 4.0}
        ax.plot(result.values[resting], result.intensities[resting], "o", label="_at rest", **hollow)
    _scale(ax, results)
    ax.set(xlabel=_parameter(results[0]), ylabel=r"intensity $L_{\mathrm{s}}$ (m$^{2}$)")
    if legend and len(lines) > 1:
        legend_beside(ax)
    return lines


def _scale(ax: Axes, results: list[Any]) -> None:
    moving = np.concatenate([r.intensities[np.array(r.kinds) != AT_REST] for r in results])
    moving = moving[moving > 0]  # NaN, of what is not done, is dropped too
    if len(moving) and moving.max() > SPAN * moving.min():
        foot = 10.0 ** np.floor(np.log10(moving.min()))
        ax.set_yscale("symlog", linthresh=foot, linscale=0.3)
        ax.set_ylim(-0.1 * foot, None)
    else:
        ax.set_ylim(0.0 if len(moving) else None, None)


def _parameter(result: Any) -> str:
    return parameter_label(result.model, result.parameter)


def _where(result: Any) -> str:
    section = result.asked["section"]
    if section is None or section == "stick":
        return "the onset of stick" if section else "the section"
    text, direction = (section, 0) if isinstance(section, str) else section
    return f"{text} = 0" + {1: ", rising", -1: ", falling"}.get(direction, "")


def _start(result: Any) -> str:
    x0 = result.asked["x0"]
    return {"rest": "from rest", "near": "from near the equilibrium", "continue": "continued"}.get(
        x0 if isinstance(x0, str) else "", "from a state"
    )


def _refuse_mixed(results: list[Any], labels: list[str]) -> None:
    names = sorted({result.parameter for result in results})
    if len(names) != 1:
        got = ", ".join(names) or "no result"
        raise ValueError(f"results must be over one parameter, got {got}: draw them apart")
    if len(labels) != len(results):
        raise ValueError(f"there must be a label for each of {len(results)} results, got {len(labels)}")
