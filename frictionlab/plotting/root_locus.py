"""A root locus in the complex plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from .figure import axes_or_new
from .locus import ZERO, chosen_modes
from .palette import BLACK
from .parameters import parameter_label, parameter_value

COLOURS = "viridis"


def plot_root_locus(
    locus: Any, ax: Axes | None = None, *, modes: Sequence[int] | None = None
) -> list[LineCollection]:
    """Draw the eigenvalues in the complex plane, coloured along the parameter, from dots to crosses.

    Of a conjugate pair the one in the upper half-plane is drawn; to the right of the imaginary axis it grows.

    Parameters
    ----------
    locus : RootLocus
    ax : Axes or None
        None draws into a new figure, ``curves[0].axes.figure``.
    modes : sequence of int or None
        Columns of ``locus.values``; None draws all modes.

    Returns
    -------
    list of LineCollection
        One for every mode.

    Raises
    ------
    ValueError
        For a mode that the locus does not have.
    """
    ax = axes_or_new(ax)
    chosen = chosen_modes(locus, modes)
    ax.axvline(0.0, **ZERO)
    curves = [_coloured(locus, ax, mode) for mode in chosen]
    ax.autoscale_view()
    ax.set(xlabel="growth rate (1/s)", ylabel="angular frequency (rad/s)")
    ax.figure.colorbar(curves[0], ax=ax, label=parameter_label(locus.model, locus.parameter))
    _mark_ends(locus, ax, chosen)
    return curves


def _mark_ends(locus: Any, ax: Axes, modes: list[int]) -> None:
    known = np.flatnonzero(np.isfinite(locus.values[:, modes]).all(axis=1))
    for row, marker in (known[0], "o"), (known[-1], "x"):
        ends, name = locus.values[row, modes], parameter_value(locus.model, locus.parameter, locus.at[row])
        ax.plot(ends.real, ends.imag, marker, color=BLACK, markersize=5, zorder=3, label=name)
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)


def _coloured(locus: Any, ax: Axes, mode: int) -> LineCollection:
    points = np.column_stack([locus.values[:, mode].real, locus.values[:, mode].imag])
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    known = np.isfinite(pieces).all(axis=(1, 2))
    curve = LineCollection(list(pieces[known]), cmap=COLOURS, linewidth=2.0, capstyle="round")
    curve.set_array(0.5 * (locus.at[:-1] + locus.at[1:])[known])
    curve.set_clim(float(locus.at.min()), float(locus.at.max()))
    ax.add_collection(curve)
    return curve
