"""The verification of a run: what it found, beside the limits of trust."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.analysis.verification.run_comparison import largest_sound_defect
from frictionlab.analysis.verification.verify import TRUSTED_DEVIATION
from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON

from .appearance import legible, marker_size
from .figure import axes_or_new, legend_beside
from .style import BLUE, VERMILLION


def plot_verification(found: Any, ax: Axes | None = None) -> list[Line2D]:
    """Draw the deviation from other runs, and the defect in each mode, beside the largest that are trusted.

    Parameters
    ----------
    found : Verification
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.

    Returns
    -------
    list of Line2D
        What was found, and the limits; what is below rounding stands there.  Defects of methods without a
        tolerance have no limit.

    Examples
    --------
    >>> import frictionlab as fl
    >>> found = fl.verify(fl.SliderOnBelt(mu_k=1.4).without("geometry"), 0.5)
    >>> [line.get_label() for line in plot_verification(found)]
    ['found', 'largest trusted']
    """
    ax = axes_or_new(ax)
    tol = found.run.description["method"].get("tol")
    sound = np.nan if tol is None else largest_sound_defect(tol)
    rows = {"deviation from other runs": (found.error, TRUSTED_DEVIATION)}
    rows |= {f"defect in mode {mode}": (size, sound) for mode, size in found.defect.items()}
    sizes, limits = np.array(list(rows.values())).T
    places = np.arange(len(rows))
    lines = ax.plot(np.maximum(sizes, MACHINE_EPSILON), places, "o", color=legible(BLUE, ax), label="found")
    limit: dict[str, Any] = {"markersize": marker_size(16.0), "markeredgewidth": 2.0}
    limit["color"] = legible(VERMILLION, ax)
    lines += ax.plot(limits, places, "|", label="largest trusted", **limit)
    ax.set_yticks(places, list(rows))
    ax.set(
        xscale="log", xlabel="share of the motion's size", ylim=(len(rows) - 0.5, -0.5), title=_title(found)
    )
    ax.grid(axis="y", linewidth=0.5)
    legend_beside(ax)
    return lines


def _title(found: Any) -> str:
    trust = f"To be trusted up to t = {found.until:.4g} s" if found.ok else "Not to be trusted"
    return f"{trust}; the events {'agree' if found.events_agree else 'differ'}"
