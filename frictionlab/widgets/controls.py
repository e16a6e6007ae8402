"""Controls of an explorer: the values of its state, each of which can be observed and linked to any widget.

`controls_of` makes them of the data of `frictionlab.pages.scene`, which the front end shows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import traitlets

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import Parameter, check_value
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models.composition import without
from frictionlab.models.model import (
    automaton_of,
    nonlinearities_in,
    parameters_about,
)
from frictionlab.pages.scene import (
    DURATION,
    Data,
    Shown,
    choice,
    law_menus,
    number,
    scene_controls,
    windows,
)
from frictionlab.validation import abbreviate, check_number, did_you_mean

from .result import QUICK_METHOD, Settings

OWN_STATE, FIXED_STEP = "own", "rk4"
METHODS = {"quick (Taylor)": QUICK_METHOD, "exact (Taylor)": Taylor(), "paper's (RK4)": FIXED_STEP}
DEFAULT_STEP, MIN_STEP, MAX_STEP = 2e-4, 2e-5, 1e-2  # s; the paper's step
STEP = Parameter("", "s", "fixed step; the paper's is 2e-4 s", exclusive_minimum=0.0, log=True)
METHOD_HINT = (
    "quick: tolerance 1e-7, flights below 0.4 ms replaced by their limit; exact: to rounding; "
    "paper's: a fixed step"
)

State = dict[str, Any]


class Control(traitlets.HasTraits):
    """One value of an explorer: set ``value``, observe ``value``, link it to any widget.

    Parameters
    ----------
    about : dict
        What the front end shows, see `frictionlab.pages.scene`.
    values : mapping of str to object, or None
        Of a menu, what its options stand for; None where an option is its own value.
    rule : Parameter or None
        Bounds of a number.
    """

    value = traitlets.Any()

    def __init__(
        self, about: Data, values: Mapping[str, Any] | None = None, rule: Parameter | None = None
    ) -> None:
        self.about, self.rule = about, rule
        self.values = values if values is not None else {o: o for o in about.get("options", ())}
        super().__init__(value=self._value_of(about["value"]))

    @property
    def name(self) -> str:
        """The control's name."""
        return self.about["name"]

    @property
    def min(self) -> float:
        """Where its slider begins."""
        return self.about["low"]

    @property
    def max(self) -> float:
        """Where its slider ends."""
        return self.about["high"]

    @property
    def options(self) -> tuple[str, ...]:
        """What a menu offers."""
        return tuple(self.values)

    @property
    def data(self) -> Any:
        """The value as data that JSON can hold; of a menu, the option."""
        if self.about["kind"] == "choice":
            return next((option for option, value in self.values.items() if value == self.value), self.value)
        return list(self.value) if isinstance(self.value, tuple) else self.value

    @property
    def label(self) -> str:
        """The option of a menu that is chosen."""
        return self.data

    @label.setter
    def label(self, option: str) -> None:
        self.set_data(option)

    def set_data(self, data: Any) -> None:
        """Set the value to what :attr:`data` gave.

        Raises
        ------
        ValueError
            If the control cannot have it.
        """
        self.value = self._value_of(data)

    def _value_of(self, data: Any) -> Any:
        kind = self.about["kind"]
        if kind == "number":
            checked = check_number(self.name, data, cure="give one number, such as 0.5 or 2e4")
            if self.rule is not None:
                check_value(self.name, checked, self.rule)
            return float(checked)
        if kind == "choice" and data in self.values:
            return self.values[data]
        if isinstance(data, {"switch": bool, "text": str, "formula": str}.get(kind, ())):
            return data
        if kind == "range" and isinstance(data, (list, tuple)) and len(data) == 2 and data[0] < data[1]:
            return float(data[0]), float(data[1])
        raise ValueError(
            f"{self.name} must be a value of its control, got {abbreviate(data)}: take one that the explorer "
            "shows"
        )


