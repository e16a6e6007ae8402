"""Symbols of states and parameters, and derivatives by them.

Sympy's `diff` tries every symbol on every term, n^2 times for a chain of n springs.  `gradient` takes the
derivatives of a term only by the symbols that it contains.  They are the same expressions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence, Set
from functools import cache
from typing import TYPE_CHECKING, Any

from frictionlab.automaton.expressions import multiply_out, unsorted_product
from frictionlab.components.component import StructureKey
from frictionlab.lazy_names import sympy

if TYPE_CHECKING:
    from frictionlab.models.model import Model

Derivatives = dict[Any, Any]  # symbol -> derivative by it; zeros are left out


@cache
def symbol(name: str) -> Any:
    """The real symbol of a state or a parameter; a velocity is its coordinate's name with a prime."""
    return sympy.Symbol(name, real=True)


def parameter_symbols(key: StructureKey) -> tuple[Any, ...]:
    """Symbols of all parameters of a structure, in the order of :func:`structure_values`."""
    return tuple(map(symbol, key.parameters))


def structure_values(model: Model) -> tuple[float, ...]:
    """Values of the parameters of the model's structure, in the order of :func:`parameter_symbols`."""
    values = model.parameters
    return tuple(values[name] for name in model.structure_key.parameters)


def expand_products(expr: Any) -> Any:
    """Expand products of sums, unless that is too long; arguments of a law's functions stay as they are.

    Otherwise exp(-((v - x')/v_s)^2) would become a product of exponentials, of which one overflows and
    another is zero.
    """
    given = sympy.sympify(expr, strict=True)
    functions = {part: sympy.Dummy() for part in given.atoms(sympy.Function, sympy.Pow) if _is_function(part)}
    back = {dummy: part for part, dummy in functions.items()}
    return multiply_out(given.xreplace(functions)).xreplace(back)


def _is_function(part: Any) -> bool:
    return not part.is_Pow or not part.exp.is_Integer


def state_symbols(coordinates: tuple[str, ...]) -> tuple[Any, ...]:
    """Symbols of the coordinates, then of their velocities."""
    return tuple(symbol(name) for name in (*coordinates, *(name + "'" for name in coordinates)))


def derivatives(expression: Any, symbols: Set[Any]) -> Derivatives:
    """The derivatives of an expression by those of the symbols that it contains."""
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
    """The derivatives of an expression by each of `x`."""
    slopes = derivatives(expression, {*x})
    return [slopes.get(one, sympy.S.Zero) for one in x]


def dot(one: Iterable[Any], other: Iterable[Any]) -> Any:
    """The sum of products of two rows' entries."""
    return sum((a * b for a, b in zip(one, other, strict=True) if a != 0), sympy.S.Zero)


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
