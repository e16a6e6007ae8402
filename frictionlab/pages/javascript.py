"""Expressions of sympy as JavaScript, to the last bit what Python computes of parameters.

Sums and products are printed as Python's are, in one order; powers and functions are calls of those kernels
that Python calls too, by the object ``F`` of ``functions.js``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import sympy as sp

from frictionlab.hybrid.elementary.parameter_functions import KERNELS, ParameterPrinter
from frictionlab.hybrid.tape.functions import FUNCTIONS


class JavaScriptPrinter(ParameterPrinter):
    """Arithmetic reads the same in both languages; what does not is printed here."""

    root, prefix = "Math.sqrt", "F."

    def _print_Function(self, expr: Any) -> str:
        return f"F.{type(expr).__name__}({', '.join(map(self._print, expr.args))})"

    def _print_Abs(self, expr: Any) -> str:
        return f"Math.abs({self._print(expr.args[0])})"

    def _print_sign(self, expr: Any) -> str:
        return f"Math.sign({self._print(expr.args[0])})"

    def _print_Min(self, expr: Any) -> str:
        return f"Math.min({', '.join(map(self._print, expr.args))})"

    def _print_Max(self, expr: Any) -> str:
        return f"Math.max({', '.join(map(self._print, expr.args))})"

    def _print_Piecewise(self, expr: Any) -> str:
        text = "NaN"
        for value, condition in reversed(expr.args):
            if condition == sp.true:
                text = f"({self._print(value)})"
            else:
                text = f"(({self._print(condition)}) ? ({self._print(value)}) : {text})"
        return text

    def _print_Pi(self, expr: Any) -> str:
        return "Math.PI"

    def _print_Exp1(self, expr: Any) -> str:
        return "Math.E"


def _named_function(name: str) -> Any:
    def printed(printer: JavaScriptPrinter, expr: Any) -> str:
        return f"F.{name}({printer._print(expr.args[0])})"

    return printed


# Python's printer knows these by methods of their own, which would write math.exp.
for _name in {function.name for function in FUNCTIONS} | {function.__name__ for function in KERNELS}:
    setattr(JavaScriptPrinter, f"_print_{_name}", _named_function(_name))


def javascript_function(arguments: Sequence[Sequence[Any]], expressions: Sequence[Any]) -> str:
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
    '([a0, a1]) => {return [Math.sqrt(a0/a1)];}'
    """
    # The same common subexpressions, in the same order, as sympy's lambdify finds.
    common, reduced = sp.cse(list(map(sp.sympify, expressions)), list=False)
    return _function(arguments, common, cast(list, reduced))


def javascript_function_apart(arguments: Sequence[Sequence[Any]], expressions: Sequence[Any]) -> str:
    """The same with each expression evaluated on its own, as those of modes on demand are."""
    return _function(arguments, [], list(map(sp.sympify, expressions)))


def _function(arguments: Sequence[Sequence[Any]], common: Sequence[Any], reduced: Sequence[Any]) -> str:
    names = iter(f"a{i}" for i in range(sum(map(len, arguments))))
    arrays = [[next(names) for _ in some] for some in arguments]
    renamed = {s: n for some, array in zip(arguments, arrays) for s, n in zip(some, array, strict=True)}
    printer = _Renaming(renamed | {symbol: f"c{i}" for i, (symbol, _) in enumerate(common)})
    lines = [f"const c{i} = {printer.text(value)};" for i, (_, value) in enumerate(common)]
    values = ", ".join(map(printer.text, reduced))
    head = ", ".join(f"[{', '.join(array)}]" for array in arrays)
    return f"({head}) => {{{''.join(lines)}return [{values}];}}"


class _Renaming(JavaScriptPrinter):
    """Prints symbols by short names, which JavaScript can read whatever theirs are."""

    def __init__(self, names: dict[Any, str]) -> None:
        super().__init__()
        self._names_of_symbols = names

    def text(self, expr: Any) -> str:
        """An expression as JavaScript."""
        return str(self.doprint(expr))

    def _print_Symbol(self, expr: Any) -> str:
        return self._names_of_symbols[expr]

    _print_Dummy = _print_Symbol
