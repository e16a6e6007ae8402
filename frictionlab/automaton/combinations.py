"""Many sums that have few expressions in common, as numbers times these expressions.

The equations of a structure of finite elements have some ten thousand terms such as -12.5 E w_3, made of some
hundred expressions E w_i.  What is done with all terms, multiplied by a matrix, evaluated, differentiated, is
done with the numbers; sympy sees the few expressions only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from .mode import Expr

Array = NDArray[np.float64]


def unsorted_product(factors: Sequence[Expr]) -> Expr:
    """The product of factors in the order that sympy gives them, as those of a product less one of them.

    Without the search for equal factors, which there are none of, it takes a tenth of the time.
    """
    if len(factors) < 2:
        return factors[0] if factors else sympy.S.One
    # a number is multiplied into a sum
    return sympy.Mul(*factors, evaluate=any(factor.is_Add for factor in factors))


@dataclass(frozen=True, eq=False)
class Combinations:
    """Sums of numbers times expressions.

    Parameters
    ----------
    expressions : tuple of Expr
    sums : int
        How many sums there are.
    places : array (terms, 2)
        The sum that a term belongs to, and its expression.
    numbers : array (terms,)
        The number in front of each.
    """

    expressions: tuple[Expr, ...]
    sums: int
    places: NDArray[np.int64]
    numbers: Array

    @cached_property
    def matrix(self) -> Array:
        """The numbers as a matrix (sums, expressions)."""
        found = np.zeros((self.sums, len(self.expressions)))
        found[tuple(self.places.T)] = self.numbers
        return found

    def values(self, of_expressions: Array) -> Array:
        """The sums (sums,) where the expressions have these values; each runs from its first term on."""
        terms = self.numbers * of_expressions[self.places[:, 1]]
        found: Array = np.bincount(self.places[:, 0], weights=terms, minlength=self.sums).astype(float)
        return found


def combinations_of(sums: Sequence[Any], states: Sequence[Any]) -> Combinations:
    """Sums as combinations; a sum of states times what depends on none is multiplied out."""
    entries: dict[tuple[int, Expr], float] = {}
    moving = frozenset(states)
    for i, total in enumerate(sums):
        for expr, number in _terms(sympy.sympify(total, strict=True), moving):
            entries[i, expr] = entries.get((i, expr), 0.0) + number
    places = {expr: j for j, expr in enumerate(dict.fromkeys(expr for _, expr in entries))}
    found = np.array([(i, places[expr]) for i, expr in entries], dtype=np.int64).reshape(-1, 2)
    return Combinations(tuple(places), len(sums), found, np.array(list(entries.values()), dtype=float))


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
    """The sums of a matrix (sums, expressions) of numbers times expressions."""
    factors = [sympy.Mul.make_args(one) for one in expressions]
    return [_sum(row, factors) for row in matrix]


def _sum(row: Array, factors: Sequence[tuple[Expr, ...]]) -> Expr:
    # Neither sorted nor searched for equal terms, of which there are none: that takes longest.
    terms = [_multiple(float(row[i]), factors[i]) for i in np.flatnonzero(row).tolist()]
    return sympy.Add(*terms, evaluate=False) if len(terms) > 1 else sum(terms, sympy.S.Zero)


def _multiple(number: float, factors: tuple[Expr, ...]) -> Expr:
    exact = exact_number(number)
    if factors[0].is_Number or exact in (1, -1):
        return sympy.Mul(exact, *factors)
    return sympy.Mul(exact, *factors, evaluate=False)


def exact_number(number: float) -> Expr:
    """A number for sympy: 1 and -1 as integers, which leave no factor; others as they are."""
    return sympy.Integer(int(number)) if number in (1.0, -1.0) else sympy.Float(number)
