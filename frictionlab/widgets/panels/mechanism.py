"""The model's mechanism at the end of the window shown."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.plotting.animation.run_picture import mechanism_of, picture_of
from frictionlab.plotting.drawing import Curve, Drawing
from frictionlab.plotting.style import BLACK

FRAMES = 200  # by which displacements are magnified, so that the largest is well seen


def mechanism(result: Any) -> Drawing:
    """Bodies, springs, belt and contact forces at the last instant, magnified as the whole motion allows."""
    t = result.times()
    seen = t[np.unique(np.linspace(0, len(t) - 1, FRAMES).astype(int))]
    picture = picture_of(result.run, mechanism_of(result.run, "the panel mechanism"), seen)
    lines = picture.outlines(len(seen) - 1)
    curves = {f"_part {i}": Curve(x, y, {"color": BLACK}) for i, (x, y) in enumerate(lines)}
    xlim, ylim = picture.limits
    note = f"t = {seen[-1]:.4g} s: {picture.mode[-1]}"
    return Drawing(picture.note, "", curves, note=note, xlim=xlim, ylim=ylim)
