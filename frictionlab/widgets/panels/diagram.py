"""A bifurcation diagram that is refined where one looks."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import ipywidgets
import numpy as np

from frictionlab.analysis.kinds import ENDED, UNSETTLED
from frictionlab.analysis.timescale import round_period_of
from frictionlab.models.namespace import about_all
from frictionlab.models.symbols import structure
from frictionlab.plotting.bifurcation import FOOT, STYLES
from frictionlab.plotting.palette import GREY, label, unit
from frictionlab.plotting.parameters import parameter_label
from frictionlab.widgets.drawing import Curve, Drawing
from frictionlab.widgets.settings import capped, sharp
from frictionlab.widgets.sliders import FORMAT, description, dressed, known, reach, rounded

from .filling import Filling, Found

COUNT = 24  # values in the range that is looked at
TRANSIENT, LONGEST, STEP = 1000, 5000, 50  # periods thrown away: at first, and at most
WINDOW = 100  # periods looked at
HERE: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "zorder": 1.0}


class Diagram:
    """A panel: a coordinate where stick begins (or turns back) in the steady state, against a parameter.

    It is computed in parts, from coarse to fine, so that it is seen to fill and newer values need not wait.
    Motions that have not settled are drawn as such, and go on when all values are there.  What was computed
    is kept until another parameter changes, so that a narrower range adds values between.

    Attributes
    ----------
    controls : mapping of str to widget
        "range" says which values are looked at, "transient" how many seconds are thrown away.
    filling : Filling or None
        What is computed now.
    """

    __name__ = "bifurcation"
    hint = "click a value to see its response"

    def __init__(self, model: Any, parameter: str) -> None:
        about = about_all(type(model), model.components)[parameter]
        low, high = reach(about, model.parameters[parameter])
        span = ipywidgets.FloatRangeSlider(
            value=(low, high),
            min=low,
            max=high,
            step=(high - low) / 200,
            readout_format=".4",
            continuous_update=False,
        )
        first, most, step = (n * round_period_of(model) for n in (TRANSIENT, LONGEST, STEP))
        seconds = ipywidgets.FloatSlider(
            first, max=most, step=step, readout_format=FORMAT, continuous_update=False
        )
        text = f"values of {parameter} that are looked at; a narrow range is computed more finely"
        self.controls: Mapping[str, Any] = MappingProxyType(
            {
                "range": dressed(span, "range", f"{description(about)} from, to", text),
                "transient": dressed(seconds, "transient", "transient (s)", "seconds that are thrown away"),
            }
        )
        self.parameter = parameter
        self.filling: Filling | None = None
        self._key: Any = None
        self._shown: Any = None

    @property
    def found(self) -> dict[float, Found]:
        """Kind of motion and section points at each value."""
        return self.filling.found if self.filling else {}

    def __call__(self, result: Any) -> Drawing:
        """The points in the range, by the kind of motion, and a line at the model's own value."""
        known(result.model, self.parameter)
        low, high = self.controls["range"].value
        inside, progress = self._fill(result, low, high)
        name = result.settings.coordinate
        column = result.model.coordinates.index(name)
        kinds = [found.kind for found in inside.values()]
        curves = {kind: _points(inside, kind, column) for kind in STYLES if kind in kinds}
        own = result.model.parameters[self.parameter]
        curves["_here"] = Curve([own, own], [0.0, 1.0], HERE, "strip")
        labels = parameter_label(result.model, self.parameter), f"section of {label(name)} ({unit(name)})"
        waiting = kinds.count(UNSETTLED)
        note = f"{len(kinds)} values" + (f", {waiting} {UNSETTLED}" if waiting else "")
        return Drawing(*labels, curves, note=note, xlim=(low, high), progress=progress)

    def pick(self, x: float, _: float) -> dict[str, float]:
        """The value where one clicks, as a round number."""
        return {self.parameter: rounded(x, self.controls["range"].value)}

    def _fill(
        self, result: Any, low: float, high: float
    ) -> tuple[dict[float, Found], tuple[int, int] | None]:
        """What there is in a range after some more work, and how much of it is done where not all is."""
        filling = self._filling(result)
        grid = np.linspace(low, high, COUNT).tolist()
        values = [*grid, *(v for v in filling.found if low <= v <= high and v not in grid)]
        # What a slider or a click has changed is shown first.
        if result is self._shown or not filling.found:
            filling.work(values)
        self._shown, left = result, len(filling.left(values))
        inside = {value: filling.found[value] for value in values if value in filling.found}
        return inside, (len(values) - left, len(values)) if left else None

    def _filling(self, result: Any) -> Filling:
        """The computation that belongs to a result: begun anew where anything but the parameter differs."""
        settings, transient = result.settings, self.controls["transient"].value
        others = tuple(item for item in result.model.parameters.items() if item[0] != self.parameter)
        key = structure(result.model), others, settings.x0, settings.method, transient
        if self.filling is None or key != self._key:
            window, method = WINDOW * round_period_of(result.model), sharp(capped(settings.method))
            options = {"transient": transient, "window": window, "method": method}
            self.filling = Filling(result.model, self.parameter, settings.x0, options)
            self._key = key
        return self.filling


def _points(found: Mapping[float, Found], kind: str, column: int) -> Curve:
    chosen = [(value, states[:, column]) for value, (its, states) in found.items() if its == kind]
    x = [np.full(len(states), value) for value, states in chosen]
    y = [states for _, states in chosen]
    style = {"linestyle": "none", **STYLES[kind]}
    if kind == ENDED:
        return Curve([value for value, _ in chosen], [FOOT] * len(chosen), style, "strip")
    return Curve(np.concatenate(x or [[]]), np.concatenate(y or [[]]), style)
