"""An equilibrium: the model's mechanism displaced to it, or the displacements as bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.models import Model
from frictionlab.plotting.animation.animate import BeltPicture, picture_of
from frictionlab.plotting.appearance import legible, pen
from frictionlab.plotting.figure import axes_or_new, legend_beside
from frictionlab.plotting.runs.time_window import Array
from frictionlab.plotting.style import (
    BLACK,
    BLUE,
    GREY,
    MODE_COLOURS,
    VERMILLION,
    coordinate_axis_label,
    secondary_axis_angles,
    state_label,
)
from frictionlab.presentation import state_unit


def plot_equilibrium(found: Any, ax: Axes | None = None) -> Sequence[Artist]:
    """Draw the mechanism at an equilibrium, with the contact forces on the body; a model without one, or an
    automaton, has its displacements drawn as bars.

    Parameters
    ----------
    found : Equilibrium
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    sequence of Artist
        The moving parts of the mechanism, or the bars.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.equilibrium(fl.SliderOnBelt(mu_k=0.3)).plot().get_xlabel()
    'displacements × 2, tilt as it is'
    """
    ax = axes_or_new(ax)
    mechanism = found.model.mechanism if isinstance(found.model, Model) else None
    if mechanism is None:
        return _draw_bars(found, ax)
    picture = picture_of(_EquilibriumFrames(found), mechanism, np.zeros(1))
    drawn: Any = picture.draw(ax)
    artists = picture.move(drawn, 0, MODE_COLOURS["slip"])
    ax.set(xlabel=picture.note, title="Equilibrium")
    forces = _forces(found)
    if isinstance(picture, BeltPicture):
        forces["$F$"] = picture.preload, BLACK
    entries = {f"{name} = {size:.4g} N": colour for name, (size, colour) in forces.items()}
    legend_beside(ax, [Line2D([], [], label=text, **pen(c, 3.0, ax)) for text, c in entries.items()])
    return artists


@dataclass(frozen=True, eq=False)
class _EquilibriumFrames:
    """What a picture asks of a run, of one that slips in an equilibrium for a second."""

    events: ClassVar[tuple[Any, ...]] = ()
    time_in_mode: ClassVar[Mapping[str, float]] = {"slip": 1.0}
    raw: ClassVar[Any] = SimpleNamespace(t=1.0)

    found: Any

    @property
    def automaton(self) -> Any:
        """The model, of which a picture wants the parameters alone."""
        return self.found.model

    @property
    def names(self) -> tuple[str, ...]:
        return (*self.found.names, *(f"{name}'" for name in self.found.names))

    def __call__(self, t: Array) -> Array:
        return np.tile(np.append(self.found.q, np.zeros(len(self.found.q))), (len(t), 1))

    def output(self, name: str, t: Array) -> Array:
        """A force or the penetration; NaN where the equilibrium has none of that name."""
        return np.full(len(t), getattr(self.found, name, np.nan))


def _forces(found: Any) -> dict[str, tuple[float, str]]:
    """Size and colour of the contact forces that the equilibrium has, by their letters."""
    sizes = {"$F_N$": (found.normal_force, BLUE), "$F_T$": (found.friction_force, VERMILLION)}
    return {name: force for name, force in sizes.items() if np.isfinite(force[0])}


def _draw_bars(found: Any, ax: Axes) -> Sequence[Artist]:
    known = bool(found.model.coordinates)  # states of an automaton without coordinates may have any unit
    mixed = known and bool(secondary_axis_angles(found.names))
    units = [f" ({state_unit(name)})" if mixed else "" for name in found.names]
    bars = ax.bar(
        [state_label(name) + unit for name, unit in zip(found.names, units)], found.q, color=legible(BLUE, ax)
    )
    ax.bar_label(bars, fmt="%.4g", padding=2)
    ax.axhline(0.0, **pen(GREY, 0.8, ax))
    label = coordinate_axis_label(found.names) if known else "state"
    ax.set(ylabel=f"{label}, angle (rad)" if mixed else label, title="Equilibrium")
    ax.margins(y=0.12)
    return list(bars)
