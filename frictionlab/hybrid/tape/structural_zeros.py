"""Functions that are zero after a reset, whatever the numbers: their zeros there are no events."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import sympy as sp

from frictionlab.automaton import Event, Mode, Reset
from frictionlab.automaton.expansion import multiply_out


@lru_cache(maxsize=4096)
def structural_zeros(mode: Mode, event: Event, reset: Reset) -> Mapping[Any, int]:
    """How many leading Taylor coefficients are zero after the event's reset, by function up to its sign.

    What the reset declares; besides, the function that triggered the event and the constraints of the
    mode that ends were zero before it, and stay so unless the reset changes them.
    """
    zero: dict[Any, int] = {}
    for function, count in reset.vanishing.items():
        zero[sign_normal_form(function)] = max(count, zero.get(sign_normal_form(function), 0))
    for function in (event.function, *mode.constraints):
        if sign_normal_form(function) not in zero and _survives(function, reset):
            zero[sign_normal_form(function)] = 1
    return zero


def _survives(function: sp.Expr, reset: Reset) -> bool:
    """Whether a function that was zero before the reset is zero after it."""
    if function.free_symbols.isdisjoint(reset.jump):
        return True
    after: Any = sp.sympify(function.xreplace(dict(reset.jump)), strict=True)  # it may give numbers
    somewhere = after.xreplace(_integers(after.free_symbols))
    if somewhere.is_Rational and somewhere != 0:  # exact, and found sooner than all products are
        return False
    return multiply_out(after) in (0, 0.0)  # to sympy these are two numbers


def _integers(symbols: set[sp.Basic]) -> dict[sp.Basic, sp.Integer]:
    """A different integer for each symbol."""
    return {name: sp.Integer(i) for i, name in enumerate(sorted(symbols, key=str), start=3)}


@lru_cache(maxsize=4096)
def sign_normal_form(function: sp.Expr) -> sp.Expr:
    """The same for f and for -f, however they are written: both are zero together."""
    expanded = multiply_out(function)
    return -expanded if expanded.could_extract_minus_sign() else expanded
