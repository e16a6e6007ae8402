"""Frequencies and growth rates of a root locus against its parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from .figure import axes_or_new
from .legends import legend_beside
from .palette import GREY, line_style
from .parameters import parameter_label

Array = NDArray[np.float64]
THIN, HEAVY = 1.2, 3.2
GROWS = "heavy: the mode grows"
ZERO: dict[str, Any] = {"color": GREY, "linewidth": 0.8, "zorder": 1}


def plot_frequencies(
    locus: Any,
    ax: Axes | None = None,
    *,
    modes: Sequence[int] | None = None,
    label: str | None = None,
    color: str | None = None,
    linestyle: Any = None,
    legend: bool = True,
) -> list[Line2D]:
    """Draw the frequencies of the modes against the parameter, heavy where a mode grows.

    Parameters
    ----------
    locus : RootLocus
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    modes : sequence of int or None
        Columns of ``locus.values``; None draws all modes.
    label : str or None
        What the lines are called together, for several loci in one panel; None calls them mode 0, mode 1, ...
    color, linestyle : matplotlib's, or None
        For all lines; None gives each mode its own.
    legend : bool
        Whether to put a legend beside the panel.

    Returns
    -------
    list of Line2D
        A line for every mode, Hz, then the heavy parts of those that grow somewhere.

    Raises
    ------
    ValueError
        For a mode that the locus does not have.

    Examples
    --------
    >>> import frictionlab as fl
    >>> from frictionlab.plotting import plot_frequencies
    >>> lines = plot_frequencies(fl.root_locus(fl.SliderOnBelt(), "mu_k", [1.0, 1.5, 2.0]), modes=[1, 2])
    >>> lines[0].axes.get_ylabel()
    'frequency (Hz)'
    """
    ax = axes_or_new(ax)
    lines = _lines(locus, ax, locus.frequencies, modes, label, color, linestyle)
    return _finished(locus, ax, lines, "frequency (Hz)", legend)


def plot_growth_rates(
    locus: Any,
    ax: Axes | None = None,
    *,
    modes: Sequence[int] | None = None,
    label: str | None = None,
    color: str | None = None,
    linestyle: Any = None,
    legend: bool = True,
) -> list[Line2D]:
    """Draw the growth rates of the modes against the parameter, with the line of zero growth.

    Parameters, returned artists (1/s) and errors are those of :func:`plot_frequencies`.
    """
    ax = axes_or_new(ax)
    lines = _lines(locus, ax, locus.growth_rates, modes, label, color, linestyle)
    ax.axhline(0.0, **ZERO)
    return _finished(locus, ax, lines, "growth rate (1/s)", legend)


def chosen_modes(locus: Any, modes: Sequence[int] | None) -> list[int]:
    """The columns to draw, checked; all where none are named."""
    count = locus.values.shape[1]
    chosen = list(range(count)) if modes is None else [int(mode) for mode in modes]
    if not chosen or not all(0 <= mode < count for mode in chosen):
        raise ValueError(f"modes must be numbers from 0 to {count - 1}, got {modes!r}: leave it out for all")
    return chosen


def _lines(
    locus: Any,
    ax: Axes,
    values: Array,
    modes: Sequence[int] | None,
    label: str | None,
    color: str | None,
    linestyle: Any,
) -> list[Line2D]:
    chosen = chosen_modes(locus, modes)
    lines, heavy = [], []
    for i, mode in enumerate(chosen):
        own = line_style(mode, "")
        style = {"color": color or own["color"], "linestyle": linestyle or own["linestyle"]}
        name = f"mode {mode}" if label is None else (label if i == 0 else f"_{label}")
        lines += ax.plot(locus.at, values[:, mode], label=name, linewidth=THIN, **style)
        growing = np.where(locus.growth_rates[:, mode] > 0, values[:, mode], np.nan)
        if np.isfinite(growing).any():
            heavy += ax.plot(locus.at, growing, label="_grows", linewidth=HEAVY, **style)
    return lines + heavy


def _finished(locus: Any, ax: Axes, lines: list[Line2D], ylabel: str, legend: bool) -> list[Line2D]:
    ax.set(xlabel=parameter_label(locus.model, locus.parameter), ylabel=ylabel)
    ax.margins(x=0)
    if legend:
        heavy = [growing_handle()] if any(line.get_linewidth() == HEAVY for line in ax.lines) else []
        legend_beside(ax, ax.get_legend_handles_labels()[0] + heavy)
    return lines


def growing_handle() -> Line2D:
    """The heavy line's entry in a legend."""
    return Line2D([], [], color=GREY, linewidth=HEAVY, label=GROWS)
