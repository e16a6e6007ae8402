"""A control of one number: its label, a slider, a field to type into, and a message where what is typed is
not accepted.

A browser's slider computes its value from its position, and so may report a value that nobody chose.  This
one counts positions, whose values Python makes: showing a number does not change it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from importlib import resources
from typing import Any

import anywidget
import ipywidgets
import traitlets

from frictionlab.analysis.motion_scales import ROUND_NUMBER_RTOL
from frictionlab.components.component import Parameter, check_value
from frictionlab.validation import abbreviate

LABEL_WIDTH, CONTROL_WIDTH = "7.1em", "24em"
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")
MAX_SLIDER_STEPS = 300  # most steps of a slider from one end to the other
STEPS_PER_DECADE, LOG_DIGITS = 50, 3
# A browser computes the ends of a range from their positions, 20.000000000000004 for 20, and sends them
# unasked when it first shows them.
BROWSER_ROUNDING = 1e-11


def number_from_text(name: str, text: str) -> float:
    """The number that is typed, with a point or a comma before its decimals.

    Parameters
    ----------
    name : str
        For the message.
    text : str

    Returns
    -------
    float
        Infinite where the number in the text is too large for a float.

    Raises
    ------
    ValueError
        If it is no number, or its comma may separate thousands.

    Examples
    --------
    >>> number_from_text("mu_k", "0,5"), number_from_text("F", "2e2")
    (0.5, 200.0)
    """
    typed = text.strip().replace("\N{MINUS SIGN}", "-")
    if THOUSANDS.fullmatch(typed):
        plain, decimal = typed.replace(",", ""), typed.replace(",", ".", 1)
        cure = f"write {plain} or {decimal}0" if typed.count(",") == 1 else f"write {plain}"
        raise ValueError(
            f"{name} must be one number, got {abbreviate(text)}, whose comma has two meanings: {cure}"
        )
    if not NUMBER.fullmatch(typed.replace(",", ".", 1)):
        raise ValueError(f"{name} must be one number, got {abbreviate(text)}: write for example 0.5 or 2e4")
    return float(typed.replace(",", ".", 1))


class NumberField(anywidget.AnyWidget):
    """Slider, field and message, as the browser shows them.

    Attributes
    ----------
    value : float
    positions : list of float
        The values that the slider can be moved to, ascending.
    unit, meaning : str
        What a screen reader says about it.
    hint : str
        Shown where the pointer rests on it.
    message : str
        Shown below.
    continuous_update : bool
        Whether the slider reports values while it is held.
    """

    _esm = resources.files("frictionlab.widgets").joinpath("number_control.js").read_text(encoding="utf-8")
    value = traitlets.Float().tag(sync=True)
    positions = traitlets.List(traitlets.Float()).tag(sync=True)
    unit = traitlets.Unicode().tag(sync=True)
    meaning = traitlets.Unicode().tag(sync=True)
    hint = traitlets.Unicode().tag(sync=True)  # the name tooltip makes views fail
    message = traitlets.Unicode().tag(sync=True)
    continuous_update = traitlets.Bool(True).tag(sync=True)


class NumberControl(ipywidgets.HBox):
    """One number with its label: set ``value``, observe ``value``.

    Parameters
    ----------
    name : str
        Used in messages and in the CSS class ``fl-<name>``.
    about : Parameter
        Symbol, unit, meaning, and the bounds of the value.
    value : float
    positions : sequence of float
        The values that its slider can be moved to, ascending; `value` is one of them.
    rule : callable or None
        Takes a number and raises ValueError where this control cannot have it; None checks the bounds of
        `about`.

    Attributes
    ----------
    value : float
        A value set in Python beyond an end of the slider moves that end.
    field : NumberField
    """

    value = traitlets.Float()

    def __init__(
        self,
        name: str,
        about: Parameter,
        value: float,
        positions: Sequence[float],
        rule: Callable[[float], Any] | None = None,
    ) -> None:
        self.name, self.about = name, about
        self._rule = rule or (lambda number: check_value(name, number, about))
        self.label = ipywidgets.Label(layout=ipywidgets.Layout(width=LABEL_WIDTH, flex="none"))
        self.label.layout.justify_content = "flex-end"
        self.field = NumberField(value=value, positions=list(positions), unit=about.unit)
        self.field.layout = ipywidgets.Layout(flex="1 1 0", min_width="0")
        self.field.meaning = about.meaning or name
        super().__init__([self.label, self.field], value=value)
        self.layout = ipywidgets.Layout(width=CONTROL_WIDTH, max_width="100%")
        self.add_class(f"fl-{name}").add_class("fl-control").add_class("fl-number")
        self.field.observe(self._moved, names="value")
        self.field.on_msg(self._heard)
        self.observe(self._show, names="value")

    @property
    def description(self) -> str:
        """The label."""
        return self.label.value.replace("\N{NO-BREAK SPACE}", " ")

    @description.setter
    def description(self, text: str) -> None:
        # The label sets symbol and unit side by side and would drop a plain space between them.
        self.label.value = text.replace(" ", "\N{NO-BREAK SPACE}")

    # Not the trait of that name: a box with a tooltip cannot be shown, as it has no description.
    @property
    def tooltip(self) -> str:
        """What is shown where the pointer rests on the control."""
        return self.field.hint

    @tooltip.setter
    def tooltip(self, text: str) -> None:
        self.field.hint = text

    @property
    def positions(self) -> tuple[float, ...]:
        """The values that the slider can be moved to."""
        return tuple(self.field.positions)

    @property
    def min(self) -> float:
        """The smallest of them."""
        return self.field.positions[0]

    @property
    def max(self) -> float:
        """The largest of them."""
        return self.field.positions[-1]

    @property
    def message(self) -> str:
        """Why what was typed last is not accepted; empty where it is."""
        return self.field.message

    @property
    def continuous_update(self) -> bool:
        """Whether the slider reports values while it is held."""
        return self.field.continuous_update

    @continuous_update.setter
    def continuous_update(self, each: bool) -> None:
        self.field.continuous_update = each

    def type(self, text: str) -> None:
        """Do what typing this text into the field does: take the number, or say why not."""
        try:
            number = number_from_text(self.name, text)
            self._check_inside(number)
        except (TypeError, ValueError) as error:
            self.field.message = f"{error}. The value is still {self.value:.7g}."
            return
        self.field.message = ""
        self.value = number

    def check(self, number: float) -> None:
        """Raise ValueError for a number that breaks the control's rule; the slider's ends do not matter."""
        self._rule(number)

    def _check_inside(self, number: float) -> None:
        ends = f"The slider goes from {self.min:.7g} to {self.max:.7g}"
        try:
            self.check(number)
        except ValueError as error:
            raise ValueError(f"{error}. {ends}") from error
        if not self.min <= number <= self.max:
            rule = f"from {self.min:.7g} to {self.max:.7g} here"
            cure = "set it in Python, where it may be beyond the slider"
            raise ValueError(f"{self.name} must be {rule}, got {number:g}: take one between, or {cure}")

    def _moved(self, change: Any) -> None:
        self.value = change["new"]

    def _show(self, change: Any) -> None:
        value, ends = change["new"], (self.min, self.max)
        if not ends[0] <= value <= ends[1]:
            self.field.positions = sorted({*self.field.positions, value})
        self.field.value, self.field.message = value, ""

    def _heard(self, _: Any, content: Any, __: Any) -> None:
        if isinstance(content, dict) and isinstance(content.get("typed"), str):
            self.type(content["typed"])

    def close(self) -> None:
        """Close all parts."""
        for name in ("label", "field"):
            if part := getattr(self, name, None):  # None where the constructor failed
                part.close()
        super().close()


def slider(name: str, about: Parameter, value: float) -> NumberControl:
    """A control for a parameter, with the CSS class ``fl-<name>``; logarithmic where that fits.

    The range is that of the parameter, made wide enough for the value; without one it goes up to twice the
    value, within the parameter's bounds.
    """
    low, high = slider_range(about, value)
    logarithmic = about.log and low > 0
    made = NumberControl(name, about, value, slider_positions(low, high, value, logarithmic))
    rule = "logarithmic" if logarithmic else "linear"
    made.tooltip = (
        f"{about.meaning or name}{about.unit and f', {about.unit}'} ({name}, {low:g} to {high:g}, {rule})"
    )
    made.description = parameter_description(about)
    return made


def slider_positions(low: float, high: float, value: float, logarithmic: bool) -> list[float]:
    """The values of a slider: both ends, round numbers between them, and the value itself to the last bit."""
    between = _logarithmic_values(low, high) if logarithmic else _linear_values(low, high)
    inner = [x for x in between if low < x < high and not equal_within_rounding(x, value)]
    return sorted({low, *inner, value, high})


def label_control(control: Any, name: str, text: str, tooltip: str) -> Any:
    """Give a control its label, its tooltip and the CSS class ``fl-<name>``; returns it."""
    control.description, control.tooltip = text, tooltip
    control.style.description_width = LABEL_WIDTH
    control.layout.width, control.layout.max_width = CONTROL_WIDTH, "100%"
    control.add_class(f"fl-{name}").add_class("fl-control")
    return control


def parameter_description(about: Parameter) -> str:
    """Symbol in LaTeX, and unit."""
    unit = about.unit.replace("^2", "²").replace("^3", "³")
    return f"${about.symbol}$" + (f" ({unit})" if unit else "")


def slider_range(about: Parameter, value: float) -> tuple[float, float]:
    """Where a slider for a parameter begins and ends."""
    low, high = about.range or _default_range(about, value)
    if about.log and low <= 0 < value:
        low = min(value, high) / 1e3
    return min(low, value), max(high, value)


def _default_range(about: Parameter, value: float) -> tuple[float, float]:
    twice = 2 * abs(value) or 1.0
    bounds = [b for b in (about.minimum, about.exclusive_minimum) if b is not None]
    # An exclusive bound is no admissible value itself.
    least = (
        -math.inf if not bounds else bounds[0] + (twice / MAX_SLIDER_STEPS if about.minimum is None else 0.0)
    )
    low = max(least, 0.0 if value > 0 else -twice)
    return low, min(max(twice, low + twice), math.inf if about.maximum is None else about.maximum)


def _linear_values(low: float, high: float) -> list[float]:
    """Multiples of a round step."""
    step = round_step(high - low)
    first, last = math.ceil(low / step), math.floor(high / step)
    return [float(f"{i * step:.9g}") for i in range(first, last + 1)]


def _logarithmic_values(low: float, high: float) -> list[float]:
    """Fifty values in a decade, rounded to three digits, powers of ten among them."""
    first, last = (
        round_end(math.log10(end) * STEPS_PER_DECADE)
        for round_end, end in ((math.ceil, low), (math.floor, high))
    )
    return [float(f"{10.0 ** (i / STEPS_PER_DECADE):.{LOG_DIGITS}g}") for i in range(first, last + 1)]


def round_step(span: float) -> float:
    """The smallest 1, 2 or 5 times a power of ten that makes at most MAX_SLIDER_STEPS steps."""
    if not span > 0:
        return 0.1
    least = span / MAX_SLIDER_STEPS
    power = 10.0 ** math.floor(math.log10(least))
    return next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= least * (1 - ROUND_NUMBER_RTOL))


def round_to_step(value: float, bounds: tuple[float, float]) -> float:
    """A value between two bounds, rounded to a multiple of :func:`round_step` of their distance."""
    step = round_step(bounds[1] - bounds[0])
    return min(max(float(f"{step * round(value / step):.9g}"), bounds[0]), bounds[1])


def equal_within_rounding(a: Any, b: Any) -> bool:
    """Whether two values of a control differ at most by a browser's rounding."""
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(equal_within_rounding, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=BROWSER_ROUNDING)
    return a == b


def remove_browser_rounding(value: float, start: float) -> float:
    """The value that a slider is meant to have: its initial value, a number of few digits, or itself."""
    return next(
        number for number in (start, float(f"{value:.9g}"), value) if equal_within_rounding(value, number)
    )
