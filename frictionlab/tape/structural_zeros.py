"""Functions that are zero after a reset whatever the numbers, so that their zeros there are no events."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from frictionlab.automaton import Event, Mode, Reset
from frictionlab.automaton.expressions import multiply_out
from frictionlab.automaton.mode import Expr
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.formulas import formulas_of
from frictionlab.tape.intervals import Interval, interval
from frictionlab.tape.tape import TapeError


@lru_cache(maxsize=4096)
def structural_zeros(mode: Mode, event: Event, reset: Reset) -> Mapping[Any, int]:
    """How many leading Taylor coefficients are zero after the event's reset, by function up to its sign.

    The reset declares such functions.  Besides, the function that triggered the event and the constraints of
    the mode that ends were zero before the reset; they stay zero unless it changes them where the event is.
    """
    zero: dict[Any, int] = {}
    for function, count in reset.vanishing.items():
        zero[sign_normal_form(function)] = max(count, zero.get(sign_normal_form(function), 0))
    for function in (event.function, *mode.constraints):
        if sign_normal_form(function) not in zero and _survives(function, reset, event.function):
            zero[sign_normal_form(function)] = 1
    return zero


def _survives(function: Expr, reset: Reset, guard: Expr) -> bool:
    """Whether a function that was zero before the reset is zero after it, where the guard is zero."""
    if function.free_symbols.isdisjoint(reset.jump):
        return True
    surface = _solved(guard, function.free_symbols & guard.free_symbols)
    if _jumps(function, reset, surface or {}):
        return False
    after: Any = sp.sympify(function.xreplace(dict(reset.jump)), strict=True)  # a jump may be a plain number
    if _is_zero(after):
        return True
    return surface is not None and _is_zero((after - function).xreplace(surface))


def _is_zero(expression: Any) -> bool:
    return multiply_out(expression) in (0, 0.0)  # to sympy these are two numbers


def _solved(guard: Expr, symbols: set[Any]) -> dict[Any, Expr] | None:
    """The value of one of the symbols at which the guard is zero; None where it is linear in none of them."""
    for one in sorted(symbols, key=str):
        slope = sp.diff(guard, one)
        if slope != 0 and one not in slope.free_symbols:
            return {one: -guard.xreplace({one: sp.S.Zero}) / slope}
    return None


@np.errstate(all="ignore")  # what is beyond all floats has no bounds
def _jumps(function: Expr, reset: Reset, surface: Mapping[Any, Expr]) -> bool:
    """Whether bounds at one place tell that a function is not zero after a reset, nor as it was before.

    This is exact, and quicker than multiplying out.  Each symbol is a different integer there.
    """
    functions = [function, *reset.jump.values(), *surface.values()]
    symbols = sorted(
        set().union(*(sp.sympify(one, strict=True).free_symbols for one in functions), reset.jump), key=str
    )
    try:
        place = dict(zip(symbols, map(interval, map(float, range(3, 3 + len(symbols))))))
        for values_of in (surface, reset.jump):
            before = place
            values = formulas_of(symbols, [*values_of.values()]).arrays(*place.values())
            place = place | dict(zip(values_of, map(interval, values), strict=True))
        formula = formulas_of(symbols, [function])
    except TapeError:
        return False
    old, new = (interval(formula.arrays(*at.values())[0]) for at in (before, place))
    return _without_zero(new) and _without_zero(new - old)


def _without_zero(bounds: Interval) -> bool:
    return bool(bounds.low > 0 or bounds.high < 0)


@lru_cache(maxsize=4096)
def sign_normal_form(function: Expr) -> Expr:
    """One form for f and -f, however they are written, as both are zero together."""
    expanded = multiply_out(function)
    return -expanded if expanded.could_extract_minus_sign() else expanded
