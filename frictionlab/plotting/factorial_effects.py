"""Effects of the switches of an ablation, and the lattice of its scenes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from .appearance import background, font_size, ink, legible, pen
from .figure import axes_or_new
from .style import BLUE, GREY, ORANGE, VERMILLION

MAX_BARS = 15  # effects that are drawn: the largest


def plot_effects(effects: Any, ax: Axes | None = None, *, condition: int = 0) -> list[Artist]:
    """Draw main effects, interactions and Shapley values as bars with their standard errors.

    Parameters
    ----------
    effects : Effects
    ax : Axes or None
        None draws into a new figure.
    condition : int
        Which of several values of the parameters.

    Returns
    -------
    list of Artist
        A container of bars for Shapley values, then one for effects.
    """
    ax = axes_or_new(ax)
    values, errors = effects.values[:, condition], effects.errors[:, condition]
    kept = np.argsort(-np.abs(np.nan_to_num(values)), kind="stable")[:MAX_BARS]
    groups = [
        (
            effects.switches,
            effects.shapley[:, condition],
            effects.shapley_errors[:, condition],
            BLUE,
            "Shapley",
        ),
        ([effects.terms[i] for i in kept], values[kept], errors[kept], ORANGE, "effect"),
    ]
    drawn, labels = [], []
    for names, sizes, spreads, colour, label in groups:
        places = np.arange(len(labels), len(labels) + len(names))
        bars = ax.barh(places, np.nan_to_num(sizes), color=legible(colour, ax), label=label)
        known = np.isfinite(spreads)
        if known.any():
            ax.errorbar(
                sizes[known],
                places[known],
                xerr=spreads[known],
                fmt="none",
                capsize=3,
                **pen(ink(ax), 1.0, ax),
            )
        labels += [f"{name} ({label})" for name in names]
        drawn.append(bars)
    ax.set_yticks(range(len(labels)), labels)
    ax.invert_yaxis()
    ax.axvline(0.0, **pen(GREY, 0.8, ax))
    ax.set_xlabel(f"change of {effects.quantity}")
    return drawn


def plot_scene_lattice(
    ablation: Any, ax: Axes | None = None, *, quantity: str | None = None, condition: int = 0
) -> list[Artist]:
    """Draw the lattice of scenes: each at the value of a quantity, one row for each number of nonlinearities.

    Two scenes that differ in one nonlinearity are joined.  Without interactions the lines of one switch are
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
        Which of several values of the parameters.

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


def _mark_scenes(ablation: Any, values: Any, heights: Any, on: Any, ax: Axes) -> None:
    """A point for each scene; the names of what it has, of scenes at the same place together."""
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
