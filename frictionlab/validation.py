"""Checks of single arguments: each message has the name, the rule, what was given, and the cure.

Also the one "did you mean" of the package.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from numbers import Real
from typing import Any

import numpy as np

MAX_CHARACTERS = 100  # characters of a value that a message shows


def check_number(
    name: str,
    value: Any,
    *,
    integer: bool = False,
    least: float = -math.inf,
    most: float = math.inf,
    above: float = -math.inf,
    below: float = math.inf,
    cure: str = "",
) -> None:
    """Raise unless `value` is a finite number within the bounds."""
    kind = "an integer" if integer else "a finite number"
    rules = [kind]
    rules += [f"at least {least:g}"] if least > -math.inf else []
    rules += [f"above {above:g}"] if above > -math.inf else []
    rules += [f"at most {most:g}"] if most < math.inf else []
    rules += [f"below {below:g}"] if below < math.inf else []
    number = _is_number(value)
    if (
        not number
        or (integer and value != int(value))
        or not (least <= value <= most and above < value < below)
    ):
        raise ValueError(f"{name} must be {', '.join(rules)}, got {value!r}" + (f": {cure}" if cure else ""))


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(float(value))


def check_mapping(name: str, value: Any, cure: str) -> None:
    """Raise unless `value` is a mapping."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{name} must be a mapping, got {abbreviate(value)}: {cure}")


def float_array(name: str, values: Any, cure: str) -> np.ndarray:
    """The values as a new array of floats; raises unless they are numbers."""
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must hold numbers, got {abbreviate(values)}: {cure}") from None


def abbreviate(value: Any) -> str:
    """The value as a message shows it, cut where it is long."""
    text = repr(value.tolist() if isinstance(value, np.ndarray) else value)
    return text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}..."


def check_choice(name: str, value: Any, choices: Sequence[str], cure: str = "") -> None:
    """Raise unless `value` is one of `choices`; suggests the nearest, or where none is near the cure."""
    if value not in choices:
        allowed = ", ".join(map(repr, choices))
        hint = did_you_mean(value, choices) or (f": {cure}" if cure else "")
        raise ValueError(f"{name} must be one of {allowed}, got {value!r}{hint}")


def unknown_parameter(owner: str, name: Any, known: Sequence[str], hint: str = "") -> TypeError:
    """The error for a parameter that there is not: the same wherever one is named.

    A TypeError, as Python's for an unknown keyword, since parameters are keywords of models.
    """
    hint = hint or did_you_mean(name, known).removeprefix(": ") or f"known are {', '.join(known)}"
    return TypeError(f"{owner} has no parameter {name!r}: {hint}")


def did_you_mean(name: Any, known: Sequence[str]) -> str:
    """`: did you mean ...?`, or nothing."""
    close = get_close_matches(str(name), known, n=1)
    return f": did you mean {close[0]!r}?" if close else ""
