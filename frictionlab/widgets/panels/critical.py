"""Critical values of a parameter against another, and where the model stands."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from frictionlab.models.namespace import about_all
from frictionlab.models.symbols import structure
from frictionlab.plotting.palette import BLACK, BLUE, VERMILLION
from frictionlab.plotting.parameters import parameter_label
from frictionlab.stability import CriticalCurve, critical_curve
from frictionlab.widgets.drawing import Curve, Drawing
from frictionlab.widgets.sliders import known, reach, rounded

POINTS = 21
REMEMBERED = 16  # curves
HERE: dict[str, Any] = {"linestyle": "none", "markersize": 8.0, "zorder": 3.0}


class Critical:
    """A panel: steady sliding is stable below the curve.

    The curve does not depend on the two parameters, so moving the point computes nothing anew.

    Parameters
    ----------
    model : SliderOnBelt
        Whose parameters say how far the axes go.
    parameter, over : str
        The critical one, upwards, and the other one, to the right.
    """

    __name__ = "critical"
    hint = "click to move the model there"

    def __init__(self, model: Any, parameter: str = "mu_k", over: str = "F") -> None:
        about = about_all(type(model), model.components)
        self.parameter, self.over = parameter, over
        self.bounds, self.sides = (reach(about[n], model.parameters[n]) for n in (parameter, over))
        self._curve = lru_cache(REMEMBERED)(self._computed)

    def __call__(self, result: Any) -> Drawing:
        """The curve, and a point in the colour of its stability."""
        model, found = result.model, result.eigenvalues
        for name in (self.parameter, self.over):
            known(model, name)
        curve = self._curve(_Others(model, (self.parameter, self.over)))
        here = [model.parameters[self.over]], [model.parameters[self.parameter]]
        stable = found is not None and found.stable
        curves = {
            "critical": Curve(curve.at, curve.values, {"color": BLACK}),
            "here, stable": _point(here, stable, BLUE, "o"),
            "here, unstable": _point(here, found is not None and not stable, VERMILLION, "^"),
        }
        x, y = (parameter_label(model, name) for name in (self.over, self.parameter))
        return Drawing(x, y, curves, xlim=self.sides, ylim=self.bounds)

    def pick(self, x: float, y: float) -> dict[str, float]:
        """The two parameters of a place in the picture, as round numbers."""
        return {self.over: rounded(x, self.sides), self.parameter: rounded(y, self.bounds)}

    def _computed(self, others: _Others) -> CriticalCurve:
        # The ends may be where nothing presses on the belt, or a mass is zero.
        at = np.linspace(*self.sides, POINTS + 2)[1:-1]
        return critical_curve(others.model, self.parameter, self.bounds, over=(self.over, at))


class _Others:
    """A model; two of them are equal where all but some parameters are."""

    def __init__(self, model: Any, names: tuple[str, ...]) -> None:
        self.model = model
        values = tuple(item for item in model.parameters.items() if item[0] not in names)
        self._key = structure(model), values

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Others) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def _point(here: Any, there: bool, colour: str, marker: str) -> Curve:
    x, y = here if there else ([], [])
    return Curve(x, y, HERE | {"color": colour, "marker": marker})
