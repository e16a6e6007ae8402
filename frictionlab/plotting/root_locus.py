"""An equilibrium, as the model's mechanism displaced to it or as bars; its eigenvalues against a parameter,
the root locus, or in the plane of growth rate and frequency; and frequency responses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from frictionlab.models import Model
from frictionlab.plotting.animation.parts import FORCES, parts
from frictionlab.plotting.appearance import (
    BLUE,
    GREY,
    MODE_COLOURS,
    ink,
    legible,
    line_style,
    line_width,
    marker_size,
    pen,
)
from frictionlab.plotting.figure import RunAxes, axes_or_new, legend_beside, new_figure, restyle, set_title
from frictionlab.plotting.labels import (
    coordinate_axis_label,
    parameter_label,
    parameter_value_text,
    secondary_axis_angles,
    state_label,
    state_with_unit,
)
from frictionlab.plotting.time_histories import Array
from frictionlab.presentation import unit_of_state
from frictionlab.stability.equilibrium_points.equilibria import contact_forces
from frictionlab.validation import abbreviate

if TYPE_CHECKING:
    from frictionlab.stability.eigenproblems.eigenvalues import Eigenvalues
    from frictionlab.stability.eigenproblems.linear_system import FrequencyResponse, LinearSystem
    from frictionlab.stability.eigenproblems.root_locus import RootLocus
    from frictionlab.stability.equilibrium_points.equilibria import Equilibrium

GROWING_LINE_WIDTH = 3.2
GROWING_LABEL = "heavy: the mode grows"
LOCUS_COLOUR_MAP = "viridis"


def plot_equilibrium(equilibrium: Equilibrium, ax: Axes | None = None) -> Sequence[Artist]:
    """Draw the mechanism at an equilibrium, with the contact forces on the body; for an automaton, or a model
    without a mechanism, the displacements as bars.

    Parameters
    ----------
    equilibrium : Equilibrium
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
    'displacements × 10, angles × 1'
    """
    ax = axes_or_new(ax)
    mechanism = equilibrium.model.mechanism if isinstance(equilibrium.model, Model) else None
    if mechanism is None:
        return _draw_bars(equilibrium, ax)
    picture = parts(_EquilibriumFrames(equilibrium), mechanism, np.zeros(1))
    artists = picture.move(picture.draw(ax), 0, MODE_COLOURS["slip"])
    ax.set(xlabel=picture.note)
    set_title(ax, "Equilibrium")
    acting = contact_forces(equilibrium).items()
    forces = {f"${symbol}$ = {size:.4g} {unit}": FORCES[name] for name, (symbol, size, unit) in acting}
    legend_beside(ax, replace(picture, forces=forces).handles(ax))
    return artists


@dataclass(frozen=True, eq=False)
class _EquilibriumFrames:
    """Stands in for a run that slips at an equilibrium: what a picture asks of a run."""

    equilibrium: Equilibrium

    def modes_at(self, t: Array) -> np.ndarray:
        """Slip at all times."""
        return np.full(len(t), "slip")

    @property
    def automaton(self) -> Any:
        """A stand-in with all that a picture reads of an automaton."""
        return SimpleNamespace(values=self.equilibrium.model.parameters, shown_state=self.names[0])

    @property
    def source(self) -> Any:
        """The model."""
        return self.equilibrium.model

    @property
    def names(self) -> tuple[str, ...]:
        return (*self.equilibrium.names, *(f"{name}'" for name in self.equilibrium.names))

    def __call__(self, t: Array) -> Array:
        return np.tile(self.equilibrium.state[: len(self.names)], (len(t), 1))

    def output(self, name: str, t: Array) -> Array:
        """A force or the penetration; NaN where the equilibrium does not have it."""
        return np.full(len(t), getattr(self.equilibrium, name, np.nan))


def _draw_bars(equilibrium: Equilibrium, ax: Axes) -> Sequence[Artist]:
    has_units = bool(unit_of_state(equilibrium.model, equilibrium.names[0]))
    mixed = has_units and bool(secondary_axis_angles(equilibrium.names))
    model = equilibrium.model if mixed else None
    bars = ax.bar(
        [state_with_unit(model, name) for name in equilibrium.names],
        equilibrium.q,
        color=legible(BLUE, ax),
    )
    ax.bar_label(bars, fmt="%.4g", padding=2)
    ax.axhline(0.0, clip_on=False, **pen(GREY, 0.8, ax))
    label = coordinate_axis_label(equilibrium.names) if has_units else "state"
    ax.set(ylabel=f"{label}, angle (rad)" if mixed else label)
    set_title(ax, "Equilibrium")
    ax.margins(y=0.12)
    return list(bars)


def plot_frequencies(
    locus: RootLocus,
    ax: Axes | None = None,
    *,
    modes: Sequence[int] | None = None,
    label: str | None = None,
    legend: bool = True,
    **line: Any,
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
        One label for all lines, for several loci in one panel; None labels them mode 0, mode 1, ...
    legend : bool
        Whether to put a legend beside the panel.
    **line
        Properties of matplotlib's Line2D for all lines: color, linestyle, alpha ...

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
    lines = _draw_modes(locus, ax, locus.frequencies, modes, label, line)
    return _label_locus_axes(locus, ax, lines, "frequency (Hz)", legend)


def plot_growth_rates(
    locus: RootLocus,
    ax: Axes | None = None,
    *,
    modes: Sequence[int] | None = None,
    label: str | None = None,
    legend: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw the growth rates of the modes against the parameter, with the line of zero growth.

    Parameters, returned artists (1/s) and errors are those of :func:`plot_frequencies`.
    """
    ax = axes_or_new(ax)
    lines = _draw_modes(locus, ax, locus.growth_rates, modes, label, line)
    ax.axhline(0.0, zorder=1, **pen(GREY, 0.8, ax))
    return _label_locus_axes(locus, ax, lines, "growth rate (1/s)", legend)


