"""The modes of a run: as intervals, and as shading behind a panel over time."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from .palette import mode_colours
from .windows import LAST, Array, Window, end_of, limits


def mode_intervals(run: Any) -> tuple[Array, list[str]]:
    """Edges (n + 1,) of the intervals of a run spent in one mode, and their names.

    Events that lead back into the same mode, such as the re-contacts of chatter, divide nothing.
    """
    events, end = run.events, end_of(run)
    if len(events) == 0:
        names = [name for name, seconds in run.time_in_mode.items() if seconds > 0]
        return (np.array([0.0, end]), names) if names else (np.array([0.0]), [])
    modes = np.append(events.source[:1], events.target)
    starts = np.append(0.0, events.t)
    # Of several events at one instant only the last mode lasts.
    lasting = np.append(starts[1:] > starts[:-1], end > starts[-1])
    modes, starts = modes[lasting], starts[lasting]
    new = np.append([True], modes[1:] != modes[:-1])[: len(modes)]
    return np.append(starts[new], end), modes[new].tolist()


def modes_at(run: Any, t: Array) -> np.ndarray:
    """Name of the mode at each time."""
    edges, names = mode_intervals(run)
    if not names:
        return np.full(len(t), "")
    return np.array(names)[np.clip(np.searchsorted(edges, t, side="right") - 1, 0, len(names) - 1)]


def shade_modes(run: Any, ax: Axes, window: Window = LAST) -> list[PolyCollection]:
    """Shade the intervals of every mode over the whole height of a panel over time.

    Parameters
    ----------
    run : Trajectory
    ax : Axes
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run.

    Returns
    -------
    list of PolyCollection
        One for every mode that occurs, labelled with its name.
    """
    start, stop = limits(run, window)
    edges, names = mode_intervals(run)
    colours = mode_colours(run.automaton.names)
    shades = []
    for mode, colour in colours.items():
        spans = _spans(edges, [name == mode for name in names], start, stop)
        if spans:
            options: dict[str, Any] = {"facecolors": colour, "alpha": 0.35, "linewidth": 0, "zorder": 0}
            across = ax.get_xaxis_transform()
            shades.append(ax.broken_barh(spans, (0, 1), transform=across, label=mode, **options))
    return shades


def _spans(edges: Array, chosen: list[bool], start: float, stop: float) -> list[tuple[float, float]]:
    """(start, length) of the chosen intervals, cut to the window."""
    left, right = np.maximum(edges[:-1], start), np.minimum(edges[1:], stop)
    inside = np.array(chosen, dtype=bool) & (right > left)
    return list(zip(left[inside].tolist(), (right - left)[inside].tolist(), strict=True))
