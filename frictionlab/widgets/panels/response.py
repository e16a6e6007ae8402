"""Displacements against time, with the modes below them."""

from __future__ import annotations

from typing import Any

from frictionlab.plotting.palette import beside, is_angle, label, left_label, line_style
from frictionlab.widgets.drawing import Curve, Drawing
from frictionlab.widgets.envelope import envelope

from .strip import mode_strip


def response(result: Any) -> Drawing:
    """All coordinates; an angle is dashed and belongs to the axis on the right, where there are lengths."""
    names = result.run.names[: result.run.automaton.coordinates]
    angles = beside(names)
    curves = {label(name): _curve(result, name, i, angles) for i, name in enumerate(names)}
    # The legend of the modes stands in the panel of the forces and the phase plane.
    strip = {f"_{mode}": curve for mode, curve in mode_strip(result).items()}
    right = "angle (rad), dashed" if angles else ""
    t = result.times()
    limits = float(t[0]), float(t[-1])
    return Drawing("time (s)", left_label(names), {**curves, **strip}, right=right, xlim=limits)


def _curve(result: Any, name: str, i: int, angles: tuple[str, ...]) -> Curve:
    x, y = envelope(result.times(), result.state(name))
    style = line_style(i, name) | ({"zorder": 1.8} if is_angle(name) else {})  # behind the lengths
    return Curve(x, y, style, "right" if name in angles else "left")
