"""Controls of numbers from what is known about a parameter: symbol, unit, meaning, range, scale.

A slider has positions, ascending values among which the parameter's own is one, to the last bit.
`remove_browser_rounding` restores what a browser rounds where it computes a value itself.
"""

from __future__ import annotations

import math
from typing import Any

from frictionlab.analysis.motion_scales import ROUND_NUMBER_RTOL
from frictionlab.components.component import Parameter

from .number_control import CONTROL_WIDTH, LABEL_WIDTH, NumberControl

MAX_SLIDER_STEPS = 300  # most steps of a slider from one end to the other
STEPS_PER_DECADE, LOG_DIGITS = 50, 3
# A browser computes the ends of a range from their places, 20.000000000000004 for 20, and sends them unasked
# when it first shows them.
BROWSER_ROUNDING = 1e-11


def slider(name: str, about: Parameter, value: float) -> NumberControl:
    """A control for a parameter, its CSS class ``fl-<name>``; logarithmic where that fits.

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
    kept = [x for x in between if low < x < high and not equal_within_rounding(x, value)]
    return sorted({low, *kept, value, high})


def label_control(control: Any, name: str, text: str, tooltip: str) -> Any:
    """A control with its label, its tooltip and its CSS class ``fl-<name>``."""
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
    """Fifty a decade, to three digits, so that powers of ten are among them."""
    first, last = (
        round_end(math.log10(end) * STEPS_PER_DECADE)
        for round_end, end in ((math.ceil, low), (math.floor, high))
    )
    return [float(f"{10.0 ** (i / STEPS_PER_DECADE):.{LOG_DIGITS}g}") for i in range(first, last + 1)]


def round_step(span: float) -> float:
    """The next 1, 2 or 5 times a power of ten that makes at most MAX_SLIDER_STEPS steps."""
    if not span > 0:
        return 0.1
    least = span / MAX_SLIDER_STEPS
    power = 10.0 ** math.floor(math.log10(least))
    return next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= least * (1 - ROUND_NUMBER_RTOL))


def round_to_step(value: float, bounds: tuple[float, float]) -> float:
    """A position between two bounds as a round number, in steps of at least a three-hundredth."""
    step = round_step(bounds[1] - bounds[0])
    return min(max(float(f"{step * round(value / step):.9g}"), bounds[0]), bounds[1])


def equal_within_rounding(a: Any, b: Any) -> bool:
    """Whether two values of a control differ by a browser's rounding at most."""
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
