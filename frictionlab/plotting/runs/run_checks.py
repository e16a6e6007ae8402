"""Checks of a run: its energies and the works that changed them, the balance of
:func:`frictionlab.energy_audit`; and what its verification found, beside the limits of trust.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.analysis.verification.run_comparison import largest_sound_defect
from frictionlab.analysis.verification.verify import TRUSTED_DEVIATION
from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON
from frictionlab.plotting.appearance import legible, marker_size, pen
from frictionlab.plotting.figure import axes_or_new, legend_beside, set_long_title
from frictionlab.plotting.runs.time_histories import Array
from frictionlab.plotting.style import BLACK, BLUE, DASHED, GREEN, ORANGE, PURPLE, SKY, VERMILLION, YELLOW

ENERGIES = {"kinetic": BLUE, "springs": GREEN, "contact": VERMILLION, "preload": ORANGE}
SPARE = (SKY, PURPLE, GREEN, ORANGE, YELLOW)  # for names that are a model's own
WORKS = {
    "belt drive": BLUE,
    "friction": VERMILLION,
    "dampers": GREEN,
    "impacts": ORANGE,
    "moving load": PURPLE,
}


def plot_energies(audit: Any, ax: Axes | None = None) -> list[Line2D]:
    """Draw every energy of an audit against time, and their sum, dashed.

    Parameters
    ----------
    audit : EnergyAudit
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.

    Returns
    -------
    list of Line2D
        One for every energy, then the sum.

    Examples
    --------
    >>> import frictionlab as fl
    >>> audit = fl.energy_audit(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.2))
    >>> [line.get_label() for line in plot_energies(audit)]
    ['kinetic', 'springs', 'preload', 'contact', 'sum']
    """
    return _draw_contributions(audit, ax, audit.energies, ENERGIES, audit.total, "energy (J)", "Energies")


def plot_works(audit: Any, ax: Axes | None = None) -> list[Line2D]:
    """Draw the work of every contribution from 0 to t, and their sum, dashed: the energy that the system
    gained.

    Parameters
    ----------
    audit : EnergyAudit
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.

    Returns
    -------
    list of Line2D
        One for every contribution, then the sum.

    Examples
    --------
    >>> import frictionlab as fl
    >>> audit = fl.energy_audit(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.2))
    >>> [line.get_label() for line in plot_works(audit)]
    ['belt drive', 'friction', 'dampers', 'impacts', 'moving load', 'sum']
    """
    title = f"Work since the start; the balance misses {audit.error:.1g} of the energy turned over"
    return _draw_contributions(
        audit, ax, audit.works, WORKS, audit.total - audit.total[0], "work from 0 to $t$ (J)", title
    )


def _draw_contributions(
    audit: Any,
    ax: Axes | None,
    parts: Mapping[str, Array],
    colours: Mapping[str, str],
    total: Array,
    ylabel: str,
    title: str,
) -> list[Line2D]:
    ax = axes_or_new(ax, (8.0, 4.0))
    lines, spare = (
        [],
        cycle(colour for colour in SPARE if colour not in {colours.get(name) for name in parts}),
    )
    for name, values in parts.items():
        colour = colours.get(name) or next(spare)
        lines += ax.plot(audit.t, values, label=name, **pen(colour, ax=ax))
    lines += ax.plot(audit.t, total, linestyle=DASHED, label="sum", **pen(BLACK, ax=ax))
    ax.set(xlabel="time (s)", ylabel=ylabel)
    set_long_title(ax, title)
    ax.margins(x=0)
    legend_beside(ax)
    return lines


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