def controls_of(settings: Settings) -> dict[str, Control]:
    """All controls of an explorer that begins with these settings."""
    model, menus = settings.model, law_menus(settings.model)
    models = list(_reachable(model, menus))
    about_run = settings.period, settings.t_end, settings.x0
    method = next(option for option, value in METHODS.items() if value == settings.method)
    step = number("step", STEP, DEFAULT_STEP, "run", (MIN_STEP, MAX_STEP))
    abouts = [
        *scene_controls(models, nonlinearities_in(model), menus, about_run),
        choice("method", METHODS, method, "run", hint=METHOD_HINT),
        step | {"when": ["method", "paper's (RK4)"]},
    ]
    values = {**menus, "window": windows(settings.period), "method": METHODS}
    rules = {"duration": DURATION, "step": STEP}
    for each in models:
        rules = {**parameters_about(each, model), **rules}
    made = (Control(about, values.get(about["name"]), rules.get(about["name"])) for about in abouts)
    return {control.name: control for control in made}


def _reachable(model: Shown, menus: Mapping[str, Mapping[str, Any]]) -> Iterator[Shown]:
    """The model, and those that its switches and its menus of laws lead to, for their parameters."""
    yield model
    if isinstance(model, HybridAutomaton):
        return
    full = composed(model)
    yield full
    for role, laws in menus.items():
        for law in laws.values():
            yield full.replace(**{role: law})


@lru_cache(maxsize=32)
def composed(model: Any, off: tuple[str, ...] = (), laws: tuple[tuple[str, Any], ...] = ()) -> Any:
    """A model with all its nonlinearities but those that are `off`, and with these laws, by their roles.

    Those that the model lacks come from the defaults of its class.
    """
    lacking = {name: one for name, one in nonlinearities_in(model).items() if one.missing(model)}
    usual, changes = type(model)() if lacking else model, dict(laws)
    for name, one in lacking.items():
        if name not in off:
            changes |= {key: getattr(usual, key) for key in one.without(model)}
    # A nonlinearity that the model lacks is already left out by its own components.
    changes |= without(model, tuple(name for name in off if name not in lacking))
    return model.replace(**changes)


def chosen_model(model: Shown, controls: Mapping[str, Control]) -> Shown:
    """The model or automaton that the controls are set to, from the one with which they were made.

    Raises
    ------
    ValueError
        If a law cannot do without its nonlinearity, or a parameter breaks a rule.
    """
    if isinstance(model, HybridAutomaton):
        return model.replace(**{name: controls[name].value for name in model.values})
    off = tuple(name for name in model.nonlinearities if not controls[f"switch-{name}"].value)
    laws = tuple((role, controls[role].value) for role in model.roles if role in controls)
    chosen = composed(model, off, laws)
    return chosen.replace(**{name: controls[name].value for name in chosen.parameters})


def chosen_settings(model: Shown, controls: Mapping[str, Control], period: float) -> Settings:
    """The settings for a model in an explorer of this period (s), where the model states none.

    Raises
    ------
    ValueError
        Where the initial state is no list of numbers.
    """
    value = {name: control.value for name, control in controls.items()}
    start = parse_state(value["own"]) if value["start"] == OWN_STATE else value["start"]
    method: Method = RK4(step=value["step"]) if value["method"] == FIXED_STEP else value["method"]
    chosen, automaton = value["coordinate"], automaton_of(model)
    coordinate = chosen if chosen in automaton.shown_states else automaton.shown_state
    period = getattr(model, "period", None) or period
    return Settings(model, value["duration"], start, method, value["window"], coordinate, period)


def parse_state(text: str) -> tuple[float, ...]:
    """The numbers of a state that was typed."""
    try:
        return tuple(float(part) for part in text.replace(";", ",").split(",") if part.strip())
    except ValueError as error:
        raise ValueError(
            f"the own state must be numbers with commas between, "
            f"got {abbreviate(text)}: write for example 0.01, 0, ..."
        ) from error


def set_state(controls: Mapping[str, Control], state: Mapping[str, Any]) -> None:
    """Set controls to values as data; where one of them cannot be set, none is.

    Raises
    ------
    ValueError
        If no control has such a name, or a control cannot have its value.
    """
    for name in state:
        if name not in controls:
            hint = did_you_mean(name, list(controls))
            raise ValueError(f"the explorer must have the control {name!r}, got none of that name{hint}")
    before = {name: controls[name].value for name in state}
    try:
        for name, data in state.items():
            if controls[name].data != data:
                controls[name].set_data(data)
    except (TypeError, ValueError):
        for name, value in before.items():
            controls[name].value = value
        raise
