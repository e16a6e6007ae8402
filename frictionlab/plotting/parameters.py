"""Parameters as they stand at an axis or in a legend: symbol and unit from their own metadata."""

from __future__ import annotations

import re
from collections.abc import Container, Sequence
from textwrap import fill
from typing import Any

from frictionlab.models.namespace import about_all
from frictionlab.models.symbols import structure

WIDE = 36  # characters of a line in a legend


def parameter_symbol(model: Any, name: str) -> str:
    """Symbol of a parameter as matplotlib sets it; of an automaton's, which has no metadata, the name."""
    about = _about(model, name)
    return f"${about.symbol}$" if about else name


def parameter_label(model: Any, name: str) -> str:
    """Meaning, symbol and unit of a parameter, for an axis."""
    about = _about(model, name)
    if about is None:
        return name
    meaning = about.meaning and f"{about.meaning} "
    return f"{meaning}{parameter_symbol(model, name)}{about.unit and f' ({raised(about.unit)})'}"


def parameter_value(model: Any, name: str, value: float) -> str:
    """ "symbol = value unit", for a legend or a title."""
    about = _about(model, name)
    unit = f" {raised(about.unit)}" if about and about.unit else ""
    return f"{parameter_symbol(model, name)} = {_short(value)}{unit}"


def distinct_names(models: Sequence[Any], varied: Container[str] = ()) -> list[str]:
    """What tells models apart, for a legend: the values that differ, else the models in short lines.

    Parameters
    ----------
    models : sequence of Model or HybridAutomaton
    varied : container of str
        Parameters that are left out, as a picture shows them at its axes.
    """
    alike = all(hasattr(model, "components") for model in models) and len({*map(structure, models)}) == 1
    names = [
        name
        for name in (models[0].parameters if alike else ())
        if name not in varied and len({model.parameters[name] for model in models}) > 1
    ]
    if len(models) == 1:
        return [repr(models[0])]
    if not names:
        return [fill(repr(model), WIDE, break_long_words=False) for model in models]
    return [", ".join(parameter_value(m, name, m.parameters[name]) for name in names) for m in models]


def raised(unit: str) -> str:
    """A unit with its exponents raised: N/m^3 becomes N/m³."""
    return re.sub(r"\^(-?[\d.]+)", r"$^{\1}$", unit)


def _short(value: float) -> str:
    mantissa, _, exponent = f"{value:.6g}".partition("e")
    if not exponent and abs(value) >= 1e4:
        mantissa, _, exponent = f"{value:.5e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".")
    if not exponent:
        return mantissa
    factor = "" if mantissa == "1" else rf"{mantissa} \cdot "
    return f"${factor}10^{{{int(exponent)}}}$"


def _about(model: Any, name: str) -> Any:
    return about_all(type(model), model.components).get(name) if hasattr(model, "components") else None
