"""Which part of a formula has no real value at its parameters: the root of a negative number, or the
inverse of zero.

A formula that holds one has no value in any state, so that it can be told by the parameters before a run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import sympy

from .mode import Symbol


class _Part(NamedTuple):
    """A part of a formula that need not have a value, its parameters, and its value as their function."""

    expression: Any
    symbols: tuple[Symbol, ...]
    value: Callable[..., Any]

    def is_undefined(self, values: Mapping[Symbol, float]) -> bool:
        """Whether it has no real value there."""
        try:
            found = self.value(*(values[symbol] for symbol in self.symbols))
        except (ArithmeticError, ValueError):
            return True
        return isinstance(found, complex) or math.isnan(found)


def undefined_part(expression: Any, values: Mapping[Symbol, float]) -> str:
    """The innermost part of an expression that has no real value, and where; empty where there is none.

    As text: "sqrt(a), which has no real value at a = -1".  Parts that hold a state are left out.
    """
    for part in _doubtful_parts(sympy.sympify(expression, strict=True), frozenset(values)):
        if part.is_undefined(values):
            at = ", ".join(f"{symbol} = {values[symbol]:g}" for symbol in part.symbols)
            return f"{part.expression}, which has no real value at {at}"
    return ""


@lru_cache(maxsize=4096)
def _doubtful_parts(expression: Any, symbols: frozenset[Symbol]) -> tuple[_Part, ...]:
    """The parts that depend on parameters only and need not have a value, the innermost first."""
    return tuple(_parts(expression, symbols))


def _parts(expression: Any, symbols: frozenset[Symbol]) -> Iterator[_Part]:
    part: Any
    for part in dict.fromkeys(sympy.postorder_traversal(expression)):
        power = part.is_Pow and not (part.exp.is_Integer and part.exp.is_nonnegative)
        if (power or part.is_Function) and part.free_symbols and part.free_symbols <= symbols:
            names = tuple(sorted(part.free_symbols, key=str))
            yield _Part(part, names, sympy.lambdify(names, part, "math"))
