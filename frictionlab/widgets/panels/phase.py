"""The phase plane of the coordinate chosen, coloured by mode."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.plotting.palette import BLACK, label, mode_colours, unit
from frictionlab.widgets.drawing import Curve, Drawing


def phase(result: Any) -> Drawing:
    """Coordinate against rate over the part that is shown, and the equilibrium of sliding."""
    name = result.settings.coordinate
    x, rate, modes = result.state(name), result.state(f"{name}'"), result.modes
    curves = {m: _curve(x, rate, modes == m, c) for m, c in mode_colours(result.run.automaton.names).items()}
    cross = {"color": BLACK, "marker": "+", "markersize": 8.0, "linestyle": "none", "zorder": 3.0}
    curves["equilibrium"] = Curve(*_equilibrium(result, name), cross)
    xlabel, ylabel = (f"{label(n)} ({unit(n)})" for n in (name, f"{name}'"))
    return Drawing(xlabel, ylabel, curves)


def _curve(x: Any, rate: Any, chosen: Any, colour: str) -> Curve:
    kept = chosen | np.append(False, chosen[:-1])  # up to the sample after, so that no gap is seen
    return Curve(np.where(kept, x, np.nan), np.where(kept, rate, np.nan), {"color": colour})


def _equilibrium(result: Any, name: str) -> tuple[list[float], list[float]]:
    found = result.eigenvalues
    if found is None:  # the text beside the picture says why
        return [], []
    return [float(found.equilibrium.q[result.run.names.index(name)])], [0.0]
