"""Expressions of parameters as functions of numbers, with this package's elementary functions.

Python's ``**`` and ``math`` are C's library.  Here integer powers are products, other powers and functions
those of the kernels; what has no finite real value raises, as ``math`` does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from frictionlab.hybrid.elementary import exponentials, trigonometry

KERNELS = (
    *(exponentials.exp, exponentials.sinh, exponentials.cosh, exponentials.tanh),
    *(exponentials.log, exponentials.asinh, exponentials.acosh, exponentials.atanh),
    *(trigonometry.sin, trigonometry.cos, trigonometry.tan),
    *(trigonometry.atan, trigonometry.asin, trigonometry.acos),
)


def integer_power(x: float, n: int) -> float:
    """x^n by squares, each made of the one before; their product goes from low to high."""
    value, square, count = 1.0, float(x), abs(n)
    while count:
        if count % 2:
            value *= square
        square *= square
        count //= 2
    return _finite(value if n >= 0 else 1.0 / value)


def real_power(x: float, y: float) -> float:
    """x^y; a product where y is an integer."""
    return integer_power(x, int(y)) if float(y).is_integer() else _finite(exponentials.power(x, y))


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise ArithmeticError("no finite real value")
    return value


def _checked(function: Callable[[float], float]) -> Callable[[float], float]:
    def checked(x: float) -> float:
        return _finite(function(float(x)))  # an integer would be another signature of the kernel

    return checked


_NAMESPACE: dict[str, Any] = {function.__name__: _checked(function) for function in KERNELS}
_NAMESPACE |= {"integer_power": integer_power, "real_power": real_power}


class ParameterPrinter(PythonCodePrinter):
    """Prints expressions with powers as calls of the functions here; also for a language that names them
    otherwise."""

    root, prefix = "sqrt", ""  # the square root, and what stands before the other functions

    def __init__(self) -> None:
        settings = {"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True}
        super().__init__(settings)

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        base, exponent = self._print(expr.base), expr.exp
        if exponent == sp.S.Half:
            return f"{self.root}({base})"
        if exponent == -sp.S.Half:
            return f"(1/{self.root}({base}))"
        if exponent.is_Integer:
            return f"{self.prefix}integer_power({base}, {exponent})"
        return f"{self.prefix}real_power({base}, {self._print(exponent)})"


def function_of_parameters(parameters: Sequence[Any], expressions: Any) -> Callable[..., Any]:
    """Function of the parameters that gives the values of one or several expressions.

    Parameters
    ----------
    parameters : sequence of Symbol
    expressions : Expr or list of Expr

    Raises
    ------
    ArithmeticError, ValueError, TypeError
        By the function, where there is no finite real value.

    Examples
    --------
    >>> import sympy
    >>> k, m = sympy.symbols("k m")
    >>> function_of_parameters([k, m], [sympy.sqrt(k / m), m**3])(8.0, 2.0)
    [2.0, 8.0]
    """
    several = isinstance(expressions, (list, tuple))
    return sp.lambdify(parameters, expressions, [_NAMESPACE, "math"], ParameterPrinter(), cse=several)
