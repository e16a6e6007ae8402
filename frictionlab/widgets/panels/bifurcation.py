"""A bifurcation diagram that is refined in the range shown, computed in parts.

`ProgressiveSweep` computes steady states a few at a time: a preview after a short transient, almost at
once; the coarse diagram; the values between; then longer runs of motions that have not settled.
`BifurcationPanel` lets it compute some more at each update and draws what has been found so far.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import round_down_1_2_5
from frictionlab.analysis.options import SteadyStateOptions
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.sweeps.bifurcation import bifurcation, steady_state_task
from frictionlab.analysis.sweeps.tasks import run_tasks
from frictionlab.components.component import Parameter
from frictionlab.models.model import automaton_of, check_parameter_name, parameters_about, values_of
from frictionlab.pages.scene import Data, Shown, last_value, number, slider_range
from frictionlab.plotting.appearance import GREY
from frictionlab.plotting.figure import Curve, Drawing
from frictionlab.plotting.labels import parameter_label, state_with_unit
from frictionlab.plotting.studies.sweeps import EARLY_END_HEIGHT, MOTION_STYLES
from frictionlab.widgets.controls import Control
from frictionlab.widgets.panels.standard import apart_from
from frictionlab.widgets.result import limit_steps, tighten_tolerance
from frictionlab.widgets.update_scheduler import running_loop

Array = NDArray[np.float64]
BATCH_SIZE = os.cpu_count() or 1  # values computed at the same time, in threads
TIME_SLICE = 0.2  # seconds between two pictures of a diagram in progress
WINDOWS_PER_EXTENSION = 10  # windows by which a motion that has not settled is extended at a time
MAX_EXTENSIONS = 20  # most such extensions of a motion
# The transient of a preview is one window.  There are previews only where the full transient has at least so
# many windows: otherwise they would take hardly less time than the results.
LEAST_WINDOWS_OF_TRANSIENT = 4
PREVIEW_BATCH_SIZE = 4 * BATCH_SIZE  # previews computed in threads before the next picture

GRID_VALUES, GRID_STEP = 300, 13  # values in the range shown; every 13th of them, 24, is the coarse diagram
GOLDEN_STEP = 8  # its multiples modulo 13 fall one after the other into the widest gap left
DEFAULT_TRANSIENT, MAX_TRANSIENT = 1000, 5000  # periods of transient: at first, and at most
WINDOW_PERIODS = 100  # periods of the window that is classified
SELECTED_VALUE_LINE: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "zorder": 1.0}


class SteadyStatePoints(NamedTuple):
    """Kind of motion, and section points (K, 2n)."""

    kind: str
    states: Array


class UnsettledMotion(NamedTuple):
    """A motion that has not settled: the state (2n,) and mode from which it goes on, and its extensions."""

    final: list[float]
    mode: str
    times: int


class ProgressiveSweep:
    """Steady states of a model, those of :func:`frictionlab.bifurcation`, found a few at a time.

    First the motion at every value gets one window after the transient; then those that have not settled go
    on, window by window as with `t_max`, the least advanced first.  A preview is the result of a short
    transient.

    Parameters
    ----------
    model : Model
    parameter : str
    x0, options
        As :func:`frictionlab.bifurcation` takes them; the options are transient, window and method.

    Attributes
    ----------
    steady_states : dict of float to SteadyStatePoints
    previews : dict of float to SteadyStatePoints
        Values that have a preview; what is found replaces it.
    unsettled : dict of float to UnsettledMotion
        Motions that are to be extended.
    """

    def __init__(self, model: Shown, parameter: str, x0: Any, options: SteadyStateOptions) -> None:
        self.model, self.parameter, self.x0, self.options = model, parameter, x0, options
        self.steady_states: dict[float, SteadyStatePoints] = {}
        self.previews: dict[float, SteadyStatePoints] = {}
        self.unsettled: dict[float, UnsettledMotion] = {}

    def left(self, values: Sequence[float]) -> list[float]:
        """The values still to be computed: first those without a result, then those to be extended."""
        missing = [value for value in _coarse_to_fine(values) if value not in self.steady_states]
        open_ones = [value for value in values if value in self.unsettled]
        return missing + sorted(open_ones, key=lambda value: self.unsettled[value].times)

    def shown(self, value: float) -> SteadyStatePoints | None:
        """What is known of a value so far."""
        return self.steady_states.get(value) or self.previews.get(value)

    def preview(self, values: Sequence[float]) -> bool:
        """Preview some values of which nothing is known; False if there are none or it would save no time."""
        new = [value for value in _coarse_to_fine(values) if self.shown(value) is None]
        options = self.options
        if not new or options.transient < LEAST_WINDOWS_OF_TRANSIENT * options.window:
            return False
        results = self._compute(new[:PREVIEW_BATCH_SIZE], replace(options, transient=options.window))
        self.previews |= {value: _points(result) for value, result in results.items()}
        return True

    def work(self, values: Sequence[float]) -> None:
        """Compute results for about as long as there is between two pictures."""
        end = perf_counter() + TIME_SLICE
        while (left := self.left(values)) and perf_counter() < end:
            new = [value for value in left[:BATCH_SIZE] if value not in self.steady_states]
            if new:
                self._start(new)
            else:
                self._extend(left[:BATCH_SIZE])

    def _start(self, values: list[float]) -> None:
        for value, result in self._compute(values, self.options).items():
            self._keep(value, result, 0)

    def _compute(self, values: list[float], options: SteadyStateOptions) -> dict[float, Any]:
        done = bifurcation(
            self.model,
            self.parameter,
            values,
            self.x0,
            transient=options.transient,
            window=options.window,
            method=options.method,
            progress=False,
        )
        return {value: done.results[i] for i, value in enumerate(values)}

    def _extend(self, values: list[float]) -> None:
        # Half a window more, so that rounding does not lose one.
        longest = (WINDOWS_PER_EXTENSION + 0.5) * self.options.window
        options = replace(self.options, transient=0.0, t_max=longest)
        models = [self.model.replace(**{self.parameter: value}) for value in values]
        ends = [self.unsettled[value] for value in values]
        names = [f"{self.parameter} = {value:g}" for value in values]

        def keep(i: int, result: Any) -> None:
            self._keep(values[i], result, self.unsettled[values[i]].times + 1)

        run_tasks(
            steady_state_task,
            [(m, np.array(end.final), options, end.mode) for m, end in zip(models, ends)],
            keep=keep,
            name=names.__getitem__,
        )

    def _keep(self, value: float, result: Any, times: int) -> None:
        self.steady_states[value] = _points(result)
        self.unsettled.pop(value, None)
        if result["kind"] == MotionKind.NOT_SETTLED and times < MAX_EXTENSIONS:
            self.unsettled[value] = UnsettledMotion(result["final"], result["mode"], times)


def _points(result: Mapping[str, Any]) -> SteadyStatePoints:
    return SteadyStatePoints(result["kind"], np.array(result["section"]).reshape(-1, len(result["final"])))


def _coarse_to_fine(values: Sequence[float]) -> list[float]:
    """The values in the order of computing: first the coarse diagram, every eighth of its values, then those
    half-way between, and so on; then one value more in each of its intervals, again and again."""
    count = len(values)
    order = [i for step in (8, 4, 2, 1) for i in range(0, count, step * GRID_STEP)]
    starts = (GOLDEN_STEP * i % GRID_STEP for i in range(1, GRID_STEP))
    order += [i for start in starts for i in range(start, count, GRID_STEP)]
    return [values[i] for i in dict.fromkeys(order)]


class BifurcationPanel:
    """A panel: a coordinate at the onsets of stick (or the turning points) of the steady state, against a
    parameter.

    It is computed in parts, from coarse to fine, so that points appear while it is computed and newer
    settings need not wait: a preview of 24 values within a second, then these values and those between, 300
    in all.  The note says how many values are still previews.  Motions that have not settled are drawn as
    such, and extended once all values are computed.  Results are kept until another parameter changes, so
    that a narrower range only adds values in between.

    Attributes
    ----------
    controls : mapping of str to Control
        "range" sets the values shown, "transient" the seconds discarded.
    sweep : ProgressiveSweep or None
        The sweep in progress.
    """

    __name__ = "bifurcation"

    def __init__(self, model: Shown, parameter: str, period: float) -> None:
        about = parameters_about(model)[parameter]
        ends = slider_range(about, values_of(model)[parameter])
        span = tuple(last_value(model, parameter, end) for end in ends)
        first, most = (n * round_down_1_2_5(period) for n in (DEFAULT_TRANSIENT, MAX_TRANSIENT))
        shown: Data = {"name": "range", "kind": "range", "group": "bifurcation", "value": span}
        shown |= {"text": f"${about.symbol}$ from, to", "hint": "a narrow range is computed more finely"}
        rule = Parameter("", "s", "seconds that are thrown away", minimum=0.0)
        seconds = number("transient", rule, first, "bifurcation", (0.0, most))
        controls = {"range": Control(shown), "transient": Control(seconds, rule=rule)}
        self.controls: Mapping[str, Control] = MappingProxyType(controls)
        self.parameter, self.pick = parameter, (parameter, None)  # a click selects a value
        self.sweep: ProgressiveSweep | None = None
        self._key: Any = None
        self._shown: Any = None

    @property
    def steady_states(self) -> dict[float, SteadyStatePoints]:
        """Kind of motion and section points at each value."""
        return self.sweep.steady_states if self.sweep else {}

    def __call__(self, result: Any) -> Drawing:
        """The points in the range, by the kind of motion, and a line at the model's own value."""
        check_parameter_name(result.model, self.parameter)
        low, high = self.controls["range"].value
        sweep = self._sweep_for(result)
        inside, wanted, progress = self._fill(sweep, result, (low, high))
        name = result.settings.coordinate
        column = automaton_of(result.model).state_names.index(name)
        kinds = [steady.kind for steady in inside.values()]
        curves = {kind: _section_curve(inside, kind, column) for kind in MOTION_STYLES if kind in kinds}
        own = values_of(result.model)[self.parameter]
        curves["_here"] = Curve([own, own], [0.0, 1.0], SELECTED_VALUE_LINE, "strip")
        labels = (
            parameter_label(result.model, self.parameter),
            f"section of {state_with_unit(result.model, name)}",
        )
        waiting = kinds.count(MotionKind.NOT_SETTLED)
        note = f"{len(kinds)} values" if len(kinds) == wanted else f"{len(kinds)} of {wanted} values"
        note += f", {waiting} {MotionKind.NOT_SETTLED}" if waiting else ""
        previews = sum(value not in sweep.steady_states for value in inside)
        note += f"\n{previews} of a short transient" if previews else ""
        return Drawing(*labels, curves, note=note, xlim=(low, high), progress=progress)

    def _fill(
        self, sweep: ProgressiveSweep, result: Any, limits: tuple[float, float]
    ) -> tuple[dict[float, SteadyStatePoints], int, tuple[int, int] | None]:
        """Compute some more; return the results in a range, how many there will be, and the progress until
        all are there."""
        low, high = limits
        fine = np.linspace(low, high, GRID_VALUES)
        coarse = fine[::GRID_STEP]
        # In a script nobody watches the diagram fill: it gets the coarse one only, without a preview.
        watched = running_loop() is not None
        grid = (fine if watched else coarse).tolist()
        values = [*grid, *(v for v in sweep.steady_states if low <= v <= high and v not in grid)]
        # After a change by a slider or a click the present diagram is shown before more is computed.
        begun = bool(sweep.steady_states or sweep.previews)
        if (result is self._shown or not begun) and not (watched and sweep.preview(coarse.tolist())):
            sweep.work(values)
        self._shown, left = result, len(sweep.left(values))
        inside = {value: known for value in values if (known := sweep.shown(value))}
        return inside, len(values), (len(values) - left, len(values)) if left else None

    def _sweep_for(self, result: Any) -> ProgressiveSweep:
        """The sweep of a result; a new one where anything but the parameter differs."""
        settings, transient = result.settings, self.controls["transient"].value
        key = *apart_from(result.model, [self.parameter]), settings.x0, settings.method, transient
        if self.sweep is None or key != self._key:
            window, method = (
                WINDOW_PERIODS * round_down_1_2_5(settings.period),
                tighten_tolerance(limit_steps(settings.method)),
            )
            options = SteadyStateOptions(transient, window, method=method)
            self.sweep = ProgressiveSweep(result.model, self.parameter, settings.x0, options)
            self._key = key
        return self.sweep


def _section_curve(steady: Mapping[float, SteadyStatePoints], kind: str, column: int) -> Curve:
    chosen = [(value, states[:, column]) for value, (its, states) in steady.items() if its == kind]
    x = [np.full(len(states), value) for value, states in chosen]
    y = [states for _, states in chosen]
    style = {"linestyle": "none", **MOTION_STYLES[kind]}
    if kind == MotionKind.ENDED_EARLY:
        return Curve([value for value, _ in chosen], [EARLY_END_HEIGHT] * len(chosen), style, "strip")
    return Curve(np.concatenate(x or [[]]), np.concatenate(y or [[]]), style)
