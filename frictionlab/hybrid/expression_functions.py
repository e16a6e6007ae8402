"""Sympy expressions as Python functions of numbers or arrays, whose code sympy writes.

The numbers in tapes are functions of the parameters.  They call this package's elementary functions, whose
bits are the same everywhere (`function_of_parameters`).  Statics and Jacobians are functions of arrays that
call numpy (`numpy_function`).  Outputs along a run are such functions too, but their powers follow the rule
of the tape (`array_function`): a base that rounding has made negative counts as zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import sympy as sp
from sympy.printing.numpy import NumPyPrinter
from sympy.printing.pycode import PythonCodePrinter

from frictionlab.automaton.expressions import integer_exponent
from frictionlab.hybrid.elementary.parameter_functions import OF_ARRAYS, OF_OUTPUTS, OF_PARAMETERS

_SETTINGS = {"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True}


class ParameterPrinter(PythonCodePrinter):
    """Prints powers as calls of `integer_power` and `real_power`; a subclass may print other names, for
    another language."""

    root, prefix = "sqrt", ""  # the square root's name, and the prefix of the power functions

    def __init__(self) -> None:
        super().__init__(_SETTINGS)

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        base, exponent = self._print(expr.base), expr.exp
        if exponent == sp.S.Half:
            return f"{self.root}({base})"
        if exponent == -sp.S.Half:
            return f"(1/{self.root}({base}))"
        if exponent.is_Integer:
            return f"{self.prefix}integer_power({base}, {exponent})"
        return f"{self.prefix}real_power({base}, {self._print(exponent)})"


def _lambdify(arguments: Sequence[Any], expressions: Any, modules: list[Any], **options: Any) -> Any:
    """As sympy's; arguments named as one of the functions, such as power, get other names."""
    functions = {n for names in modules if isinstance(names, dict) for n in names if callable(names[n])}
    others = {name: sp.Dummy() for name in arguments if str(name) in functions}
    if others:
        several = isinstance(expressions, (list, tuple))
        each = expressions if several else [expressions]
        changed = [sp.sympify(one, strict=True).xreplace(others) for one in each]
        arguments = [others.get(name, name) for name in arguments]
        expressions = changed if several else changed[0]
    return sp.lambdify(arguments, expressions, modules, **options)


def function_of_parameters(parameters: Sequence[Any], expressions: Any) -> Callable[..., Any]:
    """Function of the parameters that gives the values of one or several expressions.

    Parameters
    ----------
    parameters : sequence of Symbol
    expressions : Expr or list of Expr

    Raises
    ------
    ArithmeticError, ValueError, TypeError
        When the function is called, where a value is not finite and real.

    Examples
    --------
    >>> import sympy
    >>> k, m = sympy.symbols("k m")
    >>> function_of_parameters([k, m], [sympy.sqrt(k / m), m**3])(8.0, 2.0)
    [2.0, 8.0]
    """
    several = isinstance(expressions, (list, tuple))
    printer = ParameterPrinter()
    return _lambdify(parameters, expressions, [OF_PARAMETERS, "math"], printer=printer, cse=several)


def numpy_function(arguments: Sequence[Any], expressions: Any) -> Callable[..., Any]:
    """Function of numbers or arrays, in the order of the `arguments`: the values of the expressions."""
    printer = NumPyPrinter(_SETTINGS)
    return _lambdify(arguments, expressions, [OF_ARRAYS], printer=printer, cse=True)


def array_function(arguments: Sequence[Any], expressions: Any) -> Callable[..., Any]:
    """Function of arrays, in the order of the `arguments`, that gives the values of the expressions."""
    printer = _ArrayPrinter(_SETTINGS)
    return _lambdify(arguments, expressions, [OF_OUTPUTS], printer=printer, cse=True)


class _ArrayPrinter(NumPyPrinter):
    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        if expr.exp.is_integer or integer_exponent(expr) is not None:
            return super()._print_Pow(expr, rational=rational)
        return f"power({self._print(expr.base)}, {self._print(expr.exp)})"
