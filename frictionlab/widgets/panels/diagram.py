"""A bifurcation diagram that is refined where one looks."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from time import perf_counter
from types import MappingProxyType
from typing import Any

import ipywidgets
import numpy as np

from frictionlab.analysis.bifurcation import bifurcation
from frictionlab.analysis.timescale import round_period_of
from frictionlab.models.namespace import about_all
from frictionlab.models.symbols import structure
from frictionlab.plotting.bifurcation import STYLES
from frictionlab.plotting.palette import GREY, label, unit
from frictionlab.plotting.parameters import parameter_label
from frictionlab.widgets.drawing import Curve, Drawing
from frictionlab.widgets.settings import capped
from frictionlab.widgets.sliders import FORMAT, description, dressed, known, reach, rounded

AT_ONCE = os.cpu_count() or 1  # values, in threads
COUNT = 24  # values in the range that is looked at
TRANSIENT, LONGEST, STEP = 1000, 5000, 50  # periods thrown away: at first, and at most
WINDOW = 100  # periods looked at
PATIENCE = 0.2  # seconds between two pictures of a diagram that fills
HERE: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "zorder": 1.0}


class Diagram:
    """A panel: a coordinate where stick begins (or turns back) in the steady state, against a parameter.

    It is computed in parts, from coarse to fine, so that it is seen to fill and newer values need not wait.
    What was computed is kept until another parameter changes, so that a narrower range adds values between.

    Attributes
    ----------
    controls : mapping of str to widget
        "range" says which values are looked at, "transient" how many seconds are thrown away.
    found : dict of float to (str, array (K, 2n))
        Kind of motion and section points at each value.
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
        seconds = ipywidgets.FloatSlider(
            TRANSIENT, max=LONGEST, step=5.0, readout_format=FORMAT, continuous_update=False
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
        self.parameter, self.found = parameter, {}
        self._key: Any = None

    def __call__(self, result: Any) -> Drawing:
        """The points in the range, by the kind of motion, and a line at the model's own value."""
        known(result.model, self.parameter)
        low, high = self.controls["range"].value
        left = self._compute(result, np.linspace(low, high, COUNT).tolist())
        inside = {value: found for value, found in self.found.items() if low <= value <= high}
        name = result.settings.coordinate
        column = result.model.coordinates.index(name)
        kinds = {kind for kind, _ in inside.values()}
        curves = {kind: _points(inside, kind, column) for kind in STYLES if kind in kinds}
        own = result.model.parameters[self.parameter]
        curves["_here"] = Curve([own, own], [0.0, 1.0], HERE, "strip")
        labels = parameter_label(result.model, self.parameter), f"section of {label(name)} ({unit(name)})"
        progress = (COUNT - left, COUNT) if left else None
        return Drawing(*labels, curves, note=f"{len(inside)} values", xlim=(low, high), progress=progress)

    def pick(self, x: float, _: float) -> dict[str, float]:
        """The value where one clicks, as a round number."""
        return {self.parameter: rounded(x, self.controls["range"].value)}

    def _compute(self, result: Any, values: list[float]) -> int:
        """Compute for as long as one waits gladly; returns how many values are left."""
        settings, transient = result.settings, self.controls["transient"].value
        others = tuple(item for item in result.model.parameters.items() if item[0] != self.parameter)
        key = structure(result.model), others, settings.x0, settings.method, transient
        if key != self._key:
            self.found, self._key = {}, key
        missing, end = [v for v in _coarse_to_fine(values) if v not in self.found], perf_counter() + PATIENCE
        window = WINDOW * round_period_of(result.model)
        while missing and perf_counter() < end:
            options: dict[str, Any] = {"x0": settings.x0, "transient": transient, "window": window}
            options["method"] = capped(settings.method)
            now, missing = missing[:AT_ONCE], missing[AT_ONCE:]
            done = bifurcation(result.model, self.parameter, now, progress=False, **options)
            self.found |= {v: row for v, *row in zip(done.values.tolist(), done.kinds, done.sections)}
        return len(missing)


def _coarse_to_fine(values: Sequence[float]) -> list[float]:
    """Every eighth value, then those half-way between, and so on."""
    order = [i for step in (8, 4, 2, 1) for i in range(0, len(values), step)]
    return [values[i] for i in dict.fromkeys(order)]


def _points(found: Mapping[float, Any], kind: str, column: int) -> Curve:
    chosen = [(value, states[:, column]) for value, (its, states) in found.items() if its == kind]
    x = [np.full(len(states), value) for value, states in chosen]
    y = [states for _, states in chosen]
    style = {"linestyle": "none", **STYLES[kind]}
    return Curve(np.concatenate(x or [[]]), np.concatenate(y or [[]]), style)
