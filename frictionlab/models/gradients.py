"""Derivatives by many symbols of sums of many terms, each of which holds a few of them.

Sympy's `diff` asks every term about every symbol: n^2 questions for a chain of n springs.  Here each term is
asked for the symbols that are in it.  The derivatives are the same expressions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence, Set
from typing import Any

import sympy

from frictionlab.automaton.combinations import unsorted_product

Derivatives = dict[Any, Any]  # by the symbol; those that are zero are left out


def derivatives(expression: Any, symbols: Set[Any]) -> Derivatives:
    """The derivatives of an expression by those of the symbols that are in it."""
    expr = sympy.sympify(expression, strict=True)
    if expr.is_Symbol:
        return {expr: sympy.S.One} if expr in symbols else {}
    if expr.is_Add:
        return _sums(_terms(expr.args, symbols, lambda _, slope: slope))
    if expr.is_Mul:
        return _sums(_terms(expr.args, symbols, _product_rule(expr.args)))
    there = sorted(expr.free_symbols & symbols, key=str)
    return {x: slope for x in there if (slope := sympy.diff(expr, x)) != 0}


def gradient(expression: Any, x: Sequence[Any]) -> list[Any]:
    """The derivatives by each of `x`."""
    found = derivatives(expression, {*x})
    return [found.get(one, sympy.S.Zero) for one in x]


def _terms(
    arguments: Sequence[Any], symbols: Set[Any], term: Callable[[int, Any], Any]
) -> Iterable[tuple[Any, Any]]:
    for i, argument in enumerate(arguments):
        for x, slope in derivatives(argument, symbols).items():
            yield x, term(i, slope)


def _product_rule(factors: tuple[Any, ...]) -> Callable[[int, Any], Any]:
    def term(i: int, slope: Any) -> Any:
        if slope == 1:
            return unsorted_product([*factors[:i], *factors[i + 1 :]])
        return sympy.Mul(*factors[:i], slope, *factors[i + 1 :])

    return term


def _sums(terms: Iterable[tuple[Any, Any]]) -> Derivatives:
    parts: dict[Any, list[Any]] = {}
    for x, term in terms:
        parts.setdefault(x, []).append(term)
    sums = ((x, sympy.Add(*some)) for x, some in parts.items())
    return {x: total for x, total in sums if total != 0}