def select_modes(locus: RootLocus, modes: Sequence[int] | None) -> list[int]:
    """The columns to draw, checked; all where none are named."""
    count = locus.values.shape[1]
    selection = list(range(count)) if modes is None else [int(mode) for mode in modes]
    if not selection or not all(0 <= mode < count for mode in selection):
        raise ValueError(
            f"modes must be numbers from 0 to {count - 1}, got {abbreviate(modes)}: leave it out for all"
        )
    return selection


def _draw_modes(
    locus: RootLocus,
    ax: Axes,
    values: Array,
    modes: Sequence[int] | None,
    label: str | None,
    properties: Mapping[str, Any],
) -> list[Line2D]:
    selection = select_modes(locus, modes)
    lines, heavy = [], []
    for i, mode in enumerate(selection):
        style = line_style(mode, ax)
        name = f"mode {mode}" if label is None else (label if i == 0 else f"_{label}")
        lines += ax.plot(locus.at, values[:, mode], label=name, **style)
        growing = np.where(locus.growth_rates[:, mode] > 0, values[:, mode], np.nan)
        if np.isfinite(growing).any():
            style |= {"linewidth": line_width(GROWING_LINE_WIDTH)}
            heavy += ax.plot(locus.at, growing, label="_grows", **style)
    thin = {name: value for name, value in properties.items() if name not in ("linewidth", "lw")}
    return restyle(lines, properties) + restyle(heavy, thin)


def _label_locus_axes(
    locus: RootLocus, ax: Axes, lines: list[Line2D], ylabel: str, legend: bool
) -> list[Line2D]:
    ax.set(xlabel=parameter_label(locus.model, locus.parameter), ylabel=ylabel)
    ax.margins(x=0)
    if legend:
        heavy = (
            [growing_legend_handle(ax)]
            if any(line.get_linewidth() == line_width(GROWING_LINE_WIDTH) for line in ax.lines)
            else []
        )
        legend_beside(ax, ax.get_legend_handles_labels()[0] + heavy)
    return lines


def growing_legend_handle(ax: Axes | None = None) -> Line2D:
    """The legend entry of heavy lines."""
    return Line2D([], [], label=GROWING_LABEL, **pen(GREY, GROWING_LINE_WIDTH, ax))


