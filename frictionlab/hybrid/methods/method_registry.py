"""Methods by name."""

from __future__ import annotations

from typing import Any

from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.scipy_methods import INTEGRATORS, Scipy
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.validation import did_you_mean


def method_of(method: Any) -> Method:
    """The method itself, or the one of that name, in small letters or large ones, with its default settings.

    Raises
    ------
    ValueError
        Where there is no such method.
    """
    if isinstance(method, Method):
        return method
    named = {"taylor": Taylor, "rk4": RK4}
    known = [*named, *INTEGRATORS]
    spelt = {name.lower(): name for name in known}
    name = spelt.get(method.lower(), "") if isinstance(method, str) else ""
    if name:
        return named[name]() if name in named else Scipy(name)
    names = ", ".join(map(repr, known))
    raise ValueError(
        f"method must be a frictionlab method or one of {names}, got {method!r}{did_you_mean(method, known)}"
    )
