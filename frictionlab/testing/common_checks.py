"""Checks that laws and models share: parameters with meaning and range, a repr and a dictionary that make the
object again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionlab.components.component import Component
from frictionlab.components.parameter import Parameter
from frictionlab.models.serialisation import component_from_dict, component_to_dict


def fail(subject: Any, rule: str, got: Any) -> None:
    """Raise AssertionError: what is checked, the rule, and what there is instead."""
    raise AssertionError(f"{subject!r}: {rule}, got {got!r}")


def check_parameters(subject: Component, known: Mapping[str, Parameter]) -> None:
    """Every parameter has a symbol, a meaning and a range that holds its default."""
    for name, about in known.items():
        if not about.meaning:
            fail(subject, f"parameter {name} must have a meaning: write parameter(..., meaning=...)", "")
        if about.range is None:
            fail(subject, f"parameter {name} must have a range for its slider", None)
        low, high = about.range or (0.0, 0.0)
        if about.default is not None and not low <= about.default <= high:
            fail(subject, f"the range of {name} must hold its default", (about.range, about.default))


def check_round_trip(subject: Component) -> None:
    """The repr is an expression that makes the object again, and so does the dictionary."""
    again = eval(repr(subject), _class_names(subject))
    if again != subject:
        fail(subject, "its repr must make it again", again)
    again = component_from_dict(component_to_dict(subject), type(subject))
    if again != subject or hash(again) != hash(subject):
        fail(subject, "its dictionary must make it again", again)


def _class_names(subject: Component) -> dict[str, type]:
    """The classes that a repr may name."""
    parts = [getattr(subject, name) for name in getattr(subject, "roles", ())]
    return {type(part).__name__: type(part) for part in (subject, *parts)}
