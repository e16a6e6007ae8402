"""Text becomes an expression of the states and parameters of an automaton, as in sections: "x1' - v"."""

from __future__ import annotations

import re
from typing import Any

import sympy

from frictionlab.automaton import HybridAutomaton
from frictionlab.validation import did_you_mean_or_known

NAME_PATTERN = re.compile(r"(?<![\w.])[A-Za-z_]\w*'?")
ARITHMETIC_PATTERN = re.compile(r"(?!.*\.\s*[A-Za-z_])[\w\s.+*/()'-]+")


def read_expression(automaton: HybridAutomaton, text: Any, what: str) -> Any:
    """The text as an expression of the automaton's states and parameters; x' is the rate of x.

    The name of an output, and what is no text, is returned as it is.

    Parameters
    ----------
    automaton : HybridAutomaton
    text : str or object
    what : str
        What errors call it, such as "section".
    """
    if not isinstance(text, str) or text in automaton.outputs:
        return text
    symbols = {_identifier(symbol.name): symbol for symbol in (*automaton.states, *automaton.parameters)}
    unknown = [word for word in NAME_PATTERN.findall(text) if _identifier(word) not in symbols]
    if unknown:
        known = [*(symbol.name for symbol in automaton.states), *automaton.outputs]
        hint = did_you_mean_or_known(unknown[0], known)
        raise ValueError(f"{what} {text!r} has the unknown name {unknown[0]!r}{hint}")
    # a single name needs no parser, which is slow
    found = symbols.get(_identifier(text)) or _parse(text, symbols)
    if not isinstance(found, sympy.Expr) or not found.free_symbols & {*automaton.states}:
        raise ValueError(f'{what} must be an expression of the states such as "x1 - x2", got {text!r}')
    return found


def _parse(text: str, symbols: dict[str, Any]) -> Any:
    """The text as a sympy expression, None where it is none; sympy's parser evaluates text, so it is given
    only arithmetic."""
    if not ARITHMETIC_PATTERN.fullmatch(text):
        return None
    try:
        return sympy.parse_expr(_identifier(text), local_dict=symbols)
    except Exception:  # the parser raises errors of many kinds
        return None


def _identifier(name: str) -> str:
    return name.replace("'", "_rate")
