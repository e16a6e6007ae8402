"""Contact forces against time, with the modes below them."""

from __future__ import annotations

from typing import Any

from frictionlab.plotting.forces import force_outputs
from frictionlab.plotting.palette import label, line_style
from frictionlab.widgets.drawing import Curve, Drawing
from frictionlab.widgets.envelope import envelope

from .strip import mode_strip


def forces(result: Any) -> Drawing:
    """Normal and friction force, of a model without contact forces the rates."""
    found = force_outputs(result.run.automaton)
    what, curves = ("contact force (N)", _forces(result, found)) if found else ("rate", _rates(result))
    t = result.times()
    limits = float(t[0]), float(t[-1])
    return Drawing("time (s)", what, {**curves, **mode_strip(result)}, xlim=limits)


def _forces(result: Any, found: dict[str, tuple[str, str]]) -> dict[str, Curve]:
    t, curves = result.times(), {}
    for name, (text, colour) in found.items():
        x, y = envelope(t, result.run.output(name, t))
        curves[text.partition(" (")[0]] = Curve(x, y, {"color": colour})
    return curves


def _rates(result: Any) -> dict[str, Curve]:
    names = [f"{name}'" for name in result.model.coordinates]
    drawn = (envelope(result.times(), result.state(name)) for name in names)
    styles = (line_style(i, name) for i, name in enumerate(names))
    return {label(n): Curve(x, y, style) for n, (x, y), style in zip(names, drawn, styles)}
