"""What panels against time share."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from .shading import shade_modes
from .windows import window_text


def finish(run: Any, ax: Axes, span: tuple[float, float], shade: bool, what: str, ylabel: str) -> None:
    """Shade the modes, if wanted, and name the axes and what is drawn in which part of the run."""
    if shade:
        shade_modes(run, ax, span)
    ax.set(xlabel="time (s)", ylabel=ylabel, title=f"{what}, {window_text(run, *span)}")
    ax.margins(x=0)
