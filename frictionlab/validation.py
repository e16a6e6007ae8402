"""Checks of single arguments: each message has the name, the rule, what was given, and the cure.

The package's suggestions "did you mean" are made here too.  Components use this module, so numpy is imported
only where it is needed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from numbers import Real
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

MAX_CHARACTERS = 100  # characters of a value that a message shows


def plain_number(value: Any) -> Any:
    """The element of a zero-dimensional array; any other value as it is.

    Such arrays are what numpy and xarray give for one element or a mean.
    """
    return value.item() if getattr(value, "shape", None) == () and hasattr(value, "item") else value


def store_plain_numbers(settings: Any) -> None:
    """Replace zero-dimensional arrays among the fields of a frozen dataclass by the numbers they hold."""
    for name, value in list(vars(settings).items()):
        if (number := plain_number(value)) is not value:
            object.__setattr__(settings, name, number)


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
) -> Any:
    """The value as a plain number; raises unless it is finite and within the bounds."""
    value = plain_number(value)
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
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(float(value))


def check_mapping(name: str, value: Any, cure: str) -> None:
    """Raise unless `value` is a mapping."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{name} must be a mapping, got {abbreviate(value)}: {cure}")


def float_array(name: str, values: Any, cure: str) -> np.ndarray:
    """The values as a new array of floats; raises unless they are numbers."""
    import numpy as np

    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must hold numbers, got {abbreviate(values)}: {cure}") from None


def abbreviate(value: Any) -> str:
    """The value as a message shows it, cut if it is long."""
    text = repr(value.tolist() if hasattr(value, "tolist") else value)  # an array as a list
    return text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}..."


def check_choice(name: str, value: Any, choices: Sequence[str], cure: str = "") -> None:
    """Raise unless `value` is one of `choices`; suggests the nearest, or the cure where none is near."""
    if value not in choices:
        allowed = ", ".join(map(repr, choices))
        hint = did_you_mean(value, choices) or (f": {cure}" if cure else "")
        raise ValueError(f"{name} must be one of {allowed}, got {value!r}{hint}")


def nearest_name(name: Any, known: Iterable[str]) -> str | None:
    """The known name that was probably meant, whatever the case of its letters; None where none is near."""
    names = list(known)
    lower = [each.lower() for each in names]
    near = get_close_matches(str(name).lower(), lower, n=1)
    return names[lower.index(near[0])] if near else None


def did_you_mean(name: Any, known: Iterable[str]) -> str:
    """The end of a message that lists what is known: `: did you mean ...?`, or nothing where none is near."""
    near = nearest_name(name, known)
    return "" if near is None else f": did you mean {near!r}?"


def did_you_mean_or_known(name: Any, known: Iterable[str]) -> str:
    """The end of a message that does not list what is known: `: did you mean ...?`, or else that list."""
    names = list(known)
    listed = f": known are {', '.join(names)}" if names else ": there are none"
    return did_you_mean(name, names) or listed


def check_keywords(function: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Raise TypeError for a keyword that the function does not take."""
    for name in given:
        if name not in known:
            raise TypeError(f"{function} takes no {name!r}{did_you_mean(name, known)}")


def unknown_parameter(owner: str, name: Any, known: Sequence[str], hint: str = "") -> TypeError:
    """The error for a parameter that does not exist, the same wherever parameters are named.

    A TypeError, as Python's for an unknown keyword, since parameters are keywords of models.
    """
    return TypeError(f"{owner} has no parameter {name!r}{hint or did_you_mean_or_known(name, known)}")


def with_cure(error: OSError, path: Any, cure: str) -> OSError:
    """An error of the system about a file, of the same class, with its path and what can be done."""
    if error.errno is None or type(error).__module__ != "builtins":  # of a library, such as pillow's
        return OSError(f"{path} cannot be used ({error}): {cure}")
    return type(error)(error.errno, f"{error.strerror}: {cure}", str(path))
