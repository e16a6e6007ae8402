"""The energies of a run and the works that changed them: the balance of :func:`frictionlab.energy_audit`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.plotting.runs.time_window import Array

from .appearance import pen
from .figure import axes_or_new, legend_beside, set_long_title
from .style import BLACK, BLUE, DASHED, GREEN, ORANGE, PURPLE, SKY, VERMILLION, YELLOW

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
