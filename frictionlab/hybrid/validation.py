"""Checks of single arguments: name, rule, value, cure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from difflib import get_close_matches
from numbers import Real
from typing import Any


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


def check_choice(name: str, value: Any, choices: Sequence[str]) -> None:
    """Raise unless `value` is one of `choices`; suggests the nearest."""
    if value not in choices:
        allowed = ", ".join(map(repr, choices))
        raise ValueError(f"{name} must be one of {allowed}, got {value!r}{suggestion(value, choices)}")


def suggestion(name: Any, known: Sequence[str]) -> str:
    """`: did you mean ...?`, or nothing."""
    close = get_close_matches(str(name), known, n=1)
    return f": did you mean {close[0]!r}?" if close else ""
