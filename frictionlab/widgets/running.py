"""Controls of the run: initial state, duration, method, and what is shown of it."""

from __future__ import annotations

from typing import Any

import ipywidgets
import numpy as np

from frictionlab.analysis.timescale import round_period_of
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.taylor import Taylor

from .settings import QUICK, Settings
from .sliders import FORMAT, LOG_FORMAT, dressed, unrounded

OWN, FIXED = "own", "rk4"
STARTS = (("rest", "rest"), ("near the equilibrium", "near"), ("own numbers", OWN))
METHODS = (("quick (Taylor)", QUICK), ("exact (Taylor)", Taylor()), ("paper's (RK4)", FIXED))
WINDOWS = 5, 10, 20, 50  # periods
NAMES = "start", "own", "duration", "method", "step", "window", "coordinate"
STEP, FINEST, COARSEST = 2e-4, 2e-5, 1e-2  # s; the paper's step


class RunControls:
    """Drop-down lists and sliders that say how a model is run.

    Attributes
    ----------
    start, own, duration, method, step, window, coordinate : widgets
    """

    def __init__(self, settings: Settings) -> None:
        drop, names = ipywidgets.Dropdown, settings.model.coordinates
        self.start = dressed(drop(options=STARTS), "start", "start", "initial state")
        self.own = _own(names)
        self.duration, self._t_end = _duration(settings), settings.t_end
        text = "quick: tolerance 1e-7, flights below 0.4 ms replaced by their limit; exact: to rounding"
        self.method = dressed(drop(options=METHODS, value=settings.method), "method", "method", text)
        self.step = _step()
        text = "part of the run that the panels show; the spectrum is of its second half"
        self.window = dressed(
            drop(options=_windows(settings.model), value=settings.window), "window", "shown", text
        )
        text = "coordinate of the phase plane and the spectrum"
        self.coordinate = dressed(drop(options=names), "coordinate", "coordinate", text)
        layout = ipywidgets.Layout(flex_flow="row wrap")
        self.widget = ipywidgets.Box(list(self.controls.values()), layout=layout)

    @property
    def controls(self) -> dict[str, Any]:
        """All of them by name."""
        return {name: getattr(self, name) for name in NAMES}

    def settings(self, model: Any) -> Settings:
        """The settings for a model.

        Raises
        ------
        ValueError
            Where the initial state is no list of numbers.
        """
        self.own.layout.display = "" if self.start.value == OWN else "none"
        self.step.layout.display = "" if self.method.value == FIXED else "none"
        start = _numbers(self.own.value) if self.start.value == OWN else self.start.value
        step = unrounded(self.step.value, STEP)
        method = RK4(step=step) if self.method.value == FIXED else self.method.value
        chosen = self.coordinate.value
        coordinate = chosen if chosen in model.coordinates else model.coordinates[0]
        t_end = unrounded(self.duration.value, self._t_end)
        return Settings(model, t_end, start, method, self.window.value, coordinate)


def _own(names: tuple[str, ...]) -> Any:
    text = f"coordinates {', '.join(names)}, then their rates, with commas between"
    return dressed(ipywidgets.Text(_zeros(names), continuous_update=False), "own", "state", text)


def _zeros(names: tuple[str, ...]) -> str:
    return ", ".join(["0"] * 2 * len(names))


def _windows(model: Any) -> list[tuple[str, float | None]]:
    lengths = [round(count * round_period_of(model), 12) for count in WINDOWS]
    return [*((f"last {s:g} s", s) for s in lengths), ("whole run", None)]


def _duration(settings: Settings) -> Any:
    """From ten periods of the model to a thousand."""
    period, seconds = round_period_of(settings.model), settings.t_end
    low, high = 10 * period, max(1000 * period, seconds)
    made = ipywidgets.FloatSlider(seconds, min=low, max=high, step=low, readout_format=FORMAT)
    return dressed(made, "duration", "duration (s)", "seconds that are simulated")


def _step() -> Any:
    low, high = np.log10([FINEST, COARSEST])
    made = ipywidgets.FloatLogSlider(STEP, min=low - 1e-12, max=high, step=0.05, readout_format=LOG_FORMAT)
    return dressed(made, "step", "step (s)", "fixed step of the paper's algorithm; its own is 2e-4 s")


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.replace(";", ",").split(",") if part.strip())
    except ValueError as error:
        raise ValueError(
            f"the own state must be numbers with commas between, got {text!r}: write for example 0.01, 0, ..."
        ) from error
