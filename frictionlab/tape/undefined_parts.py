"""Parts of formulas that have no real value at some values of the parameters.

A formula with the root of a negative number or the inverse of zero has no value in any state, which can be
told before a run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

from frictionlab.automaton.expressions import integer_exponent
from frictionlab.automaton.mode import Symbol
from frictionlab.lazy_names import sympy
from frictionlab.tape.formulas import formulas_of


def undefined_part(expression: Any, values: Mapping[Symbol, float]) -> str:
    """The innermost part of an expression that has no real value; empty where there is none.

    As text: "sqrt(a), which has no real value at a = -1".  Parts that hold a state are left out.
    """
    for part in doubtful_parts(expression, frozenset(values)):
        names = sorted(part.free_symbols, key=str)
        at = {symbol.name: values[symbol] for symbol in names}
        if not math.isfinite(formulas_of(names, [part]).numbers(*at.values())[0]):
            return undefined_words(str(part), list(at), at)
    return ""


def undefined_words(text: str, names: Sequence[str], values: Mapping[str, float]) -> str:
    """The message that a part has no real value at these values of its parameters."""
    return f"{text}, which has no real value at {', '.join(f'{name} = {values[name]:g}' for name in names)}"


@lru_cache(maxsize=4096)
def doubtful_parts(expression: Any, symbols: frozenset[Symbol]) -> tuple[Any, ...]:
    """The parts that depend on parameters only and may have no value, the innermost first."""
    return tuple(_parts(sympy.sympify(expression, strict=True), symbols))


def _parts(expression: Any, symbols: frozenset[Symbol]) -> Iterator[Any]:
    part: Any
    for part in dict.fromkeys(sympy.postorder_traversal(expression)):
        exponent = integer_exponent(part) if part.is_Pow else 0
        power = exponent is None or exponent < 0
        if (power or part.is_Function) and part.free_symbols and part.free_symbols <= symbols:
            yield part
