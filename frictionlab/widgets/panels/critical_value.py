"""The panel of critical values: where steady sliding changes its stability, over another parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from frictionlab.models.model import check_parameter_name, parameters_about, values_of
from frictionlab.pages.scene import Shown, slider_range
from frictionlab.plotting.appearance import BLACK, BLUE, VERMILLION
from frictionlab.plotting.figure import Curve, Drawing
from frictionlab.plotting.labels import parameter_label
from frictionlab.stability.boundaries.stability_changes import curve_and_gaps
from frictionlab.widgets.panels.standard import apart_from
from frictionlab.widgets.update_scheduler import running_loop

if TYPE_CHECKING:
    from frictionlab.widgets.result import Result

CURVE_POINTS, CURVE_PARTS = 87, 4  # points of a critical curve, and the parts in which it is computed
MAX_CACHED_CURVES = 16  # curves
OPERATING_POINT: dict[str, Any] = {"linestyle": "none", "markersize": 8.0, "zorder": 3.0}


class CriticalValuePanel:
    """A panel: the critical values of a parameter over another; steady sliding is stable below the curve.

    The curve does not depend on the model's values of the two parameters, so moving the point computes
    nothing anew.  It is computed in parts, first every fourth point; in a script that is all.

    Parameters
    ----------
    model : Model or HybridAutomaton
        The model whose parameters give the limits of the axes.
    parameter, over : str
        The critical parameter, on the vertical axis, and the other one, on the horizontal axis.
    """

    __name__ = "critical"

    def __init__(self, model: Shown, parameter: str = "mu_k", over: str = "F") -> None:
        about, values = parameters_about(model), values_of(model)
        self.parameter, self.over = parameter, over
        self.bounds, self.sides = (slider_range(about[n], values[n]) for n in (parameter, over))
        self.pick = over, parameter  # what a click sets: the model moves there
        # At the ends there may be no contact force, or a mass may be zero.
        at = np.linspace(*self.sides, CURVE_POINTS + 2)[1:-1]
        self.parts = [at[i - 1 :: CURVE_PARTS] for i in (4, 2, 1, 3)]
        self._curves: dict[Any, dict[float, float]] = {}  # critical values over the other parameter
        self._shown: Any = None

    def __call__(self, result: Result) -> Drawing:
        """The curve, and a point in the colour of its stability."""
        model, eigenvalues = result.model, result.eigenvalues
        for name in (self.parameter, self.over):
            check_parameter_name(model, name)
        curve = self._curve_of(model)
        # After a change the present curve is shown before more is computed; a script gets its first part.
        watched = running_loop() is not None
        if not curve or (result is self._shown and watched):
            self._compute_more(model, curve)
        self._shown = result
        at = sorted(curve)
        here = [values_of(model)[self.over]], [values_of(model)[self.parameter]]
        stable = eigenvalues is not None and eigenvalues.stable
        curves = {
            "critical": Curve(at, [curve[x] for x in at], {"color": BLACK}),
            "here, stable": _operating_point(here, stable, BLUE, "o"),
            "here, unstable": _operating_point(here, eigenvalues is not None and not stable, VERMILLION, "^"),
        }
        x, y = (parameter_label(model, name) for name in (self.over, self.parameter))
        progress = (len(at), CURVE_POINTS) if len(at) < CURVE_POINTS and watched else None
        return Drawing(x, y, curves, xlim=self.sides, ylim=self.bounds, progress=progress)

    def _curve_of(self, model: Shown) -> dict[float, float]:
        key = apart_from(model, (self.parameter, self.over))
        if key not in self._curves and len(self._curves) == MAX_CACHED_CURVES:
            self._curves.clear()
        return self._curves.setdefault(key, {})

    def _compute_more(self, model: Shown, curve: dict[float, float]) -> None:
        """Compute one more part of a curve, if one is left."""
        part = next((part for part in self.parts if part[0] not in curve), None)
        if part is not None:
            found, _ = curve_and_gaps(model, self.parameter, self.bounds, over=(self.over, part))
            curve |= zip(found.at.tolist(), found.values.tolist(), strict=True)


def _operating_point(here: Any, there: bool, colour: str, marker: str) -> Curve:
    x, y = here if there else ([], [])
    return Curve(x, y, OPERATING_POINT | {"color": colour, "marker": marker})
