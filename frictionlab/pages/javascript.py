"""Formulas as JavaScript that computes what Python computes.

Each operation is a statement, in the order in which Python computes them, so that numbers are the same to the
last bit.  Powers and functions are calls of the kernels that Python calls too, through the object ``F`` of
``functions.js``.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

from frictionlab.tape.formulas import (
    ABS,
    AND,
    ATAN2,
    CEILING,
    EQUAL,
    FLOOR,
    FUNCTIONS_BY_KIND,
    INTEGER_POWER,
    LESS,
    LESS_OR_EQUAL,
    MAXIMUM,
    MINIMUM,
    NOT,
    OR,
    REAL_POWER,
    SELECT,
    SIGN,
    STEP,
    Formulas,
    formulas_of,
)
from frictionlab.tape.functions import AFFINE, POWER, PRODUCT, QUOTIENT, SQUARE
from frictionlab.tape.tape import Tape


class JavaScript(str):
    """Text that is code; all other text is data."""

    __slots__ = ()


def javascript_function(arguments: Sequence[Sequence[Any]], expressions: Sequence[Any]) -> JavaScript:
    """A JavaScript function of arrays of numbers that returns the values of the expressions.

    Parameters
    ----------
    arguments : sequence of sequences of Symbol
        The symbols in each array, in their order.
    expressions : sequence of Expr

    Examples
    --------
    >>> import sympy
    >>> k, m = sympy.symbols("k m")
    >>> javascript_function([(k, m)], [sympy.sqrt(k / m)])
    '([v0,v1]) => {const v2=v0/v1,v3=Math.sqrt(v2);return [v3];}'
    """
    inputs = [symbol for some in arguments for symbol in some]
    return javascript_of_formulas(formulas_of(inputs, expressions), list(map(len, arguments)))


def javascript_of_formulas(formulas: Formulas, lengths: Sequence[int]) -> JavaScript:
    """Formulas as a JavaScript function of arrays of these lengths, which together are the inputs."""
    names = iter(f"v{i}" for i in range(formulas.tape.inputs))
    head = ", ".join(f"[{','.join(next(names) for _ in range(length))}]" for length in lengths)
    tape = formulas.tape
    lines = [f"v{tape.inputs + i}={_operation(tape, i)}" for i in formulas.needed]
    body = f"const {','.join(lines)};" if lines else ""
    results = ",".join(f"v{slot}" for slot in formulas.outputs)
    return JavaScript(f"({head}) => {{{body}return [{results}];}}")


def _operation(tape: Tape, i: int) -> str:
    kind, a, b = tape.ops[i]
    number = tape.constants[i]
    if kind == AFFINE:
        return _affine(number, [(factor, f"v{slot}") for slot, factor in tape.terms[a:b]])
    template = TEMPLATES.get(kind) or f"F.{FUNCTIONS_BY_KIND[kind].name}({{a}})"
    if kind == POWER and abs(number) == 0.5:
        template = "Math.sqrt({a})" if number > 0.0 else "1/Math.sqrt({a})"
    return template.format(a=f"v{a}", b=f"v{b}", number=_number(number), condition=f"v{int(number)}")


def _affine(constant: float, terms: Sequence[tuple[float, str]]) -> str:
    """A sum, added up in the order in which Python does."""
    (factor, first), *others = terms or [(0.0, "")]
    if not terms:
        return _number(constant)
    text = first if factor == 1.0 else f"{_number(factor)}*{first}"
    if constant != 0.0:
        text = f"{_number(constant)}+{text}"
    for factor, name in others:
        part = name if abs(factor) == 1.0 else f"{_number(abs(factor))}*{name}"
        text += f"{'-' if factor < 0.0 else '+'}{part}"
    return text


def _number(number: float) -> str:
    text = repr(number) if isfinite(number) else "NaN" if number != number else "Infinity"
    return f"({text})" if number < 0.0 else text


# Operations of formulas as JavaScript; others are calls of the kernels by their names.
TEMPLATES = {
    PRODUCT: "{a}*{b}",
    SQUARE: "{a}*{a}",
    QUOTIENT: "{a}/{b}",
    POWER: "F.real_power({a},{number})",
    INTEGER_POWER: "F.integer_power({a},{number})",
    REAL_POWER: "F.real_power({a},{b})",
    ABS: "Math.abs({a})",
    SIGN: "Math.sign({a})",
    FLOOR: "Math.floor({a})",
    CEILING: "Math.ceil({a})",
    ATAN2: "Math.atan2({a},{b})",
    MAXIMUM: "Math.max({a},{b})",
    MINIMUM: "Math.min({a},{b})",
    STEP: "0.5*(1+Math.sign({a}))",
    LESS: "{a}<{b}",
    LESS_OR_EQUAL: "{a}<={b}",
    EQUAL: "{a}==={b}",
    AND: "{a}&&{b}",
    OR: "{a}||{b}",
    NOT: "!{a}",
    SELECT: "{condition}?{a}:{b}",
}
