"""Expressions multiplied out, unless that would take for ever: a law may be a high power of a long sum."""

from __future__ import annotations

from math import comb, inf, prod

import sympy as sp

# Terms, most, that a product or a power of sums may have: sympy takes a tenth of a second for so many.
MOST_TERMS = 1000


def multiply_out(expr: sp.Expr | float, **hints: bool) -> sp.Expr:
    """The expression multiplied out; as it is where that has too many terms, as (x + y + 1)^50 with 1326.

    `hints` are those of sympy's `expand`.
    """
    given: sp.Expr = sp.sympify(expr, strict=True)  # a reset may give plain numbers
    return sp.expand(given, **hints) if _term_count(given) < inf else given


def _term_count(expr: sp.Basic) -> float:
    """Terms of an expression when it is multiplied out, at most; infinite where a part has too many."""
    counts = [_term_count(part) for part in expr.args]
    if inf in counts:
        return inf
    if expr.is_Add:
        total = sum(counts)
    elif expr.is_Mul:
        total = prod(counts)
    elif isinstance(expr, sp.Pow) and expr.exp.is_Rational and counts[0] > 1:
        exponent = abs(int(expr.exp))
        total = comb(int(counts[0]) + exponent - 1, exponent)
    else:
        total = 1
    return total if expr.is_Add or total <= MOST_TERMS else inf  # a sum is as long as it is written
