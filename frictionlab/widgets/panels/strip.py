"""The modes of a run as a coloured strip at the foot of a panel over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.plotting.palette import mode_colours
from frictionlab.widgets.drawing import Curve

THICK = 7.0  # points
PIECES = 400
HEIGHT = 0.02


def mode_strip(result: Any) -> dict[str, Curve]:
    """A thick line for every mode of the model, broken where the run is in other modes."""
    colours = mode_colours(result.run.automaton.names)
    t, modes = result.times(), result.modes
    kept = slice(None, None, max(1, len(t) // PIECES))
    t, modes = t[kept], modes[kept]
    return {mode: _pieces(t, modes == mode, colour) for mode, colour in colours.items()}


def _pieces(t: Any, chosen: Any, colour: str) -> Curve:
    kept = chosen | np.append(False, chosen[:-1])  # up to the sample after, so that no gap is seen
    style = {"color": colour, "linewidth": THICK, "solid_capstyle": "butt", "zorder": 1.0}
    return Curve(np.where(kept, t, np.nan), np.where(kept, HEIGHT, np.nan), style, "strip")
