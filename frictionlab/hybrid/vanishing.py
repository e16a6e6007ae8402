"""Which functions are zero by construction after an event, and to which order."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import sympy as sp

from frictionlab.automaton import Event, Mode, Reset


def vanishing(mode: Mode, event: Event, reset: Reset, functions: Sequence[Any]) -> list[int]:
    """How many leading Taylor coefficients of each function are zero after the event's reset.

    What the reset declares; besides, the function that triggered the event and the constraints of the
    mode that ends were zero before it, and stay so unless the reset changes them.
    """
    zero = dict(reset.vanishing)
    for function in (event.function, *mode.constraints):
        if not any(_same(function, known) for known in zero) and _survives(function, reset):
            zero[function] = 1
    return [max([n for known, n in zero.items() if _same(f, known)], default=0) for f in functions]


def _survives(function: sp.Expr, reset: Reset) -> bool:
    """Whether a function that was zero before the reset is zero after it."""
    if function.free_symbols.isdisjoint(reset.jump):
        return True
    return _expanded(function.xreplace(dict(reset.jump))) == 0


def _same(f: sp.Expr, g: sp.Expr) -> bool:
    """Whether f = g or f = -g."""
    if f == g or f == -g:
        return True
    if f.free_symbols != g.free_symbols:
        return False
    one, other = _expanded(f), _expanded(g)
    return one == other or one == -other


@lru_cache(maxsize=256)
def _expanded(expr: sp.Expr) -> sp.Expr:
    return sp.expand(expr)
