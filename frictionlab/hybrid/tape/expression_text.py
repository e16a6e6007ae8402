"""Expressions given as text, such as a section "x1 - x2'", read by a parser that knows but arithmetic.

sympy's own parser runs its text as Python, and computes 9**9**9. This one walks the tree of the text, knows
numbers, the names it is given, + - * / ** and parentheses, and bounds all three.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Mapping
from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.lazy_names import sympy
from frictionlab.validation import abbreviate, did_you_mean_or_known

NAME_PATTERN = re.compile(r"(?<![\w.])[A-Za-z_]\w*'?")  # x' is the rate of x
MAX_LENGTH = 1000  # characters; a text that a person wrote is shorter
MAX_EXPONENT = 100  # a power is a chain of as many products at most
MAX_NUMBER = 1e300  # within the range of double precision, with room for products
OPERATIONS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
ARITHMETIC = "numbers, names, + - * / ** and parentheses are all that it may hold"


def read_expression(automaton: HybridAutomaton, text: Any, what: str) -> Any:
    """The text as an expression of the automaton's states and parameters; x' is the rate of x.

    The name of an output, and what is no text, is returned as it is.

    Parameters
    ----------
    automaton : HybridAutomaton
    text : str or object
    what : str
        What errors call it, such as "section".

    Raises
    ------
    ValueError
        For unknown names, for what is no arithmetic, and where no state is named.
    """
    if not isinstance(text, str) or text in automaton.outputs:
        return text
    states = [symbol.name for symbol in automaton.states]
    symbols = {symbol.name: symbol for symbol in (*automaton.states, *automaton.parameters)}
    unknown = [name for name in names_in(text) if name not in symbols]
    if unknown:
        hint = did_you_mean_or_known(unknown[0], [*states, *automaton.outputs])
        raise ValueError(f"{what} {text!r} has the unknown name {unknown[0]!r}{hint}")
    expected = f'{what} must be an expression of the states such as "x1 - x2", got {abbreviate(text)}'
    try:
        found = symbols.get(text) or parse_expression(text, symbols)
    except ValueError as error:
        raise ValueError(f"{expected}: {error}") from None
    if not found.free_symbols & {*automaton.states}:
        raise ValueError(f"{expected}: name one of {', '.join(states)}")
    return found


def names_in(text: str) -> list[str]:
    """Names that a text mentions, with the primes of rates."""
    return NAME_PATTERN.findall(text)


def parse_expression(text: str, symbols: Mapping[str, Any]) -> Any:
    """The text as a sympy expression of these symbols.

    Parameters
    ----------
    text : str
        Such as ``"(y2 - y1)/3 - mu_k*x1'**2"``.
    symbols : mapping of str to Symbol
        Those that it may mention, by their names.

    Raises
    ------
    ValueError
        For anything but arithmetic, for unknown names, and where numbers, exponents or the text are too
        large; it says which.
    """
    if len(text) > MAX_LENGTH:
        raise ValueError(f"it has {len(text)} characters, of which at most {MAX_LENGTH} are read")
    # x' is no name for Python, and `lambda` none for us to refuse.
    places = {name: f"_{i}" for i, name in enumerate(dict.fromkeys(names_in(text)))}
    source = NAME_PATTERN.sub(lambda name: places[name[0]], " ".join(text.split()))
    try:
        tree = ast.parse(source, mode="eval").body
        return _value(tree, {place: symbols[name] for name, place in places.items() if name in symbols})
    except (SyntaxError, RecursionError, MemoryError):
        raise ValueError(ARITHMETIC) from None


def _value(node: ast.expr, symbols: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return _checked(sympy.sympify(number, strict=True))
        case ast.Name(id=name) if name in symbols:
            return symbols[name]
        case ast.UnaryOp(op=sign, operand=only) if type(sign) in OPERATIONS:
            return OPERATIONS[type(sign)](_value(only, symbols))
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            exponent = _value(right, symbols)
            _check_exponent(exponent)
            return _checked(_value(left, symbols) ** exponent)
        case ast.BinOp(left=left, op=sign, right=right) if type(sign) in OPERATIONS:
            return _checked(OPERATIONS[type(sign)](_value(left, symbols), _value(right, symbols)))
    raise ValueError(ARITHMETIC)


def _checked(found: Any) -> Any:
    """What an operation gave, if the next one may take it: powers of powers grow without a bound."""
    if found.has(sympy.zoo, sympy.nan, sympy.oo, sympy.I):
        raise ValueError("it divides by zero, takes a root of a negative number, or is infinite")
    for power in found.atoms(sympy.Pow):
        _check_exponent(power.exp)
    for number in found.atoms(sympy.Number):
        if any(abs(part) > MAX_NUMBER for part in number.as_numer_denom()):
            raise ValueError(f"its numbers may be at most {MAX_NUMBER:g}")
    return found


def _check_exponent(exponent: Any) -> None:
    if exponent.is_number and abs(exponent) > MAX_EXPONENT:
        raise ValueError(f"its exponents may be at most {MAX_EXPONENT}")
