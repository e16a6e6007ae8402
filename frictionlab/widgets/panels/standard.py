"""The panels of an explorer: those that have names, which the front end draws, and functions of one's own."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Mapping
from inspect import signature
from typing import Any

from frictionlab.pages.scene import PANELS
from frictionlab.plotting.figure import RunFigure
from frictionlab.validation import abbreviate, check_sequence, did_you_mean

from ..result import Result

Panel = Callable[..., Any]  # of a Result, returns a Drawing; or of a run and axes


def select_panels(asked: Iterable[Any]) -> dict[str, Panel | None]:
    """Panels by name, None for those that the front end draws; those asked for may be names or functions, or
    one name alone.

    Raises
    ------
    ValueError
        For an unknown name, something that is no function, or none at all.
    """
    if isinstance(asked, str) or callable(asked):
        asked = [asked]
    asked = check_sequence("panels", asked, f"take some of {', '.join(PANELS)}")
    chosen = {_panel_name(panel): None if isinstance(panel, str) else panel for panel in asked}
    if not chosen:
        raise ValueError(f"panels must hold at least one panel, got none: take some of {', '.join(PANELS)}")
    return chosen


def _panel_name(panel: Any) -> str:
    if isinstance(panel, str) and panel in PANELS:
        return panel
    if callable(panel):
        return getattr(panel, "__name__", type(panel).__name__)
    known = ", ".join(map(repr, PANELS))
    raise ValueError(
        f"panels must be functions or some of {known}, got {abbreviate(panel)}{did_you_mean(panel, PANELS)}"
    )


def draws_on_axes(panel: Panel) -> bool:
    """Whether a panel is a function of a run and of matplotlib's axes, rather than of a result."""
    try:
        required = [p for p in signature(panel).parameters.values() if p.default is p.empty]
    except (TypeError, ValueError):  # built in, without a signature
        return False
    return len(required) == 2


def drawn_on_axes(panel: Panel, result: Result) -> bytes:
    """What a function of a run and of axes draws, as SVG."""
    figure = RunFigure()
    panel(result.run, figure.subplots())
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg")
    return buffer.getvalue()


def needed_of(panels: Mapping[str, Panel | None]) -> frozenset[str]:
    """What the panels that the front end draws need of a result."""
    return frozenset(need for name, panel in panels.items() if panel is None for need in PANELS[name])
