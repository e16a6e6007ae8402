"""Contact forces against time, with the modes below them."""

from __future__ import annotations

from typing import Any

from frictionlab.plotting.forces import FORCES
from frictionlab.widgets.drawing import Curve, Drawing
from frictionlab.widgets.envelope import envelope

from .strip import mode_strip


def forces(result: Any) -> Drawing:
    """Normal and friction force."""
    t, curves = result.times(), {}
    for name, (text, colour) in FORCES.items():
        x, y = envelope(t, result.run.output(name, t))
        curves[text.partition(" (")[0]] = Curve(x, y, {"color": colour})
    limits = float(t[0]), float(t[-1])
    return Drawing("time (s)", "contact force (N)", {**curves, **mode_strip(result)}, xlim=limits)
