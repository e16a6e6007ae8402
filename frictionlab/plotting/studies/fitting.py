"""Residuals of fits."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from frictionlab.plotting.appearance import ink, pen
from frictionlab.plotting.figure import axes_or_new
from frictionlab.plotting.style import BLUE, VERMILLION

TWO_SIGMA = 1.96  # within this 95 percent of residuals lie, where model and errors are right


def plot_fit(found: Any, ax: Axes | None = None) -> list[Artist]:
    """Draw the residuals of a fit in units of their errors, over time.

    Parameters
    ----------
    found : Fit
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    list of Artist
        The points, and the lines between which 95 percent of them should lie.
    """
    ax = axes_or_new(ax)
    timed = np.isfinite(found.times)
    across = found.times if timed.any() else np.arange(len(found.residuals))
    drawn: list[Artist] = [*ax.plot(across, found.residuals, ".", **pen(BLUE, 1.0, ax))]
    drawn += [ax.axhline(side * TWO_SIGMA, linestyle=":", **pen(VERMILLION, 1.0, ax)) for side in (-1, 1)]
    ax.axhline(0.0, **pen(ink(ax), 0.8, ax))
    ax.set_xlabel("time (s)" if timed.any() else "measurement")
    ax.set_ylabel("(predicted − measured) / error")
    return drawn
