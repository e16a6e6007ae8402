"""Controls of an explorer: sliders, switches and lists, made from a model's metadata, and those of its run.

`ParameterControls` and `ComponentControls` give a model, `RunControls` the Settings for it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import ipywidgets

from frictionlab.analysis.motion_scales import rounded_period
from frictionlab.components.component import Component, Parameter
from frictionlab.components.impact import PlasticImpact, RestitutionImpact
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models.composition import parameter_metadata, parameter_owners, without
from frictionlab.validation import abbreviate

from .number_control import label_control, remove_browser_rounding, slider
from .result import QUICK_METHOD, WHAT_MOVES, Settings

if TYPE_CHECKING:
    from frictionlab.models.model import Model

OPERATION_PARAMETERS = "F", "v"  # the model's own parameters that are changed most in operation
MAX_UNFOLDED = 12  # a model with more parameters has some of them folded away
FOLDED_TITLE = "structure"

IMPACT_LAWS: Mapping[str, Component] = MappingProxyType(
    {
        "plastic, Eq. (13)": PlasticImpact("material"),
        "plastic, full gap rate": PlasticImpact("full"),
        "restitution": RestitutionImpact(),
    }
)

OWN_STATE, FIXED_STEP = "own", "rk4"
INITIAL_STATES = (("rest", "rest"), ("near the equilibrium", "near"), ("own numbers", OWN_STATE))
METHODS = (("quick (Taylor)", QUICK_METHOD), ("exact (Taylor)", Taylor()), ("paper's (RK4)", FIXED_STEP))
SHOWN_PERIODS = 5, 10, 20, 50  # periods
CONTROL_NAMES = "start", "own", "duration", "method", "step", "window", "coordinate"
DEFAULT_STEP, MIN_STEP, MAX_STEP = 2e-4, 2e-5, 1e-2  # s; the paper's step
STEP_TEXT = "fixed step of the paper's algorithm; its own is 2e-4 s"


class ParameterControls:
    """One slider for each parameter; sliders of components that the model lacks are hidden and keep their
    values.

    Attributes
    ----------
    sliders : dict of str to NumberControl
        By the parameter's name.
    main : Box
        The sliders that are always in sight.
    """

    def __init__(self, model: Model, changed: Callable[[Any], None]) -> None:
        self._changed = changed
        self.sliders: dict[str, Any] = {}
        self._start: dict[str, float] = {}
        self._shown: tuple[str, ...] = ()
        layout = ipywidgets.Layout(flex_flow="row wrap")
        self.main, self._rest = ipywidgets.Box(layout=layout), ipywidgets.Box(layout=layout)
        self._more = ipywidgets.Accordion([self._rest], titles=(FOLDED_TITLE,))
        self._more.add_class("fl-structure")
        self.widget = ipywidgets.VBox([self.main, self._more])
        self.show(model)

    def show(self, model: Model) -> None:
        """Show the sliders for the parameters of this model, and no others."""
        names = tuple(model.parameters)
        if names == self._shown:
            return
        about = parameter_metadata(type(model), model.components)
        for name in names:
            if name not in self.sliders:
                self._start[name] = model.parameters[name]
                self.sliders[name] = slider(name, about[name], model.parameters[name])
                self.sliders[name].observe(self._changed, names="value")
        used = main_parameters(model)
        self.main.children = [self.sliders[name] for name in used]
        self._rest.children = [self.sliders[name] for name in names if name not in used]
        self._more.layout.display = "" if self._rest.children else "none"
        self._shown = names

    def values(self, model: Model) -> dict[str, float]:
        """The values of the sliders for the parameters of this model."""
        self.show(model)
        return {
            name: remove_browser_rounding(self.sliders[name].value, self._start[name])
            for name in model.parameters
        }

    def reset(self) -> None:
        """Reset the sliders to their initial values; those added later to the defaults of their law."""
        for name, control in self.sliders.items():
            control.value = self._start[name]

    def close(self) -> None:
        """Close the sliders."""
        for control in self.sliders.values():
            control.close()


def main_parameters(model: Model) -> list[str]:
    """All parameters if they are few; else those of the friction law, of operation, of other components."""
    owner = parameter_owners(type(model), model.components)
    if len(owner) <= MAX_UNFOLDED:
        return list(owner)
    friction = [name for name, role in owner.items() if role == "friction"]
    laws = [name for name, role in owner.items() if role and role != "friction"]
    return [*friction, *(name for name in OPERATION_PARAMETERS if name in owner), *laws]


class ComponentControls:
    """Checkboxes for nonlinearities and a list of impact laws; all other components are the model's.

    Attributes
    ----------
    switches : dict of str to Checkbox
        One for each of the model's `nonlinearities`.
    impact : Dropdown or None
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._full = _with_all(model)
        nonlinearities = model.nonlinearities
        self.switches = {
            name: _switch(name, one.about, not one.missing(model)) for name, one in nonlinearities.items()
        }
        self.impact = _impact_dropdown(model.impact) if "impact" in model.roles else None

    @property
    def controls(self) -> dict[str, Any]:
        """All of them by name."""
        switches = {f"switch-{name}": switch for name, switch in self.switches.items()}
        return switches | ({"impact": self.impact} if self.impact else {})

    def model(self) -> Any:
        """The model with the components chosen, and their own parameters.

        Raises
        ------
        ValueError
            If a law cannot do without its nonlinearity.
        """
        chosen: dict[str, Any] = {}
        if self.impact:
            chosen["impact"] = self.impact.value
        off = [name for name, switch in self.switches.items() if not switch.value]
        nonlinearities = self._model.nonlinearities
        for name in nonlinearities:
            if name not in off:
                chosen |= self._full.get(name, {})
        # A nonlinearity that the initial model lacks is already left out by that model's components.
        lacking = {name for name in off if nonlinearities[name].missing(self._model)}
        chosen |= without(self._model, tuple(name for name in off if name not in lacking))
        return self._model.replace(**chosen)


