"""Methods by name."""

from __future__ import annotations

from typing import Any

from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.scipy_methods import NAMES, Scipy
from frictionlab.hybrid.taylor import Taylor
from frictionlab.hybrid.validation import suggestion


def method_of(method: Any) -> Method:
    """The method itself, or the one of that name with its default settings.

    Raises
    ------
    ValueError
        Where there is no such method.
    """
    if isinstance(method, Method):
        return method
    named = {"taylor": Taylor, "rk4": RK4}
    if method in named:
        return named[method]()
    if method in NAMES:
        return Scipy(method)
    known = [*named, *NAMES]
    names = ", ".join(map(repr, known))
    raise ValueError(
        f"method must be a frictionlab method or one of {names}, got {method!r}{suggestion(method, known)}"
    )
