"""Legends where they cover no data."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes


def legend_beside(ax: Axes, handles: list[Any] | None = None) -> None:
    """A legend of everything labelled in `ax`, or of `handles`, to the right of it."""
    handles = ax.get_legend_handles_labels()[0] if handles is None else handles
    if handles:
        ax.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=9.0)
