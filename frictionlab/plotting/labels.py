"""Labels of axes, legends and titles: symbols of states and of parameters, with their units and values.

States are named by their letters, parameters by the symbol, meaning and unit of their own metadata.
"""

from __future__ import annotations

import re
from collections.abc import Container, Sequence
from textwrap import fill
from typing import Any

from frictionlab.components.component import Parameter
from frictionlab.letters import ANGLE_LETTERS
from frictionlab.models.composition import parameters_of_model
from frictionlab.models.model import Model, ModelOrAutomaton
from frictionlab.presentation import TIME, is_angle, unit_of_state
from frictionlab.stability.equilibrium_points.frozen_time import FrozenAutomaton

LEGEND_WIDTH = 36  # characters of a line in a legend


def secondary_axis_angles(names: Sequence[str]) -> tuple[str, ...]:
    """The angles that need an axis of their own: all angles where there are lengths too, else none."""
    angles = tuple(filter(is_angle, names))
    return () if len(angles) == len(names) else angles


def coordinate_axis_label(names: Sequence[str]) -> str:
    """Label of the axis on the left, which shows coordinates."""
    return (
        "displacement (m)" if secondary_axis_angles(names) or not any(map(is_angle, names)) else "angle (rad)"
    )


def state_label(name: str) -> str:
    """The name as a reader expects it in a legend or on an axis: subscripts, dots, Greek letters.

    A name that is more than letters and an index, such as "a$b" or "gap_left", is shown as it is.
    """
    parts = re.fullmatch(r"([^\W\d_]+)(?:_?(\d+)|_([^\W_]+))?('*)", name)
    if parts is None or (parts[3] and parts[1] not in ANGLE_LETTERS and len(parts[1]) > 1):
        return name.replace("$", r"\$")
    letter = ANGLE_LETTERS.get(parts[1], parts[1])
    letter = rf"\dot{{{letter}}}" if parts[4] else letter
    word = parts[3] and (parts[3] if len(parts[3]) == 1 else rf"\mathrm{{{parts[3]}}}")
    index = parts[2] or word
    return f"${letter}_{{{index}}}$" if index else f"${letter}$"


def state_with_unit(source: Any, name: str) -> str:
    """The name as above, and the unit if the model that is the source of a run, or of a result, tells it."""
    return with_unit(name, unit_of_state(source, name))


def with_unit(name: str, unit: str) -> str:
    """The name as above, and a unit unless that is "", as where it is not known."""
    return f"{state_label(name)} ({unit})" if unit else state_label(name)


def parameter_symbol(model: ModelOrAutomaton, name: str) -> str:
    """Symbol of a parameter as matplotlib's mathtext; an automaton has no metadata, so there the name."""
    about = _parameter_metadata(model, name)
    return f"${about.symbol}$" if about else name


def parameter_label(model: ModelOrAutomaton, name: str) -> str:
    """Meaning, symbol and unit of a parameter, for an axis."""
    about = _parameter_metadata(model, name)
    if about is None:
        return name
    meaning = about.meaning and f"{about.meaning} "
    return (
        f"{meaning}{parameter_symbol(model, name)}{about.unit and f' ({superscript_exponents(about.unit)})'}"
    )


def parameter_value_text(model: ModelOrAutomaton, name: str, value: float) -> str:
    """ "symbol = value unit", for a legend or a title."""
    about = _parameter_metadata(model, name)
    unit = f" {superscript_exponents(about.unit)}" if about and about.unit else ""
    return f"{parameter_symbol(model, name)} = {_number_text(value)}{unit}"


def distinguishing_labels(models: Sequence[ModelOrAutomaton], varied: Container[str] = ()) -> list[str]:
    """Labels that distinguish models in a legend: parameter values that differ, else the models' reprs.

    Parameters
    ----------
    models : sequence of Model or HybridAutomaton
    varied : container of str
        Parameters that are left out, since the axes show them.
    """
    with_metadata = [model for model in models if isinstance(model, Model)]
    structures = {*(each.structure_key for each in with_metadata)}
    alike = len(with_metadata) == len(models) and len(structures) == 1
    names = [
        name
        for name in (with_metadata[0].parameters if alike else ())
        if name not in varied and len({model.parameters[name] for model in with_metadata}) > 1
    ]
    if len(models) == 1:
        return [repr(models[0])]
    if not names:
        return [fill(repr(model), LEGEND_WIDTH, break_long_words=False) for model in models]
    return [
        ", ".join(parameter_value_text(model, name, model.parameters[name]) for name in names)
        for model in with_metadata
    ]


def check_compared(what: str, parameters: Sequence[str], labels: Sequence[str]) -> None:
    """Raise ValueError unless all that is drawn together is over the same parameters and has a label."""
    if len(names := sorted({*parameters})) != 1:
        got = ", ".join(names) or "none"
        raise ValueError(f"{what} must be over the same parameters, got {got}: draw them apart")
    if len(labels) != len(parameters):
        raise ValueError(f"there must be a label for each of {len(parameters)} {what}, got {len(labels)}")


def superscript_exponents(unit: str) -> str:
    """A unit with its exponents raised: N/m^3 becomes N/m³."""
    return re.sub(r"\^(-?[\d.]+)", r"$^{\1}$", unit)


def _number_text(value: float) -> str:
    mantissa, _, exponent = f"{value:.6g}".partition("e")
    if not exponent and abs(value) >= 1e4:
        mantissa, _, exponent = f"{value:.5e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".")
    if not exponent:
        return mantissa
    factor = "" if mantissa == "1" else rf"{mantissa} \cdot "
    return f"${factor}10^{{{int(exponent)}}}$"


def _parameter_metadata(model: ModelOrAutomaton, name: str) -> Any:
    if isinstance(model, FrozenAutomaton) and name == TIME:
        return Parameter(symbol="t", unit="s", meaning="time")
    if not isinstance(model, Model):
        return None
    return parameters_of_model(model).get(name)
