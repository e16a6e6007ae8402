"""Steady states against a parameter, computed bit by bit, so that newer values need not wait for them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.bifurcation import bifurcation, one
from frictionlab.analysis.kinds import UNSETTLED
from frictionlab.analysis.tasks import run_tasks

Array = NDArray[np.float64]
AT_ONCE = os.cpu_count() or 1  # values, in threads
PATIENCE = 0.2  # seconds between two pictures of a diagram that fills
MORE = 10  # windows that a motion goes on for at a time where it has not settled
MOST = 20  # times; what has not settled then is left as it is


class Found(NamedTuple):
    """Kind of motion, and section points (K, 2n)."""

    kind: str
    states: Array


class Unsettled(NamedTuple):
    """Where a motion that has not settled goes on (2n,), and how often it did."""

    final: list[float]
    times: int


class Filling:
    """Steady states of a model, those of :func:`frictionlab.bifurcation`, found a few at a time.

    First every value gets one window after the transient; then those that have not settled go on, window by
    window as with `longest`, the least advanced first.

    Parameters
    ----------
    model : Model
    parameter : str
    x0, options
        As :func:`frictionlab.bifurcation`: transient, window, method.

    Attributes
    ----------
    found : dict of float to Found
    unsettled : dict of float to Unsettled
        Those that go on.
    """

    def __init__(self, model: Any, parameter: str, x0: Any, options: dict[str, Any]) -> None:
        self.model, self.parameter, self.x0, self.options = model, parameter, x0, options
        self.found: dict[float, Found] = {}
        self.unsettled: dict[float, Unsettled] = {}

    def left(self, values: Sequence[float]) -> list[float]:
        """What is not done of some values: first those that are not there, then those that go on."""
        missing = [value for value in _coarse_to_fine(values) if value not in self.found]
        open_ones = [value for value in values if value in self.unsettled]
        return missing + sorted(open_ones, key=lambda value: self.unsettled[value].times)

    def work(self, values: Sequence[float]) -> None:
        """Compute for as long as one waits gladly."""
        end = perf_counter() + PATIENCE
        while (left := self.left(values)) and perf_counter() < end:
            new = [value for value in left[:AT_ONCE] if value not in self.found]
            if new:
                self._begin(new)
            else:
                self._go_on(left[:AT_ONCE])

    def _begin(self, values: list[float]) -> None:
        done = bifurcation(self.model, self.parameter, values, self.x0, progress=False, **self.options)
        for i, value in enumerate(values):
            self._keep(value, done.results[i], 0)

    def _go_on(self, values: list[float]) -> None:
        # Half a window more, so that rounding takes none away.
        longest = (MORE + 0.5) * self.options["window"]
        options = {**self.options, "transient": 0.0, "longest": longest}
        models = [self.model.replace(**{self.parameter: value}) for value in values]
        starts = [np.array(self.unsettled[value].final) for value in values]
        names = [f"{self.parameter} = {value:g}" for value in values]

        def keep(i: int, result: Any) -> None:
            self._keep(values[i], result, self.unsettled[values[i]].times + 1)

        run_tasks(one, [(m, start, options) for m, start in zip(models, starts)], keep=keep, names=names)

    def _keep(self, value: float, result: Any, times: int) -> None:
        kind, states = result["kind"], result["section"]
        self.found[value] = Found(kind, np.array(states).reshape(-1, len(result["final"])))
        self.unsettled.pop(value, None)
        if kind == UNSETTLED and times < MOST:
            self.unsettled[value] = Unsettled(result["final"], times)


def _coarse_to_fine(values: Sequence[float]) -> list[float]:
    """Every eighth value, then those half-way between, and so on."""
    order = [i for step in (8, 4, 2, 1) for i in range(0, len(values), step)]
    return [values[i] for i in dict.fromkeys(order)]
