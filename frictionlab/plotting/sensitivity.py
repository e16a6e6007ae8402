"""Sensitivities as a tornado plot."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from .appearance import legible, pen
from .figure import axes_or_new
from .style import BLUE, GREY, VERMILLION, parameter_symbol


def plot_sensitivity(found: Any, ax: Axes | None = None, *, most: int = 12) -> list[Artist]:
    """Draw the normalised derivatives of a quantity, the largest at the top (a tornado plot).

    Parameters
    ----------
    found : Sensitivity
    ax : Axes or None
        None draws into a new figure.
    most : int
        Parameters that are drawn.

    Returns
    -------
    list of Artist
        The bars.
    """
    ax = axes_or_new(ax)
    shares = np.nan_to_num(found.normalised)
    order = np.argsort(-np.abs(shares), kind="stable")[:most]
    colours = [legible(BLUE if shares[i] >= 0 else VERMILLION, ax) for i in order]
    bars = ax.barh(range(len(order)), shares[order], color=colours)
    ax.set_yticks(range(len(order)), [parameter_symbol(found.model, found.parameters[i]) for i in order])
    ax.invert_yaxis()
    ax.axvline(0.0, **pen(GREY, 0.8, ax))
    ax.set_xlabel(f"{found.quantity.partition(' (')[0]}: percent for a percent of the parameter")
    return list(bars)
