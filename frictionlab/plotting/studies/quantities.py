"""Sensitivities of quantities as a tornado plot, their distributions, the shares of parameters in their
variance, their optima, and residuals of fits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from frictionlab.plotting.appearance import (
    BLUE,
    GREY,
    ORANGE,
    VERMILLION,
    add_halo_to_errors,
    ink,
    legible,
    pen,
)
from frictionlab.plotting.figure import axes_or_new, legend_beside, set_title
from frictionlab.plotting.labels import parameter_symbol

if TYPE_CHECKING:
    from frictionlab.analysis.fitting.fit import Fit
    from frictionlab.analysis.quantities.optimum import Optimum
    from frictionlab.analysis.quantities.quantities import Sensitivity
    from frictionlab.analysis.quantities.uncertainty import SobolIndices, Uncertainty

TWO_SIGMA = 1.96  # 95 percent of the residuals lie within it, if model and errors are right


def plot_sensitivity(sensitivity: Sensitivity, ax: Axes | None = None, *, most: int = 12) -> list[Artist]:
    """Draw the normalised derivatives of a quantity, the largest at the top (a tornado plot).

    Parameters
    ----------
    sensitivity : Sensitivity
    ax : Axes or None
        None draws into a new figure.
    most : int
        How many parameters are drawn.

    Returns
    -------
    list of Artist
        The bars.
    """
    ax = axes_or_new(ax)
    shares = np.nan_to_num(sensitivity.normalised)
    order = np.argsort(-np.abs(shares), kind="stable")[:most]
    colours = [legible(BLUE if shares[i] >= 0 else VERMILLION, ax) for i in order]
    bars = ax.barh(range(len(order)), shares[order], color=colours)
    ax.set_yticks(
        range(len(order)), [parameter_symbol(sensitivity.model, sensitivity.parameters[i]) for i in order]
    )
    ax.invert_yaxis()
    ax.axvline(0.0, **pen(GREY, 0.8, ax))
    ax.set_xlabel(f"{sensitivity.quantity.partition(' (')[0]}: percent for a percent of the parameter")
    return list(bars)


def plot_uncertainty(uncertainty: Uncertainty, ax: Axes | None = None) -> list[Artist]:
    """Draw the distribution of a quantity: its cumulative probability, median and central 95 percent.

    Parameters
    ----------
    uncertainty : Uncertainty
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    list of Artist
        The curve, the line of the median, and those of the 2.5th and 97.5th percentiles.
    """
    ax = axes_or_new(ax)
    sorted_values = np.sort(uncertainty.values[np.isfinite(uncertainty.values)])
    share = np.arange(1, len(sorted_values) + 1) / len(uncertainty.values)
    artists: list[Artist] = [*ax.step(sorted_values, share, where="post", **pen(BLUE, 1.5, ax))]
    for level, colour in ((0.5, ink(ax)), (0.025, VERMILLION), (0.975, VERMILLION)):
        at = uncertainty.quantile(level)
        if np.isfinite(at):
            artists.append(ax.axvline(at, linestyle=":", **pen(colour, 1.0, ax)))
    ax.set_xlabel(uncertainty.quantity)
    ax.set_ylabel("cumulative probability")
    ax.set_ylim(0.0, 1.02)
    return artists


def plot_sobol_indices(indices: SobolIndices, ax: Axes | None = None) -> list[Artist]:
    """Draw the first-order and total indices of each parameter with their errors.

    Parameters
    ----------
    indices : SobolIndices
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    list of Artist
        Two containers of bars.
    """
    ax = axes_or_new(ax)
    order = np.argsort(-np.nan_to_num(indices.total_order), kind="stable")
    places = np.arange(len(order))
    groups = [
        (indices.first_order, indices.first_errors, ORANGE, "alone", -0.2),
        (indices.total_order, indices.total_errors, BLUE, "with interactions", 0.2),
    ]
    artists: list[Any] = []
    for values, errors, colour, label, shift in groups:
        bars = ax.barh(places + shift, values[order], height=0.4, color=legible(colour, ax), label=label)
        how: dict[str, Any] = {"fmt": "none", "capsize": 3, **pen(ink(ax), 1.0, ax)}
        add_halo_to_errors(ax.errorbar(values[order], places + shift, xerr=errors[order], **how), ax)
        artists.append(bars)
    ax.set_yticks(places, [parameter_symbol(indices.model, indices.parameters[i]) for i in order])
    ax.invert_yaxis()
    ax.set_xlabel(f"share of the variance of {indices.quantity}")
    ax.legend(frameon=False)
    return artists


def plot_optimum(optimum: Optimum, ax: Axes | None = None) -> list[Artist]:
    """Draw the best values of the parameters between their bounds, and those where the search began.

    Parameters
    ----------
    optimum : Optimum
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    list of Artist
        The points where it began, the best ones, and the labels of the bounds.
    """
    ax = axes_or_new(ax)
    rows = np.arange(len(optimum.parameters))
    low, high = optimum.bounds.T
    first, best = ((values - low) / (high - low) for values in (optimum.first, optimum.at))
    ax.hlines(rows, 0.0, 1.0, **pen(GREY, 1.0, ax))
    begin = ax.plot(first, rows, "o", mfc="none", label="where it began", **pen(BLUE, 1.0, ax))
    artists: list[Artist] = [*begin, *ax.plot(best, rows, "D", label="best", **pen(VERMILLION, 1.0, ax))]
    above: dict[str, Any] = {"xytext": (0, 5), "textcoords": "offset points", "color": ink(ax)}
    below: dict[str, Any] = {**above, "xytext": (0, -6), "ha": "center", "va": "top"}
    for row, name in enumerate(optimum.parameters):
        artists.append(ax.annotate(f"{low[row]:g}", (0.0, row), **above))
        artists.append(ax.annotate(f"{high[row]:g}", (1.0, row), ha="right", **above))
        artists.append(ax.annotate(f"{optimum[name]:.4g}", (best[row], row), **below))
    ax.set_yticks(rows, [parameter_symbol(optimum.model, name) for name in optimum.parameters])
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.set_xlim(-0.03, 1.03)
    ax.set_xlabel("share of the way between the bounds")
    set_title(ax, f"{optimum.quantity}: {optimum.value:.5g}")
    legend_beside(ax)
    return artists


def plot_fit(fit: Fit, ax: Axes | None = None) -> list[Artist]:
    """Draw the residuals of a fit in units of their errors, over time.

    Parameters
    ----------
    fit : Fit
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    list of Artist
        The points, and the lines between which 95 percent of them should lie.
    """
    ax = axes_or_new(ax)
    timed = np.isfinite(fit.times)
    across = fit.times if timed.any() else np.arange(len(fit.residuals))
    artists: list[Artist] = [*ax.plot(across, fit.residuals, ".", **pen(BLUE, 1.0, ax))]
    artists += [ax.axhline(side * TWO_SIGMA, linestyle=":", **pen(VERMILLION, 1.0, ax)) for side in (-1, 1)]
    ax.axhline(0.0, **pen(ink(ax), 0.8, ax))
    ax.set_xlabel("time (s)" if timed.any() else "measurement")
    ax.set_ylabel("(predicted − measured) / error")
    return artists
