"""Controls of the run: initial state, duration, method, and what is shown of it."""

from __future__ import annotations

from typing import Any

import ipywidgets

from frictionlab.analysis.motion_scales import rounded_period
from frictionlab.components.component import Parameter
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.widgets.settings import QUICK_METHOD, WHAT_MOVES, Settings

from .sliders import label_control, remove_browser_rounding, slider

OWN_STATE, FIXED_STEP = "own", "rk4"
INITIAL_STATES = (("rest", "rest"), ("near the equilibrium", "near"), ("own numbers", OWN_STATE))
METHODS = (("quick (Taylor)", QUICK_METHOD), ("exact (Taylor)", Taylor()), ("paper's (RK4)", FIXED_STEP))
SHOWN_PERIODS = 5, 10, 20, 50  # periods
CONTROL_NAMES = "start", "own", "duration", "method", "step", "window", "coordinate"
DEFAULT_STEP, MIN_STEP, MAX_STEP = 2e-4, 2e-5, 1e-2  # s; the paper's step
STEP_TEXT = "fixed step of the paper's algorithm; its own is 2e-4 s"


class RunControls:
    """Drop-down lists and sliders that say how a model is run.

    Attributes
    ----------
    start, own, duration, method, step, window, coordinate : widgets
    """

    def __init__(self, settings: Settings) -> None:
        drop, names = ipywidgets.Dropdown, settings.model.coordinates
        self.start = label_control(drop(options=INITIAL_STATES), "start", "start", "initial state")
        self.own = _state_field(names)
        self.duration, self._t_end = _duration_slider(settings), settings.t_end
        text = "quick: tolerance 1e-7, flights below 0.4 ms replaced by their limit; exact: to rounding"
        self.method = label_control(drop(options=METHODS, value=settings.method), "method", "method", text)
        self.step = _step_slider()
        text = "part of the run that the panels show; the spectrum is of the run's second half"
        self.window = label_control(
            drop(options=_window_options(settings.model), value=settings.window), "window", "shown", text
        )
        text = "coordinate of the phase plane and the spectrum"
        self.coordinate = label_control(drop(options=names), "coordinate", "coordinate", text)
        layout = ipywidgets.Layout(flex_flow="row wrap")
        self.widget = ipywidgets.Box(list(self.controls.values()), layout=layout)

    @property
    def controls(self) -> dict[str, Any]:
        """All of them by name."""
        return {name: getattr(self, name) for name in CONTROL_NAMES}

    def settings(self, model: Any) -> Settings:
        """The settings for a model.

        Raises
        ------
        ValueError
            Where the initial state is no list of numbers.
        """
        self.own.layout.display = "" if self.start.value == OWN_STATE else "none"
        self.step.layout.display = "" if self.method.value == FIXED_STEP else "none"
        start = _parse_state(self.own.value) if self.start.value == OWN_STATE else self.start.value
        step = remove_browser_rounding(self.step.value, DEFAULT_STEP)
        method = RK4(step=step) if self.method.value == FIXED_STEP else self.method.value
        chosen = self.coordinate.value
        coordinate = chosen if chosen in model.coordinates else model.coordinates[0]
        t_end = remove_browser_rounding(self.duration.value, self._t_end)
        return Settings(model, t_end, start, method, self.window.value, coordinate)


def _state_field(names: tuple[str, ...]) -> Any:
    text = f"coordinates {', '.join(names)}, then their rates, with commas between"
    return label_control(
        ipywidgets.Text(_zero_state_text(names), continuous_update=False), "own", "state", text
    )


def _zero_state_text(names: tuple[str, ...]) -> str:
    return ", ".join(["0"] * 2 * len(names))


def _window_options(model: Any) -> list[tuple[str, float | str | None]]:
    lengths = [round(count * rounded_period(model), 12) for count in SHOWN_PERIODS]
    return [("what moves", WHAT_MOVES), *((f"last {s:g} s", s) for s in lengths), ("whole run", None)]


def _duration_slider(settings: Settings) -> Any:
    """From ten periods of the model to a thousand."""
    period, seconds = rounded_period(settings.model), settings.t_end
    ends = 10 * period, max(1000 * period, seconds)
    about = Parameter("", "s", "seconds that are simulated", exclusive_minimum=0.0, range=ends)
    return _described(slider("duration", about, seconds), "duration (s)")


def _step_slider() -> Any:
    about = Parameter("", "s", STEP_TEXT, exclusive_minimum=0.0, range=(MIN_STEP, MAX_STEP), log=True)
    return _described(slider("step", about, DEFAULT_STEP), "step (s)")


def _described(control: Any, text: str) -> Any:
    control.description = text
    return control


def _parse_state(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.replace(";", ",").split(",") if part.strip())
    except ValueError as error:
        raise ValueError(
            f"the own state must be numbers with commas between, got {text!r}: write for example 0.01, 0, ..."
        ) from error
