"""Eigenvalues of steady sliding in the complex plane."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.plotting.palette import BLUE, GREY, VERMILLION
from frictionlab.widgets.drawing import Curve, Drawing

DOT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5.0, "zorder": 2.5}
NO_GROWTH: dict[str, Any] = {"color": GREY, "linewidth": 0.8, "zorder": 1.0}


def eigenvalues(result: Any) -> Drawing:
    """Growth rate and frequency of each mode, those that grow in another colour."""
    found = result.eigenvalues
    values: Any = np.zeros(0, dtype=complex) if found is None else found.values[found.values.imag >= 0]
    grows, frequencies = values.real > 0, values.imag / (2 * np.pi)
    curves = {
        "_no growth": Curve([0.0, 0.0], [0.0, 1.0], NO_GROWTH, "strip"),
        "decays": Curve(values.real[~grows], frequencies[~grows], DOT | {"color": BLUE}),
        "grows": Curve(values.real[grows], frequencies[grows], DOT | {"color": VERMILLION, "marker": "^"}),
    }
    note = "no equilibrium" if found is None else ""
    return Drawing("growth rate (1/s)", "frequency (Hz)", curves, note=note)
