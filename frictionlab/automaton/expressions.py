"""Expressions: long sums as numbers times a few of them, and products multiplied out.

The equations of a structure of finite elements have some ten thousand terms such as -12.5 E w_3, made of some
hundred expressions E w_i.  Where all terms are multiplied by a matrix, evaluated or differentiated, that is
done with the numbers (`Combinations`); sympy sees only the few expressions.  Products are multiplied out
unless that would take too long: a law may be a high power of a long sum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import comb, inf, prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton.mode import Expr
from frictionlab.lazy_names import sympy

Array = NDArray[np.float64]
# Numbers in front of exponential functions outside of these powers of e belong into them.
MOST_POWER_OF_E = 200.0
# Most terms that a product or a power of sums may have: sympy takes a tenth of a second for so many.
MOST_TERMS = 1000


def unsorted_product(factors: Sequence[Expr]) -> Expr:
    """The product of factors that are in sympy's order already, as those of a product less one of them.

    No two may be equal: without the search for equal factors this takes a tenth of the time.
    """
    if len(factors) < 2:
        return factors[0] if factors else sympy.S.One
    # evaluated where there is a sum, since sympy multiplies a number into it
    return sympy.Mul(*factors, evaluate=any(factor.is_Add for factor in factors))


def integer_exponent(power: Any) -> int | None:
    """The exponent of a power where it is an integer, also one written as 2.0; else None.

    Only a power with another exponent needs a base that is not negative.
    """
    exponent = power.exp
    if exponent.is_Integer or (exponent.is_Float and float(exponent).is_integer()):
        return int(exponent)
    return None


def real_power_cure(base: Any, exponent: Any) -> str:
    """What to write instead of a power of a base that can be negative."""
    base = base if base.is_Symbol else f"({base})"
    exponent = exponent if not getattr(exponent, "is_Add", False) else f"({exponent})"
    size = f"abs{base}" if str(base).startswith("(") else f"abs({base})"
    return (
        f"write {size}**{exponent}, or {base}*{size}**({exponent} - 1) for a law that changes its sign with "
        "the base, or an integer exponent as a number"
    )


@lru_cache(maxsize=4096)
def within_floats(expression: Any) -> Any:
    """An equal expression whose numbers are floats, and whose integer exponents are integers.

    sympy makes 1e-1000 exp(2303.0 y) of exp(2303.0 (y - 1)): that number is zero as a float, and the
    exponential function overflows.  An exact number stays in the argument.
    """
    expr = sympy.sympify(expression, strict=True)
    if not expr.args:
        return expr
    changes = {}
    for part in expr.atoms(sympy.Pow, sympy.exp):
        if part.is_Pow and part.exp.is_Float and (exponent := integer_exponent(part)) is not None:
            changes[part] = part.base**exponent
    products = expr.atoms(sympy.Mul) if expr.has(sympy.exp) else ()
    for part in products:
        number, rest = part.as_coeff_Mul()
        factors = list(sympy.Mul.make_args(rest))
        power = next((factor for factor in factors if isinstance(factor, sympy.exp)), None)
        if power is not None and number.is_Float and abs(shift := sympy.log(abs(number))) > MOST_POWER_OF_E:
            factors.remove(power)
            whole = sympy.exp(power.args[0] + sympy.Rational(float(shift)))
            changes[part] = sympy.Mul(sympy.sign(number), *factors, whole)
    return expr.xreplace(changes) if changes else expr


@dataclass(frozen=True, eq=False)
class Combinations:
    """Sums of numbers times expressions.

    Parameters
    ----------
    expressions : tuple of Expr
    sums : int
        How many sums there are.
    places : array (terms, 2)
        For each term the index of its sum, and that of its expression.
    numbers : array (terms,)
        The number in front of each term.
    """

    expressions: tuple[Expr, ...]
    sums: int
    places: NDArray[np.int64]
    numbers: Array

    @cached_property
    def matrix(self) -> Array:
        """The numbers as a matrix (sums, expressions)."""
        matrix = np.zeros((self.sums, len(self.expressions)))
        matrix[tuple(self.places.T)] = self.numbers
        return matrix


def combinations_of(sums: Sequence[Any], states: Sequence[Any]) -> Combinations:
    """Sums as combinations; a sum with states times factors without states is multiplied out."""
    entries: dict[tuple[int, Expr], float] = {}
    moving = frozenset(states)
    for i, total in enumerate(sums):
        for expr, number in _terms(sympy.sympify(total, strict=True), moving):
            entries[i, expr] = entries.get((i, expr), 0.0) + number
    places = {expr: j for j, expr in enumerate(dict.fromkeys(expr for _, expr in entries))}
    pairs = np.array([(i, places[expr]) for i, expr in entries], dtype=np.int64).reshape(-1, 2)
    return Combinations(tuple(places), len(sums), pairs, np.array(list(entries.values()), dtype=float))


def _terms(expr: Expr, moving: frozenset[Any]) -> list[tuple[Expr, float]]:
    """The terms of a sum, each with the number in front of it."""
    if expr.is_Add:
        return [term for arg in expr.args for term in _terms(arg, moving)]
    number, rest = expr.as_coeff_Mul()
    if rest.is_Mul:
        sums = [
            factor for factor in rest.args if factor.is_Add and not moving.isdisjoint(factor.free_symbols)
        ]
        fixed = [factor for factor in rest.args if factor not in sums]
        if len(sums) == 1 and all(moving.isdisjoint(factor.free_symbols) for factor in fixed):
            terms = _terms(sums[0], moving)
            return [(sympy.Mul(*fixed, one), float(number) * n) for one, n in terms]
    elif rest.is_Add:
        return [(one, float(number) * n) for one, n in _terms(rest, moving)]
    return [(rest, float(number))] if number != 0 else []


def expressions_of(matrix: Array, expressions: Sequence[Expr]) -> list[Expr]:
    """The sums whose numbers are the rows of a matrix (sums, expressions)."""
    factors = [sympy.Mul.make_args(one) for one in expressions]
    return [_sum(row, factors) for row in matrix]


def _sum(row: Array, factors: Sequence[tuple[Expr, ...]]) -> Expr:
    # The terms are not sorted or compared, which would take longest: no two are equal.
    terms = [_multiple(float(row[i]), factors[i]) for i in np.flatnonzero(row).tolist()]
    return sympy.Add(*terms, evaluate=False) if len(terms) > 1 else sum(terms, sympy.S.Zero)


def _multiple(number: float, factors: tuple[Expr, ...]) -> Expr:
    exact = exact_number(number)
    if factors[0].is_Number or exact in (1, -1):
        return sympy.Mul(exact, *factors)
    return sympy.Mul(exact, *factors, evaluate=False)


def exact_number(number: float) -> Expr:
    """A number for sympy: 1 and -1 as integers, which leave no factor; others as floats."""
    return sympy.Integer(int(number)) if number in (1.0, -1.0) else sympy.Float(number)


def multiply_out(expr: Expr | float, **hints: bool) -> Expr:
    """The expression multiplied out; unchanged if that has too many terms, as (x + y + 1)^50 with 1326.

    `hints` are those of sympy's `expand`.
    """
    expression: Expr = sympy.sympify(expr, strict=True)  # a reset may give plain numbers
    return sympy.expand(expression, **hints) if _term_count(expression) < inf else expression


def _term_count(expr: Any) -> float:
    """Most terms that an expression can have when multiplied out; infinite where a part has too many."""
    counts = [_term_count(part) for part in expr.args]
    if inf in counts:
        return inf
    if expr.is_Add:
        total = sum(counts)
    elif expr.is_Mul:
        total = prod(counts)
    elif isinstance(expr, sympy.Pow) and expr.exp.is_Rational and counts[0] > 1:
        exponent = abs(int(expr.exp))
        total = comb(int(counts[0]) + exponent - 1, exponent)
    else:
        total = 1
    return total if expr.is_Add or total <= MOST_TERMS else inf  # a sum needs no limit of its own
