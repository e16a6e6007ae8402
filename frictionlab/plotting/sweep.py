"""Results of a sweep over its grid: curves over one parameter, colours over two."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from .figure import axes_or_new, legend_beside
from .style import line_style, parameter_label


def plot_sweep(found: Any, ax: Axes | None = None, *, label: str | None = None) -> list[Artist]:
    """Draw numbers that a sweep gave: against its parameter, or as colours over two parameters.

    Parameters
    ----------
    found : Sweep
        Over one parameter, with a curve for each initial state; or over two, with one initial state or none.
        Its results are numbers, or None.
    ax : Axes or None
        None draws into a new figure.
    label : str or None
        What the numbers are, with their unit; None takes the name of the function.

    Returns
    -------
    list of Artist
        A line for each initial state, or one mesh of colours.

    Raises
    ------
    TypeError
        For results that are no numbers.
    ValueError
        For a grid of more than these dimensions.

    Examples
    --------
    >>> import frictionlab as fl
    >>> found = fl.sweep(fl.SliderOnBelt(), lambda m: fl.equilibrium(m).normal_force, {"F": [100, 200]})
    >>> found.plot(label="normal force (N)").get_xlabel()
    'preload on the slider $F$ (N)'
    """
    values, text = _numbers(found), found.function if label is None else label
    names, starts = list(found.over), found.labels() or [""]
    values = values.reshape(*(len(at) for at in found.over.values()), len(starts))
    if len(names) > 2 or (len(names) == 2 and len(starts) > 1):
        raise ValueError(
            f"a sweep must have one parameter, or two and one initial state, to be drawn, got "
            f"{', '.join(names)} and {len(starts)} states: draw parts of found.to_array()"
        )
    ax = axes_or_new(ax)
    ax.set_xlabel(parameter_label(found.model, names[0]))
    if len(names) == 1:
        return _draw_curves(found.over[names[0]], values, starts, text, ax)
    ax.set_ylabel(parameter_label(found.model, names[1]))
    mesh = ax.pcolormesh(*found.over.values(), values[..., 0].T, shading="nearest", rasterized=True)
    ax.figure.colorbar(mesh, ax=ax, label=text)
    return [mesh]


def _numbers(found: Any) -> np.ndarray:
    try:
        return found.to_array()
    except (TypeError, ValueError) as error:
        raise TypeError(
            f"results must be numbers to be drawn ({error}): let the function return a number"
        ) from error


def _draw_curves(at: np.ndarray, values: np.ndarray, starts: list[str], label: str, ax: Axes) -> list[Artist]:
    lines: list[Artist] = []
    for i, start in enumerate(starts):
        style: dict[str, Any] = {"marker": "."} | line_style(i, "", ax)
        lines += ax.plot(at, values[:, i], label=start or None, **style)
    ax.set_ylabel(label)
    if len(starts) > 1:
        legend_beside(ax)
    return lines
