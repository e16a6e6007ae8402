"""Sliders from what is known about a parameter: symbol, unit, meaning, range, scale.

A browser computes a slider's value from its position and so rounds it; `remove_browser_rounding` restores the
intended value.
"""

from __future__ import annotations

import math
from typing import Any

import ipywidgets

from frictionlab.analysis.motion_scales import ROUND_NUMBER_RTOL
from frictionlab.components.component import Parameter

MAX_SLIDER_STEPS = 300  # most steps of a slider from one end to the other
STEPS_PER_DECADE = 50
CONTROL_WIDTH = "310px"
# Plain notation without commas, as typed numbers must not contain commas.
READOUT_FORMAT = ".7"
LOG_READOUT_FORMAT = ".4r"  # four digits: these values are not round
# A browser computes a slider's value from its position, 20.000000000000004 for 20, a logarithmic one's from
# its exponent, 0.9999999999977 for 1, and sends it unasked when it first shows the slider.
BROWSER_ROUNDING = 1e-11
END_MARGIN = 1e-12  # decades by which a slider goes beyond its ends, whose logarithms are rounded
STEP_MISS = 1e-6  # of a step: a value so near to a whole number of them is one


def slider(name: str, about: Parameter, value: float) -> Any:
    """A slider for a parameter, its CSS class ``fl-<name>``; logarithmic where that fits.

    The range is that of the parameter, made wide enough for the value; without one it goes up to twice the
    value, within the parameter's bounds.
    """
    low, high = slider_range(about, value)
    logarithmic = about.log and low > 0
    made = _logarithmic_slider(low, high, value) if logarithmic else _linear_slider(low, high, value)
    rule = "logarithmic" if logarithmic else "linear"
    text = f"{about.meaning or name}{about.unit and f', {about.unit}'} ({name}, {low:g} to {high:g}, {rule})"
    return label_control(made, name, parameter_description(about), text)


def label_control(control: Any, name: str, text: str, tooltip: str) -> Any:
    """A control with its label, its tooltip and its CSS class ``fl-<name>``."""
    control.description, control.tooltip = text, tooltip
    control.style.description_width = "92px"
    control.layout = ipywidgets.Layout(width=CONTROL_WIDTH, max_width="100%")
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


def _linear_slider(low: float, high: float, value: float) -> Any:
    step = _step_to_value(round_step(high - low), value - low)
    return ipywidgets.FloatSlider(
        value, min=low, max=high, step=step, readout_format=READOUT_FORMAT, continuous_update=True
    )


def _logarithmic_slider(low: float, high: float, value: float) -> Any:
    exponent, least = math.log10(value), math.log10(low)
    steps = max(1, round((exponent - least) * STEPS_PER_DECADE))
    return ipywidgets.FloatLogSlider(
        value,
        base=10.0,
        min=math.log10(low) - END_MARGIN,
        max=math.log10(high) + END_MARGIN,
        step=(exponent - least) / steps if exponent > least else 1 / STEPS_PER_DECADE,
        readout_format=LOG_READOUT_FORMAT,
        continuous_update=True,
    )


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


def refine_step(control: Any, value: float) -> None:
    """Make the steps of a slider so fine that it can show a value: a browser would round it."""
    if isinstance(control, ipywidgets.FloatSlider):
        step = control.step or round_step(control.max - control.min)
        control.step = _step_to_value(step, value - control.min)


def _step_to_value(step: float, distance: float) -> float:
    """The step, or a finer one that leads to the value: else the browser would show another one."""
    for finer in (step / n for n in (1, 2, 5, 10, 20, 50, 100)):
        if abs(distance / finer - round(distance / finer)) < STEP_MISS:
            return finer
    return step


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
