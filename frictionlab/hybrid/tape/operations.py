"""The operations of a tape: their numbers, their names, and the functions among them.

Kernels, code generation and the builder of tapes all know an operation by its number here.  Each operation
has a recurrence for Taylor coefficients (:mod:`frictionlab.hybrid.kernels.jets`).  The derivative of a
function is lowered like any expression, so that its value is all that is new about it.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from frictionlab.automaton.mode import Expr

AFFINE, PRODUCT, SQUARE, QUOTIENT, RATE, POWER = range(6)

EXP, LOG, SIN, COS, TAN, TANH, SINH, COSH, ATAN, SECH2 = 6, 7, 8, 9, 10, 11, 12, 13, 14, 15


class sech2(sp.Function):
    """1/cosh(a)^2, the derivative of tanh: 1 - tanh(a)^2 would lose its digits where tanh is saturated.

    Lost there, they are lost in the layer too, when a step comes from afar.
    """

    nargs = 1

    def fdiff(self, argindex: int = 1) -> Expr:
        return -2 * sp.tanh(self.args[0]) * self


# A function's derivative is lowered like any expression, so that its value is all that is new about it.
USER_FUNCTIONS: tuple[Any, ...] = (sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.tanh, sp.sinh, sp.cosh, sp.atan)
FUNCTIONS = (*USER_FUNCTIONS, sech2)
OPERATION_NAMES = (
    "affine",
    "product",
    "square",
    "quotient",
    "rate",
    "power",
    *(f.__name__ for f in FUNCTIONS),
)
ALLOWED_OPERATIONS = "+, -, *, /, constant exponents, " + ", ".join(f.__name__ for f in USER_FUNCTIONS)
