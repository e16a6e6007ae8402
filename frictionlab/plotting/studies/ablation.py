"""An ablation: small panels for each scene, bars of numbers, or the curves of all scenes in one frame;
effects of its switches, and the lattice of its scenes.
"""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from frictionlab.analysis.motion_scales import Spectrum
from frictionlab.analysis.steady_state.steady_state import SteadyState
from frictionlab.analysis.sweeps.bifurcation import Bifurcation
from frictionlab.analysis.sweeps.factorial_design import all_of
from frictionlab.plotting.appearance import (
    BLUE,
    GREY,
    ORANGE,
    VERMILLION,
    add_halo_to_errors,
    background,
    crowding,
    font_size,
    ink,
    legible,
    line_style,
    pen,
)
from frictionlab.plotting.figure import RunAxes, axes_or_new, legend_beside, new_figure, wrap_label
from frictionlab.plotting.labels import parameter_label
from frictionlab.plotting.overview import plot_amplitudes
from frictionlab.plotting.studies.state_space import plot_steady_state
from frictionlab.plotting.studies.sweeps import LOG_SCALE_RATIO, plot_bifurcation

if TYPE_CHECKING:
    from frictionlab.analysis.sweeps.ablation import Ablation
    from frictionlab.analysis.sweeps.factorial_design import Effects

MAX_BARS = 15  # only so many effects are drawn, the largest
RUN_AXES = {"axes_class": RunAxes}
COLUMNS = 4  # panels side by side
LABEL_LENGTH = 34  # letters that fit on a line below a small panel
NEGATIVE_MARGIN = 0.3  # where bars go to the left: their numbers must not reach the names
THICKEST = 3.0  # width of the first curve, in widths of a line
THINNER = 0.8  # width of a curve as a share of the one below it, so that equal curves are all seen
PANEL_SHARE = 0.7  # of its cell that a panel takes, the rest for labels and title


def plot_effects(effects: Effects, ax: Axes | None = None, *, condition: int = 0) -> list[Artist]:
    """Draw main effects, interactions and Shapley values as bars with their standard errors.

    Parameters
    ----------
    effects : Effects
    ax : Axes or None
        None draws into a new figure.
    condition : int
        Index of the condition, where the study has several values of its parameters.

    Returns
    -------
    list of Artist
        A container of bars for Shapley values, then one for effects.
    """
    ax = axes_or_new(ax)
    values, errors = effects.values[:, condition], effects.errors[:, condition]
    largest = np.argsort(-np.abs(np.nan_to_num(values)), kind="stable")[:MAX_BARS]
    groups = [
        (
            effects.switches,
            effects.shapley[:, condition],
            effects.shapley_errors[:, condition],
            BLUE,
            "Shapley",
        ),
        ([effects.terms[i] for i in largest], values[largest], errors[largest], ORANGE, "effect"),
    ]
    artists, labels = [], []
    for names, sizes, spreads, colour, label in groups:
        places = np.arange(len(labels), len(labels) + len(names))
        bars = ax.barh(places, np.nan_to_num(sizes), color=legible(colour, ax), label=label)
        finite = np.isfinite(spreads)
        if finite.any():
            how: dict[str, Any] = {"fmt": "none", "capsize": 3, **pen(ink(ax), 1.0, ax)}
            add_halo_to_errors(ax.errorbar(sizes[finite], places[finite], xerr=spreads[finite], **how), ax)
        labels += [f"{name} ({label})" for name in names]
        artists.append(bars)
    ax.set_yticks(range(len(labels)), labels)
    ax.invert_yaxis()
    ax.axvline(0.0, **pen(GREY, 0.8, ax))
    ax.set_xlabel(f"change of {effects.quantity}")
    return artists


