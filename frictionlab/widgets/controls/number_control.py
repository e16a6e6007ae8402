"""A control of one number: its label, a slider, a field to type into, and a message where what is typed is
no value.

A slider of the browser computes its value from where it stands, and so can tell a value that nobody chose.
Here it counts positions, whose values are made in Python: to show a number changes none.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from importlib import resources
from typing import Any

import anywidget
import ipywidgets
import traitlets

from frictionlab.components.component import Parameter, check_value

LABEL_WIDTH, CONTROL_WIDTH = "92px", "310px"
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")


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
        It may be infinite, where the text has more digits than a float.

    Raises
    ------
    ValueError
        If it is no number, or one with a comma that may stand for thousands.

    Examples
    --------
    >>> number_from_text("mu_k", "0,5"), number_from_text("F", "2e2")
    (0.5, 200.0)
    """
    typed = text.strip().replace("\N{MINUS SIGN}", "-")
    if THOUSANDS.fullmatch(typed):
        plain, decimal = typed.replace(",", ""), typed.replace(",", ".", 1)
        cure = f"write {plain} or {decimal}0" if typed.count(",") == 1 else f"write {plain}"
        raise ValueError(f"{name} must be one number, got {text!r}, whose comma has two meanings: {cure}")
    if not NUMBER.fullmatch(typed.replace(",", ".", 1)):
        raise ValueError(f"{name} must be one number, got {text!r}: write for example 0.5 or 2e4")
    return float(typed.replace(",", ".", 1))


class NumberField(anywidget.AnyWidget):
    """Slider, field and message, as the browser shows them.

    Attributes
    ----------
    value : float
    positions : list of float
        The values that the slider can be moved to, ascending.
    unit, meaning : str
        What a screen reader says of it.
    hint : str
        Shown where the pointer rests on it.
    message : str
        Shown below.
    continuous_update : bool
        Whether the slider tells values while it is held.
    """

    _esm = (
        resources.files("frictionlab.widgets.controls")
        .joinpath("number_control.js")
        .read_text(encoding="utf-8")
    )
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
        In messages, and the CSS class ``fl-<name>``.
    about : Parameter
        Symbol, unit, meaning, and the bounds that values keep to.
    value : float
    positions : sequence of float
        The values that its slider can be moved to, ascending, among them `value`.
    rule : callable or None
        Takes a number that is typed and raises ValueError where it is none for this control; None asks for
        the bounds.

    Attributes
    ----------
    value : float
        A value beyond the ends, set in Python, moves the end.
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
        # A label lays out symbol and unit side by side, and drops a plain space between them.
        self.label.value = text.replace(" ", "\N{NO-BREAK SPACE}")

    # Not the trait of that name: the view of a box with a tooltip fails, for want of a description.
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
        """Why what was typed last is no value; empty where it was."""
        return self.field.message

    @property
    def continuous_update(self) -> bool:
        """Whether values come while the slider is held."""
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
        """Raise ValueError for a number that breaks the rule of this control, whatever the slider's ends."""
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
            if part := getattr(self, name, None):  # none where it was never finished
                part.close()
        super().close()
