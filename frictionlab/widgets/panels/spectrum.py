"""The amplitude spectrum of the coordinate chosen."""

from __future__ import annotations

from typing import Any

from frictionlab.analysis.spectrum import highest
from frictionlab.plotting.palette import BLACK, label, unit
from frictionlab.widgets.drawing import Curve, Drawing


def spectrum(result: Any) -> Drawing:
    """Over the second half of the run."""
    name, found, f_max = result.settings.coordinate, result.spectrum, highest(result.model)
    labels = "frequency (Hz)", f"amplitude of {label(name)} ({unit(name)})"
    if found is None:
        return Drawing(
            *labels, {"_spectrum": Curve([], [])}, note="the run is too short for one", xlim=(0, f_max)
        )
    curve = Curve(found.frequencies, found.amplitudes, {"color": BLACK, "linewidth": 1.0})
    note = f"strongest line {found.strongest:.4g} Hz" if found.amplitudes.any() else "at rest"
    return Drawing(*labels, {"_spectrum": curve}, yscale="log", note=note, xlim=(0.0, f_max))
