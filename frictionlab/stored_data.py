"""What a file holds, checked field by field before anything is made of it: the schema of each kind of file.

A schema is a check: it is called with a field's name and its value, and raises ValueError with the name, the
rule and the value.  Checks of lists and mappings are put together from those of their entries.  A checksum
tells only that a file is as it was written, not that this package wrote it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_mapping,
    check_number,
    check_text,
    float_array,
)

Check = Callable[[str, Any], Any]


@contextmanager
def reading(path: Path, cure: str) -> Iterator[None]:
    """Context in which a file's content is checked: errors get its path, and what can be done."""
    try:
        yield
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path} is damaged, {error}: {cure}") from error


def json_data(text: str | bytes) -> Any:
    """What JSON says; ValueError also for what is nested too deeply."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("lists and mappings must be nested less deeply") from None


def anything(name: Any, value: Any) -> None:
    """No rule: what users' functions returned, say."""


def number(**rules: Any) -> Check:
    """A finite number within the bounds of :func:`check_number`."""
    return lambda name, value: check_number(name, value, **rules)


def real(name: str, value: Any) -> None:
    """A number, also NaN or an infinite one."""
    if not isinstance(value, float):
        check_number(name, value)


def integer(**rules: Any) -> Check:
    """An integer, which 4.0 is not: it counts or is an index."""

    def check(name: str, value: Any) -> None:
        check_number(name, str(value) if isinstance(value, float) else value, integer=True, **rules)

    return check


def text(*choices: str) -> Check:
    """A text, one of the choices where there are any."""
    if choices:
        return lambda name, value: check_choice(name, value, choices)
    return lambda name, value: check_text(name, value, "")


def either(kind: type, check: Check, otherwise: Check) -> Check:
    """The first check for values of a class, the other for all else."""
    return lambda name, value: (check if isinstance(value, kind) else otherwise)(name, value)


def mapping(each: Check = anything) -> Check:
    """A mapping of names to values that the check takes."""

    def check(name: str, value: Any) -> None:
        check_mapping(name, value, "")
        for key, entry in value.items():
            each(f"{name}[{abbreviate(key)}]", entry)

    return check


def record(required: Mapping[str, Check], optional: Mapping[str, Check] | None = None) -> Check:
    """A mapping with all required fields; it may have others, of which the optional ones are checked."""

    def check(name: str, value: Any) -> None:
        check_mapping(name, value, "")
        for field in required:
            if field not in value:
                raise ValueError(f"{name} must have the field {field!r}, got {abbreviate(list(value))}")
        for field, rule in {**required, **(optional or {})}.items():
            if field in value:
                rule(f"{name}[{field!r}]" if name else field, value[field])

    return check


def listed(each: Check = anything, length: int | None = None, *, distinct: bool = False) -> Check:
    """A list of values that the check takes, of one length where it is given, no two equal if so asked."""

    def check(name: str, value: Any) -> None:
        rule = "a list" if length is None else f"a list of {length}"
        if not isinstance(value, list) or length not in (None, len(value)):
            raise ValueError(f"{name} must be {rule}, got {abbreviate(value)}")
        for i, entry in enumerate(value):
            each(f"{name}[{i}]", entry)
        if distinct and len({*value}) < len(value):
            raise ValueError(f"{name} must hold each value once, got {abbreviate(value)}")

    return check


def array(*shape: int | None, finite: bool = True) -> Check:
    """Nested lists of numbers, of a shape in which None stands for any length."""

    def check(name: str, value: Any) -> None:
        if not isinstance(value, list):
            raise ValueError(f"{name} must be a list of numbers, got {abbreviate(value)}")
        numbers = float_array(name, value, "", finite=finite)
        if not (agrees(numbers.shape, shape) or (numbers.size == 0 and shape[0] is None and not value)):
            raise ValueError(
                f"{name} must have the shape {shape_text(shape)}, got {shape_text(numbers.shape)}"
            )

    return check


def agrees(shape: Sequence[int], wanted: Sequence[int | None]) -> bool:
    """Whether a shape is the wanted one, in which None stands for any length."""
    return len(shape) == len(wanted) and all(w in (None, s) for s, w in zip(shape, wanted))


def shape_text(shape: Sequence[int | None]) -> str:
    """A shape as messages show it: "2 x 8", with "any" for any length."""
    return " x ".join("any" if n is None else str(n) for n in shape) or "of one number"


def array_bytes(shape: Sequence[int], itemsize: int) -> int:
    """The memory of an array, without the overflow that numpy's integers have."""
    return prod(map(int, shape)) * int(itemsize)