def _with_all(model: Model) -> dict[str, dict[str, Any]]:
    """Components that restore each nonlinearity a model lacks: the defaults of the model's class."""
    usual = type(model)()
    lacking = {name: one for name, one in model.nonlinearities.items() if one.missing(model)}
    return {name: {key: getattr(usual, key) for key in one.without(model)} for name, one in lacking.items()}


def _switch(name: str, text: str, on: bool) -> Any:
    switch = ipywidgets.Checkbox(on, indent=False)
    switch = label_control(switch, f"switch-{name}", text, f"switches a nonlinearity on and off: {text}")
    switch.layout.width = "auto"
    return switch


def _impact_dropdown(own: Component) -> Any:
    options = dict(IMPACT_LAWS)
    known = {type(law): text for text, law in IMPACT_LAWS.items() if type(law) is not PlasticImpact}
    text = known.get(type(own), next((t for t, law in IMPACT_LAWS.items() if law == own), type(own).__name__))
    options[text] = own
    return label_control(
        ipywidgets.Dropdown(options=list(options.items()), value=own),
        "impact",
        "impact law",
        "what the slider's velocity is after it lands on the belt again",
    )


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

    def settings(self, model: Model) -> Settings:
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


def _window_options(model: Model) -> list[tuple[str, float | str | None]]:
    lengths = [round(count * rounded_period(model), 12) for count in SHOWN_PERIODS]
    return [("what moves", WHAT_MOVES), *((f"last {s:g} s", s) for s in lengths), ("whole run", None)]


def _duration_slider(settings: Settings) -> Any:
    """A slider from ten periods of the model to a thousand, or to the present duration if that is longer."""
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
            f"the own state must be numbers with commas between, "
            f"got {abbreviate(text)}: write for example 0.01, 0, ..."
        ) from error
