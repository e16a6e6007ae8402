"""Laws that are asked with symbols, and say what is wrong where they cannot answer."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.components.component import Component

METHODS = ("force", "kinetic", "static_limit", "impulse", "friction")


def explain(copy: Component) -> None:
    """Make the methods of a law's symbolic copy name themselves in what they raise."""
    for name in METHODS if isinstance(copy, (ContactLaw, FrictionLaw, ImpactLaw)) else ():
        if hasattr(copy, name):
            object.__setattr__(copy, name, _explained(getattr(copy, name), type(copy).__name__))


def _explained(method: Callable[..., Any], law: str) -> Callable[..., Any]:
    @wraps(method)
    def explained(*arguments: Any) -> Any:
        try:
            value = method(*arguments)
        except TypeError as error:
            raise TypeError(
                f"{law}.{method.__name__} must be a formula that takes symbols too, and fails with them "
                f"({error}): write it with + - * / ** and fl.functions (exp, tanh, ...), without if, min, "
                "max, math or numpy; what changes at a value is a mode of its own"
            ) from error
        if value is None:
            raise TypeError(
                f"{law}.{method.__name__} must return a force or an impulse, got None: write return in front"
            )
        return value

    return explained
