"""The operations of a tape by their numbers, and its functions, each an entry of `FUNCTIONS`: all that the
solver knows of a function such as tanh is in this file.

All functions have one recurrence for Taylor coefficients, k y_k = sum of j a_j s_(k-j) for y = f(a), whose
s = f'(a) is made of operations like any expression.  So interpreter, native code, lanes, gradients, tangents
and formulas need of a function only

* its name, its value at a number and at arrays, and its slope as operations (`Function`);
* its value in kernels (`function_value`);
* its range: how far it may go on a disc of complex numbers (`function_range`), by which the choice of a step
  takes account of a steep part of a friction law that lies ahead.

To add one: a number, a row of `FUNCTIONS`, a line in `function_value` and one in `function_range`.  The tests
of functions cover all rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.elementary import exponentials, trigonometry

AFFINE, PRODUCT, SQUARE, QUOTIENT, RATE, POWER = range(6)
FIRST_FUNCTION = 6  # the number of the first function; so an operation is a function where kind > POWER
NAMES_OF_OPERATIONS = ("affine", "product", "square", "quotient", "rate", "power")


EXP, LOG, SIN, COS, TAN, TANH, SINH, COSH, ATAN, ASINH, SECH2 = range(FIRST_FUNCTION, FIRST_FUNCTION + 11)

SINH_LIMIT = 700.0  # beyond, sinh overflows


CONSTANT_TERM = -1  # the key of the constant term in an affine combination {slot: coefficient}
Slope = dict[int, Any]  # an affine combination of slots


class Operations(Protocol):
    """What makes operations on slots, as a builder of a tape does; each returns the slot of its result."""

    def function(self, kind: int, a: int) -> int:
        """A function of a slot."""
        ...

    def product(self, a: int, b: int) -> int:
        """A product of two slots."""
        ...

    def inverse(self, terms: Slope) -> int:
        """1 over an affine combination."""
        ...

    def power(self, terms: Slope, exponent: float) -> int:
        """A power of an affine combination."""
        ...


@dataclass(frozen=True)
class Function:
    """A function of one argument.

    Parameters
    ----------
    kind : int
        Its number among the operations.
    name : str
        Name of the sympy function that is lowered to it.
    value : callable
        Of one number.
    array : callable
        Of arrays, complex numbers and intervals.
    slope : callable
        The derivative as a combination of slots, made by operations from the slots of the argument and of
        the function.
    public : bool
        Whether expressions of users may contain it; if not, it serves only as the derivative of another.
    """

    kind: int
    name: str
    value: Callable[[float], float]
    array: Callable[[Any], Any]
    slope: Callable[[Operations, int, int], Slope]
    public: bool = True

    @property
    def expression(self) -> Any:
        """The sympy function."""
        return sech2() if self.kind == SECH2 else getattr(sp, self.name)


@cache
def sech2() -> Any:
    """1/cosh(a)^2, the derivative of tanh: 1 - tanh(a)^2 would lose its digits where tanh is saturated.

    In a step from there to the steep part of tanh the loss would spoil the steep part too.
    """
    return type("sech2", (sp.Function,), {"nargs": 1, "__module__": __name__})


def _other(kind: int, factor: int = 1) -> Callable[[Operations, int, int], Slope]:
    """A slope that is a multiple of another function of the same argument."""
    return lambda make, a, y: {make.function(kind, a): factor}


def _sech2_of_arrays(x: Any) -> Any:
    with np.errstate(over="ignore"):  # beyond 710 the square is zero as a float
        return (1.0 / np.cosh(x)) ** 2


FUNCTIONS = (
    Function(EXP, "exp", exponentials.exp, np.exp, lambda make, a, y: {y: 1}),
    Function(LOG, "log", exponentials.log, np.log, lambda make, a, y: {make.inverse({a: 1}): 1}),
    Function(SIN, "sin", trigonometry.sin, np.sin, _other(COS)),
    Function(COS, "cos", trigonometry.cos, np.cos, _other(SIN, -1)),
    Function(
        TAN, "tan", trigonometry.tan, np.tan, lambda make, a, y: {make.product(y, y): 1, CONSTANT_TERM: 1}
    ),
    Function(TANH, "tanh", exponentials.tanh, np.tanh, _other(SECH2)),
    Function(SINH, "sinh", exponentials.sinh, np.sinh, _other(COSH)),
    Function(COSH, "cosh", exponentials.cosh, np.cosh, _other(SINH)),
    Function(
        ATAN,
        "atan",
        trigonometry.atan,
        np.arctan,
        lambda make, a, y: {make.inverse({make.product(a, a): 1, CONSTANT_TERM: 1}): 1},
    ),
    Function(
        ASINH,
        "asinh",
        exponentials.asinh,
        np.arcsinh,
        lambda make, a, y: {make.power({make.product(a, a): 1, CONSTANT_TERM: 1}, -0.5): 1},
    ),
    Function(
        SECH2,
        "sech2",
        exponentials.sech2,
        _sech2_of_arrays,
        lambda make, a, y: {make.product(make.function(TANH, a), y): -2},
        public=False,
    ),
)
OPERATION_NAMES = dict(enumerate(NAMES_OF_OPERATIONS)) | {f.kind: f.name for f in FUNCTIONS}
ALLOWED_OPERATIONS = "+, -, *, /, constant exponents, " + ", ".join(f.name for f in FUNCTIONS if f.public)


@cache
def function_table() -> dict[Any, Function]:
    """The functions by their sympy functions."""
    return {function.expression: function for function in FUNCTIONS}


@kernel
def function_value(kind, x):
    """Value of a function; NaN where no function is of this kind."""
    if kind == EXP:
        return exponentials.exp(x)
    if kind == LOG:
        return exponentials.log(x)
    if kind == SIN:
        return trigonometry.sin(x)
    if kind == COS:
        return trigonometry.cos(x)
    if kind == TAN:
        return trigonometry.tan(x)
    if kind == TANH:
        return exponentials.tanh(x)
    if kind == SINH:
        return exponentials.sinh(x)
    if kind == COSH:
        return exponentials.cosh(x)
    if kind == ATAN:
        return trigonometry.atan(x)
    if kind == ASINH:
        return exponentials.asinh(x)
    if kind == SECH2:
        return exponentials.sech2(x)
    return math.nan


@inlined
def tanh_range(a, y, slope, d):
    """Bound of |tanh(z) - tanh(a)| for |z - a| <= d; `y` and `slope` are the values at `a`."""
    near = far = math.inf
    if d < 1.5:  # from the addition theorem
        t = trigonometry.tan(d)
        if y * t < 1.0:
            near = slope * t / (1.0 - y * t)
    if d < abs(a):  # from tanh(z) = 1 - 2 q/(1 + q), q = exp(-2 z), which is at most w
        w = exponentials.exp(2.0 * (d - abs(a)))
        far = -2.0 * w * exponentials.expm1(-2.0 * d) / (1.0 - w)
    return min(near, far)


@inlined
def sech2_range(a, y, slope, d):
    """The same as :func:`tanh_range` for 1/cosh(z)^2."""
    near = far = math.inf
    half = exponentials.sinh(0.5 * min(d, 2.0))
    tanh = min(0.5 * slope / y, 1.0) if y > 0.0 else 1.0
    g = 2.0 * half * half + tanh * exponentials.sinh(
        min(d, 2.0)
    )  # bounds 1 - cosh(z)/cosh(a); above 1 before d = 2
    if g < 1.0:
        near = y * g * (2.0 - g) / ((1.0 - g) * (1.0 - g))
    if d < abs(a):  # by 4 q/(1 + q)^2
        w = exponentials.exp(2.0 * (d - abs(a)))
        far = 4.0 * w / ((1.0 - w) * (1.0 - w))
    return min(near, far)


@kernel
def function_range(kind, a, y, slope, d):
    """Bound of |f(z) - f(a)| for complex |z - a| <= d, infinite where a pole or branch point may be so near.

    `y` and `slope` are the absolute values of f and its derivative at `a`.
    """
    if kind == EXP:  # `y` may have underflowed where `a` is far below zero
        return y * exponentials.expm1(d) if d < 1.0 else exponentials.exp(a + d)
    if kind == LOG:
        return -exponentials.log1p(-d / a) if d < a else math.inf
    if kind == TANH:
        return tanh_range(a, y, slope, d)
    if kind == SECH2:
        return sech2_range(a, y, slope, d)
    if kind == TAN:
        t = trigonometry.tan(d) if d < 1.5 else math.inf
        return slope * t / (1.0 - y * t) if y * t < 1.0 else math.inf
    if kind == ATAN:  # its poles are at i and -i
        room = math.sqrt(1.0 + a * a) - d
        return d / (room * room) if room > 0.0 else math.inf
    if kind == ASINH:  # |f'(z)| is at most 1/(room - |z - a|), as its branch points are at i and -i
        room = math.sqrt(1.0 + a * a)
        return -exponentials.log1p(-d / room) if d < room else math.inf
    if kind in (SIN, COS, SINH, COSH) and d < SINH_LIMIT:
        half = exponentials.sinh(0.5 * d)
        return 2.0 * y * half * half + slope * exponentials.sinh(d)
    return math.inf
