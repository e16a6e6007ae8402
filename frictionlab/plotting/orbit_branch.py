"""A branch of closed orbits against its parameter: stable solid, unstable dashed."""

from __future__ import annotations

from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .figure import axes_or_new
from .legends import legend_beside
from .palette import BLACK, BLUE, DASHED, GREEN, ORANGE, PURPLE, SKY, VERMILLION, label, unit
from .parameters import parameter_label

SPECIAL = {
    "fold": (VERMILLION, "o"),
    "period doubling": (ORANGE, "s"),
    "Neimark-Sacker": (PURPLE, "D"),
    "grazing": (GREEN, "^"),
    "mode change": (SKY, "v"),
    "Hopf": (BLACK, "*"),
}


def plot_orbit_branch(branch: Any, ax: Axes | None = None, *, name: str | None = None) -> list[Line2D]:
    """Draw the largest value of a state along each orbit, or the period, against the parameter.

    Parameters
    ----------
    branch : OrbitBranch
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The state, e.g. "x1"; None draws the period.

    Returns
    -------
    list of Line2D
        The stretches of equal stability along the branch, then the special points of each kind.

    Raises
    ------
    ValueError
        For an unknown state.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> branch = fl.continue_orbit(fl.periodic_orbit(model, fl.simulate(model, 30.0)), "mu_k", (1.3, 1.5))
    >>> [line.get_label() for line in plot_orbit_branch(branch, name="x1")]
    ['stable']
    """
    _check(branch, name)
    ax = axes_or_new(ax)
    heights, lines = np.array([_height(orbit, name) for orbit in branch.orbits]), []
    for stable, part in _stretches(branch.stable):
        style: dict[str, Any] = {"linestyle": "-" if stable else DASHED, "linewidth": 1.4, "color": BLUE}
        lines += ax.plot(branch.values[part], heights[part], **style)
        lines[-1].set_label("stable" if stable else "unstable")
    for kind in dict.fromkeys(special.kind for special in branch.special):
        chosen = [special for special in branch.special if special.kind == kind]
        at = [special.value for special in chosen], [_height(special.orbit, name) for special in chosen]
        colour, marker = SPECIAL[kind]
        lines += ax.plot(*at, marker, color=colour, label=kind)
    text = "period (s)" if name is None else f"largest {label(name)} ({unit(name)})"
    ax.set(xlabel=parameter_label(branch.orbits[0].model, branch.parameter), ylabel=text)
    legend_beside(ax, list({str(line.get_label()): line for line in lines}.values()))
    return lines


def _check(branch: Any, name: str | None) -> None:
    names = branch.orbits[0].trajectory.names
    if name is not None and name not in names:
        raise ValueError(f"name must be one of {', '.join(names)}, or None for the period, got {name!r}")


def _height(orbit: Any, name: str | None) -> float:
    return orbit.period if name is None else float(orbit.trajectory[name].max())


def _stretches(stable: np.ndarray) -> list[tuple[bool, slice]]:
    """Each stretch of equal stability, with the first orbit of the next, so that the line has no gaps."""
    found, start = [], 0
    for value, group in groupby(stable.tolist()):
        count = len(list(group))
        found.append((value, slice(start, start + count + 1)))
        start += count
    return found
