"""Checks on values.  Every message states the name, the rule, the value and a cure."""

from __future__ import annotations

from math import isfinite
from numbers import Real
from typing import Any

from .parameter import Parameter


def checked(name: str, value: Any, about: Parameter) -> float:
    """The value as a float, if it is a finite real number within its bounds.

    Raises
    ------
    TypeError
        If it is no real number: text, a truth value, a complex number, an array.
    ValueError
        If it is not finite or out of bounds.
    """
    number = _finite(name, value, about)
    if about.exclusive_minimum is not None and not number > about.exclusive_minimum:
        raise ValueError(
            _message(name, f"greater than {about.exclusive_minimum:g}", number, f"raise {name}", about)
        )
    if about.minimum is not None and not number >= about.minimum:
        raise ValueError(_message(name, f"at least {about.minimum:g}", number, f"raise {name}", about))
    if about.maximum is not None and not number <= about.maximum:
        raise ValueError(_message(name, f"at most {about.maximum:g}", number, f"lower {name}", about))
    return number


def _finite(name: str, value: Any, about: Parameter) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        what = f"{value!r} ({type(value).__name__})"
        raise TypeError(_message(name, "one real number", what, "give a float", about))
    try:
        number = float(value)
    except OverflowError:
        number = float("inf")
    if not isfinite(number):
        raise ValueError(_message(name, "a finite number", number, "give a float", about))
    return number


def _message(name: str, rule: str, value: Any, cure: str, about: Parameter) -> str:
    default = (
        ""
        if about.default is None
        else f" (its default is {about.default:g}{' ' * bool(about.unit)}{about.unit})"
    )
    return f"{name} must be {rule}, got {value}: {cure}{default}"
