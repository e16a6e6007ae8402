"""Expressions as functions of arrays, whose powers are those of the tape."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import sympy as sp
from sympy.printing.numpy import NumPyPrinter


def power(base: Any, exponent: Any) -> Any:
    """A power whose base counts as zero where it is below, as gap^1.5 at a gap of -1e-18 m by rounding."""
    with np.errstate(divide="ignore"):
        return np.maximum(base, 0.0) ** exponent


def formula(arguments: Sequence[Any], expressions: Any) -> Callable[..., Any]:
    """Function of arrays, in the order of the `arguments`, that gives the values of the expressions."""
    modules: list[Any] = [{"power": power}, "numpy"]
    return sp.lambdify(arguments, expressions, modules=modules, printer=_Printer, cse=True)


class _Printer(NumPyPrinter):
    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        if expr.exp.is_integer:
            return super()._print_Pow(expr, rational=rational)
        return f"power({self._print(expr.base)}, {self._print(expr.exp)})"