def plot_root_locus(
    locus: RootLocus, ax: Axes | None = None, *, modes: Sequence[int] | None = None
) -> list[LineCollection]:
    """Draw eigenvalues, frequency against growth rate, coloured along the parameter, from dots to crosses.

    Of a conjugate pair the one in the upper half-plane is drawn.  To the right of the imaginary axis a mode
    grows.

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
    selection = select_modes(locus, modes)
    ax.axvline(0.0, zorder=1, **pen(GREY, 0.8, ax))
    curves = [_draw_coloured_curve(locus, ax, mode) for mode in selection]
    ax.autoscale_view()
    ax.set(xlabel="growth rate (1/s)", ylabel="frequency (Hz)")
    ax.figure.colorbar(curves[0], ax=ax, label=parameter_label(locus.model, locus.parameter))
    _mark_end_values(locus, ax, selection)
    return curves


def plot_eigenvalues(eigenvalues: Eigenvalues, ax: Axes | None = None, **line: Any) -> list[Line2D]:
    """Draw eigenvalues: frequency against growth rate; to the right of the imaginary axis a mode grows.

    Of a conjugate pair the one in the upper half-plane is drawn.

    Parameters
    ----------
    eigenvalues : Eigenvalues
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        The points of modes that do not grow, then of those that do; either may be missing.
    """
    ax = axes_or_new(ax)
    ax.axvline(0.0, zorder=1, **pen(GREY, 0.8, ax))
    upper = eigenvalues.values[eigenvalues.values.imag >= 0]
    lines = []
    for group, marker, label in (upper.real <= 0, "o", "decays or lasts"), (upper.real > 0, "^", "grows"):
        if group.any():
            frequencies = upper.imag[group] / (2 * np.pi)
            lines += ax.plot(upper.real[group], frequencies, marker, color=ink(ax), label=label)
    ax.set(xlabel="growth rate (1/s)", ylabel="frequency (Hz)")
    legend_beside(ax, lines)
    return restyle(lines, line)


def _mark_end_values(locus: RootLocus, ax: Axes, modes: list[int]) -> None:
    finite = np.flatnonzero(np.isfinite(locus.values[:, modes]).any(axis=1))
    for row, marker in (finite[0], "o"), (finite[-1], "x"):
        ends, name = (
            locus.values[row, modes],
            parameter_value_text(locus.model, locus.parameter, float(locus.at[row])),
        )
        ax.plot(
            ends.real,
            ends.imag / (2 * np.pi),
            marker,
            color=ink(ax),
            markersize=marker_size(5.0),
            zorder=3,
            label=name,
        )
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)


def _draw_coloured_curve(locus: RootLocus, ax: Axes, mode: int) -> LineCollection:
    points = np.column_stack([locus.values[:, mode].real, locus.values[:, mode].imag / (2 * np.pi)])
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    finite = np.isfinite(pieces).all(axis=(1, 2))
    curve = LineCollection(
        list(pieces[finite]), cmap=LOCUS_COLOUR_MAP, linewidth=line_width(2.0), capstyle="round"
    )
    curve.set_array(0.5 * (locus.at[:-1] + locus.at[1:])[finite])
    curve.set_clim(float(locus.at.min()), float(locus.at.max()))
    ax.add_collection(curve)
    return curve


def plot_frequency_response(
    response: FrequencyResponse,
    ax: Axes | None = None,
    *,
    output: str | None = None,
    input: str | None = None,
    **line: Any,
) -> list[Axes]:
    """Draw gain and phase of a frequency response.

    Parameters
    ----------
    response : FrequencyResponse
    ax : Axes or None
        Here only the gain is drawn; None makes a new figure with the gain above the phase.
    output, input : str or None
        Names; None draws all outputs, for the first input.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Axes

    Raises
    ------
    ValueError
        For a name that the system does not have.

    Examples
    --------
    >>> import frictionlab as fl
    >>> response = fl.linearize(fl.SliderOnBelt()).frequency_response([5.0, 10.0, 15.0])
    >>> [axes.get_ylabel() for axes in plot_frequency_response(response, output="y1", input="y1")]
    ['gain of $y_{1}$ (m/N)', 'phase (degrees)']
    """
    system = response.system
    source = system.inputs[0] if input is None else input
    outputs = system.outputs if output is None else (output,)
    curves = {name: response.response(name, source) for name in outputs}
    angles_beside = secondary_axis_angles(outputs)
    gain, *below = _gain_and_phase_axes() if ax is None else [axes_or_new(ax)]
    for i, (name, values) in enumerate(curves.items()):
        style = line_style(i, gain, dashed=name in angles_beside)
        restyle(gain.plot(response.frequencies, np.abs(values), label=_label(system, name), **style), line)
        for phase in below:
            angles = np.degrees(np.unwrap(np.angle(values)))
            restyle(phase.plot(response.frequencies, angles, **style), line)
    units = ", ".join(dict.fromkeys(filter(None, (system.gain_unit(name, source) for name in outputs))))
    what = f"gain of {_label(system, outputs[0])}" if len(outputs) == 1 else "gain"
    gain.set(yscale="log", ylabel=f"{what} ({units})" if units else what)
    kind = "a force along " if source in system.states else ""
    set_title(gain, f"Response to {kind}{_label(system, source)}")
    for phase in below:
        phase.set_ylabel("phase (degrees)")
    [gain, *below][-1].set_xlabel("frequency (Hz)")
    gain.margins(x=0)
    if len(outputs) > 1:
        legend_beside(gain)
    return [gain, *below]


def _label(system: LinearSystem, name: str) -> str:
    """A state as a symbol, an output in words."""
    return state_label(name) if name in system.states else name.replace("_", " ")


def _gain_and_phase_axes() -> list[Axes]:
    upper, lower = new_figure(7.0, 5.0).subplots(2, 1, sharex=True, subplot_kw={"axes_class": RunAxes})
    return [upper, lower]