def plot_scene_lattice(
    ablation: Ablation, ax: Axes | None = None, *, quantity: str | None = None, condition: int = 0
) -> list[Artist]:
    """Draw the lattice of scenes: each at the value of a quantity, in the row of its number of switches on.

    Two scenes that differ in one switch are joined.  Without interactions the lines of one switch are
    parallel.

    Parameters
    ----------
    ablation : Ablation
        Of switches with two levels each.
    ax : Axes or None
        None draws into a new figure.
    quantity : str or None
        One of ``ablation.quantities``.
    condition : int
        Index of the condition, where the study has several values of its parameters.

    Returns
    -------
    list of Artist
        A line for each pair of neighbours.

    Raises
    ------
    ValueError
        For switches with more levels.
    """
    if any(len(switch.levels) != 2 for switch in ablation.factors):
        raise ValueError(
            f"switches must have two levels each to make a lattice, got "
            f"{[len(switch.levels) for switch in ablation.factors]}: draw effects(quantity).plot()"
        )
    ax = axes_or_new(ax)
    values = ablation.numbers(quantity)[:, condition].mean(axis=-1)
    ends = tuple(switch.end for switch in ablation.factors)
    on = np.array([[level == end for level, end in zip(scene, ends)] for scene in ablation.scenes])
    heights = on.sum(axis=1)
    colours = (BLUE, ORANGE, VERMILLION, GREY)
    lines: list[Artist] = []
    for k, switch in enumerate(ablation.factors):
        for i in np.flatnonzero(~on[:, k]):
            (j,) = [j for j in np.flatnonzero(on[:, k]) if (np.delete(on[j], k) == np.delete(on[i], k)).all()]
            line = ax.plot(
                values[[i, j]],
                heights[[i, j]],
                label=switch.name if len(lines) == k * (len(on) // 2) else None,
                **pen(colours[k % len(colours)], 1.5, ax),
            )
            lines += line
    _mark_scenes(ablation, values, heights, on, ax)
    ax.set_xlabel(quantity or ablation.quantities[0])
    ax.set_ylabel("switches on")
    ax.set_yticks(range(len(ends) + 1))
    ax.margins(0.15)
    ax.legend(frameon=False, fontsize=font_size(8.0), title="switched on")
    return lines


def _mark_scenes(ablation: Ablation, values: Any, heights: Any, on: Any, ax: Axes) -> None:
    """Draw a point for each scene, with the names of its switches on; scenes in one place share a label."""
    ax.plot(values, heights, "o", color=ink(ax), markersize=4)
    labels: dict[tuple[int, str], list[str]] = {}
    for value, height, has in sorted(zip(values, heights, map(tuple, on)), key=lambda scene: scene[1::-1]):
        if np.isfinite(value):
            name = "+".join(s for s, present in zip(ablation.switches, has) if present) or "none"
            labels.setdefault((int(height), f"{value:.6g}"), []).append(name)
    for rank, ((height, value), names) in enumerate(labels.items()):
        ax.annotate(
            "\n".join(names),
            (float(value), height),
            xytext=(0, 7 if rank % 2 else -7),
            textcoords="offset points",
            ha="center",
            va="bottom" if rank % 2 else "top",
            fontsize=font_size(7.0),
            bbox={"facecolor": background(ax), "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
        )


def plot_ablation(
    ablation: Ablation, ax: Axes | None = None, *, name: str | None = None, quantity: str | None = None
) -> list[Axes]:
    """Draw what a study gave for each scene: a small panel for each, bars, or curves over a parameter.

    Over one parameter the curves of all scenes are in one frame, as in Figs. 13 to 18 of the paper.  With
    several initial states bars and curves show means.

    Parameters
    ----------
    ablation : Ablation
        Its results are all SteadyState (drawn as phase planes), Bifurcation (section points) or Spectrum, or
        all numbers (None: no such number).
    ax : Axes or None
        Axes for the bars or curves, or whose place all panels take; None draws into a new figure.
    name : str or None
        The coordinate to draw; None takes the first.
    quantity : str or None
        The one of ``ablation.quantities`` that bars and curves show; None where there is only one.

    Returns
    -------
    list of Axes
        One for each scene, with a scale of its own, or one of bars or curves; figure: ``axes[0].figure``.

    Raises
    ------
    TypeError
        For results that are none of these.
    ValueError
        For an unknown quantity, if none of several is chosen, or for several parameters.
    """
    if ablation.conditions is not None or quantity is not None or len(ablation.studies) > 1:
        return [_draw_quantity(ablation, axes_or_new(ax), quantity)]
    results = [result for result in ablation.results if result is not None]
    if all(isinstance(result, Real) for result in results):
        values = np.array([np.nan if result is None else result for result in ablation.results], dtype=float)
        return [_bars(ablation, values, axes_or_new(ax))]
    draw = _panel_for(results)
    count = len(ablation.results)
    columns = min(COLUMNS, count)
    rows = -(-count // columns)
    panels = _panels(rows, columns, ax)
    for ax, title, result in zip(panels, _scene_titles(ablation), ablation.results, strict=False):
        if result is None:
            ax.text(0.5, 0.5, "not done", ha="center", va="center", transform=ax.transAxes)
        else:
            draw(result, ax, name)
        ax.set_title(title + _motion_title(result), fontsize=font_size(9.0))
    _share_labels(panels)
    return panels


def _panels(rows: int, columns: int, ax: Axes | None) -> list[Axes]:
    """Axes in rows, in a new figure or in place of the axes given."""
    if ax is None:
        figure = new_figure(3.25 * columns, 3.0 * rows)
        return list(figure.subplots(rows, columns, squeeze=False, subplot_kw=RUN_AXES).ravel())
    ax.set_axis_off()
    width, height = 1.0 / columns, 1.0 / rows
    corners = [(column * width, 1.0 - (row + 1) * height) for row in range(rows) for column in range(columns)]
    return [ax.inset_axes((x, y, PANEL_SHARE * width, PANEL_SHARE * height)) for x, y in corners]


def _panel_for(results: Iterable[Any]) -> Any:
    kinds = {type(result) for result in results}
    panels = {SteadyState: _phase_plane, Bifurcation: _points, Spectrum: _spectrum}
    if len(kinds) != 1 or not kinds <= panels.keys():
        got = ", ".join(sorted(kind.__name__ for kind in kinds))
        raise TypeError(
            f"results must all be SteadyState, Bifurcation, Spectrum or numbers, got {got}: let the study "
            "return one of these"
        )
    return panels[kinds.pop()]


def _share_labels(panels: list[Axes]) -> None:
    """Keep labels at the outer panels only, and draw one legend for all."""
    for i, ax in enumerate(panels):
        ax.set_xlabel(wrap_label(ax.get_xlabel(), LABEL_LENGTH))
        ax.tick_params(labelsize=font_size(8.0))
        ax.locator_params(axis="x", nbins=4)
        if i < len(panels) - COLUMNS:
            ax.set_xlabel("")
        if i % COLUMNS:
            ax.set_ylabel("")
    handles = {str(text): h for ax in panels for h, text in zip(*ax.get_legend_handles_labels())}
    if handles:
        panels[0].figure.legend(handles=list(handles.values()), loc="outside right center", frameon=False)


def _phase_plane(result: Any, ax: Axes, name: str | None) -> None:
    plot_steady_state(result, ax, name=name)


def _points(result: Any, ax: Axes, name: str | None) -> None:
    plot_bifurcation(result, ax, name=name, legend=False)


def _spectrum(result: Any, ax: Axes, name: str | None) -> None:
    plot_amplitudes(result, ax)


def _draw_quantity(ablation: Ablation, ax: Axes, quantity: str | None) -> Axes:
    """Draw means over the initial states: curves over the parameter, or bars where there is none."""
    means = ablation.numbers(quantity).mean(axis=-1)
    over = {} if ablation.conditions is None else ablation.conditions.over
    if len(over) > 1:
        raise ValueError(
            f"an ablation must be over one parameter to be drawn, got {', '.join(over)}: draw parts of "
            "numbers(quantity)"
        )
    label = quantity or ablation.quantities[0]
    for name, values in over.items():
        for i, (title, curve) in enumerate(zip(_scene_titles(ablation), means, strict=True)):
            style: dict[str, Any] = {"marker": "."} | line_style(i, ax)
            style["linewidth"] *= THICKEST * THINNER**i
            ax.plot(values, curve, label=title, **style)
        ax.set_xlabel(parameter_label(ablation.models[0], name))
        ax.set_ylabel(label)
        legend_beside(ax)
        return ax
    _bars(ablation, means[:, 0], ax)
    ax.set_xlabel(label)
    return ax


def _scene_titles(ablation: Ablation) -> list[str]:
    """A short title for each scene."""
    if any(switch.changes is not None for switch in ablation.factors):
        return list(ablation.names)
    return [_scene_title(without, ablation.switches) for without in ablation.without]


def _scene_title(without: tuple[str, ...], switches: tuple[str, ...]) -> str:
    if not without:
        return all_of(len(switches)).replace("it", switches[0]) if switches else "all"
    left = [name for name in switches if name not in without]
    return f"only {left[0]}" if len(left) == 1 else f"without {', '.join(without)}" if left else "none"


def _motion_title(result: Any) -> str:
    kind = getattr(result, "kind", "")
    return f"\n{kind}" if isinstance(kind, str) and kind else ""


def _bars(ablation: Ablation, values: np.ndarray, ax: Axes) -> Axes:
    bars = ax.barh(range(len(values)), np.nan_to_num(values), color=BLUE)
    ax.bar_label(bars, ["" if np.isnan(v) else f"{v:.5g}" for v in values], padding=4)
    for i in np.flatnonzero(np.isnan(values)):
        ax.text(0.01, float(i), "none", va="center", transform=ax.get_yaxis_transform())
    ax.set_yticks(range(len(values)), _scene_titles(ablation))
    ax.invert_yaxis()
    numbers = values[~np.isnan(values)]
    if len(numbers) and numbers.min() > 0 and numbers.max() > LOG_SCALE_RATIO * numbers.min():
        ax.set_xscale("log")
    ax.axvline(0.0, **pen(GREY, 0.8, ax))
    ax.margins(x=(NEGATIVE_MARGIN if len(numbers) and numbers.min() < 0 else 0.15) * crowding())
    return ax
