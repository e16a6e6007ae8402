"""The panels of an explorer: those that have names, which the front end draws, and functions of one's own."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from inspect import signature
from typing import Any

from frictionlab.models.model import values_of
from frictionlab.pages.scene import PANELS, Shown
from frictionlab.plotting.figure import RunFigure
from frictionlab.validation import abbreviate, check_sequence, did_you_mean

from ..result import Result

Panel = Callable[..., Any]  # of a Result; returns a Drawing, or a picture as SVG


def select_panels(asked: Iterable[Any]) -> dict[str, Panel | None]:
    """Panels by name, None for those that the front end draws; those asked for may be names or functions of
    results, or of runs and axes; or one alone.

    Raises
    ------
    ValueError
        For an unknown name, something that is no function, or none at all.
    """
    if isinstance(asked, str) or callable(asked):
        asked = [asked]
    asked = check_sequence("panels", asked, f"take some of {', '.join(PANELS)}")
    chosen = {_panel_name(panel): None if isinstance(panel, str) else _of_result(panel) for panel in asked}
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


def _of_result(panel: Panel) -> Panel:
    """A panel as it is, or made of a function of a run and of matplotlib's axes."""
    try:
        required = [p for p in signature(panel).parameters.values() if p.default is p.empty]
    except (TypeError, ValueError):  # built in, without a signature
        return panel
    return partial(_drawn_on_axes, panel) if len(required) == 2 else panel


def _drawn_on_axes(panel: Panel, result: Result) -> bytes:
    figure, buffer = RunFigure(), io.BytesIO()
    panel(result.run, figure.subplots())
    figure.savefig(buffer, format="svg")
    return buffer.getvalue()


def apart_from(model: Shown, names: Iterable[str]) -> tuple[Any, ...]:
    """What a picture over these parameters depends on: a model's structure and its other values."""
    others = tuple(item for item in values_of(model).items() if item[0] not in names)
    return getattr(model, "structure_key", None), others  # an automaton keeps its structure


def needed_of(panels: Mapping[str, Panel | None]) -> frozenset[str]:
    """What the panels that the front end draws need of a result."""
    return frozenset(need for name, panel in panels.items() if panel is None for need in PANELS[name])
