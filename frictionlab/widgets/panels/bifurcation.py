"""A bifurcation diagram that is refined in the range shown, computed in parts.

`ProgressiveSweep` computes steady states a few at a time: a preview after a short transient, almost at
once; the coarse diagram; the values between; then further windows of motions that have not settled.
`BifurcationPanel` lets it compute some more at each update and draws what has been found so far.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from time import perf_counter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.motion_scales import round_down_1_2_5
from frictionlab.analysis.options import SteadyStateOptions
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import SteadyState, WindowStart, settle
from frictionlab.analysis.sweeps.bifurcation import MAX_SECTION_POINTS, bifurcation, reach_of_transient
from frictionlab.analysis.sweeps.tasks import run_tasks, thread_count
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
BATCH_SIZE = thread_count(None)  # values computed at the same time, in threads
TIME_SLICE = 0.2  # seconds between two pictures of a diagram in progress
EXTENSIONS = 40, 200  # windows that motions have in the end if they do not settle: first all 40, then all 200
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
    """Kind of motion, and section points (K, 2n), as they are known after so many windows; 0: a preview."""

    kind: str
    states: Array
    windows: int


class ProgressiveSweep:
    """Steady states of a model, those of :func:`frictionlab.bifurcation`, found a few at a time.

    Stage 0 is a preview, of a short transient.  Stage 1 gives every value one window after the transient.
    Motions that have not settled then go on, as with `t_max`, a window at a time.

    Parameters
    ----------
    model : Model
    parameter : str
    x0, options
        As :func:`frictionlab.bifurcation` takes them; the options are transient, window and method.

    Attributes
    ----------
    known : dict of float to SteadyStatePoints
        What is known at values of the parameter.
    """

    def __init__(self, model: Shown, parameter: str, x0: Any, options: SteadyStateOptions) -> None:
        self.model, self.parameter, self.x0, self.options = model, parameter, x0, options
        self.known: dict[float, SteadyStatePoints] = {}
        self._next_windows: dict[float, WindowStart] = {}  # of motions that have not settled
        self.has_previews = options.transient >= LEAST_WINDOWS_OF_TRANSIENT * options.window

    @property
    def steady_states(self) -> dict[float, SteadyStatePoints]:
        """What is more than a preview."""
        return {value: found for value, found in self.known.items() if found.windows}

    def left(self, values: Sequence[float], previews: Container[float] = ()) -> list[tuple[int, float]]:
        """The stages still to be computed, the first ones first; some values have previews before them."""
        stages = ((self._next_stage(value, value in previews), value) for value in _coarse_to_fine(values))
        return sorted(((stage, value) for stage, value in stages if stage is not None), key=itemgetter(0))

    def _next_stage(self, value: float, previewed: bool) -> int | None:
        found = self.known.get(value)
        if found is None:
            return 0 if previewed and self.has_previews else 1
        if not found.windows:
            return 1
        stage = 2 + bisect_right(EXTENSIONS, found.windows)
        return stage if found.kind == MotionKind.NOT_SETTLED and stage < 2 + len(EXTENSIONS) else None

    def work(self, values: Sequence[float], previews: Container[float] = ()) -> None:
        """Compute results for about as long as there is between two pictures."""
        end = perf_counter() + TIME_SLICE
        while (left := self.left(values, previews)) and perf_counter() < end:
            stage = left[0][0]
            size = BATCH_SIZE if stage else PREVIEW_BATCH_SIZE
            batch = [value for its, value in left[:size] if its == stage]
            if stage > 1:
                self._go_on(batch)
            else:
                self._compute(stage, batch)

    def _compute(self, stage: int, values: list[float]) -> None:
        window = self.options.window
        transient = self.options.transient if stage else window
        done = bifurcation(
            self.model,
            self.parameter,
            values,
            self.x0,
            transient=transient,
            window=window,
            method=self.options.method,
            progress=False,
        )
        for i, value in enumerate(values):
            self.known[value] = SteadyStatePoints(done.kinds[i], done.sections[i], stage)
            if stage and done.kinds[i] == MotionKind.NOT_SETTLED:
                model, found, before = self._model_at(value), done.results[i], transient + window
                start = initial_state_of(model, self.x0)
                reach = reach_of_transient(model, start, replace(self.options, transient=before))
                self._next_windows[value] = WindowStart(
                    np.array(found["final"]), found["mode"], before, reach
                )

    def _model_at(self, value: float) -> Shown:
        return self.model.replace(**{self.parameter: value})

    def _go_on(self, values: list[float]) -> None:
        """One window more for some values."""

        def keep(task: int, found: tuple[SteadyState, WindowStart]) -> None:
            value, (steady, following) = values[task], found
            states, windows = steady.section.state[-MAX_SECTION_POINTS:], self.known[value].windows + 1
            self.known[value] = SteadyStatePoints(steady.kind, states, windows)
            self._next_windows[value] = following

        tasks = [(self._model_at(value), self._next_windows[value], self.options, False) for value in values]
        if not run_tasks(settle, tasks, keep=keep, name=lambda i: f"{self.parameter} = {values[i]:g}"):
            raise KeyboardInterrupt


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
    such, and go on window by window once all values are computed.  Results are kept until another parameter
    changes, so that a narrower range only adds values in between.

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
        previews = sum(not steady.windows for steady in inside.values())
        note += f"\n{previews} of a short transient" if previews else ""
        windows = max((s.windows for s in inside.values() if s.kind == MotionKind.NOT_SETTLED), default=0)
        note += f"\n{windows} of {EXTENSIONS[-1]} windows" if progress and windows > 1 else ""
        return Drawing(*labels, curves, note=note, xlim=(low, high), progress=progress)

    def _fill(
        self, sweep: ProgressiveSweep, result: Any, limits: tuple[float, float]
    ) -> tuple[dict[float, SteadyStatePoints], int, tuple[int, int] | None]:
        """Compute some more; return the results in a range, how many there will be, and the progress until
        all are there."""
        low, high = limits
        fine = np.linspace(low, high, GRID_VALUES)
        # In a script nobody watches the diagram fill: it gets the coarse one only, without a preview.
        watched, coarse = running_loop() is not None, fine[::GRID_STEP].tolist()
        grid = fine.tolist() if watched else coarse
        values = [*grid, *(v for v in sweep.steady_states if low <= v <= high and v not in grid)]
        # After a change by a slider or a click the present diagram is shown before more is computed.
        if result is self._shown or not sweep.known:
            sweep.work(values, coarse if watched else ())
        self._shown, left = result, len(sweep.left(values))
        inside = {value: sweep.known[value] for value in values if value in sweep.known}
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
    chosen = [(value, states[:, column]) for value, (its, states, _) in steady.items() if its == kind]
    x = [np.full(len(states), value) for value, states in chosen]
    y = [states for _, states in chosen]
    style = {"linestyle": "none", **MOTION_STYLES[kind]}
    if kind == MotionKind.ENDED_EARLY:
        return Curve([value for value, _ in chosen], [EARLY_END_HEIGHT] * len(chosen), style, "strip")
    return Curve(np.concatenate(x or [[]]), np.concatenate(y or [[]]), style)
