"""The functions that printed expressions call: for parameters, and for arrays.

Python's ``**`` and ``math`` call C's library, whose last digits depend on the machine.  In expressions of
parameters integer powers are therefore products, and other powers and functions are those of the kernels;
where there is no finite real value they raise, as ``math`` does.  In expressions of arrays they are numpy's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from frictionlab.hybrid.elementary import exponentials, trigonometry

KERNELS = (
    *(exponentials.exp, exponentials.sinh, exponentials.cosh, exponentials.tanh),
    *(exponentials.log, exponentials.asinh, exponentials.acosh, exponentials.atanh),
    *(trigonometry.sin, trigonometry.cos, trigonometry.tan),
    *(trigonometry.atan, trigonometry.asin, trigonometry.acos),
)


def integer_power(x: float, n: int) -> float:
    """x^n by repeated squaring; the squares are multiplied from the lowest power to the highest."""
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


def nonnegative_power(base: Any, exponent: Any) -> Any:
    """A power whose base counts as zero where it is negative, as rounding may make it: penetration^1.5 at a
    penetration of -1e-18 m."""
    with np.errstate(divide="ignore"):
        return np.maximum(base, 0.0) ** exponent


# Names that code printed by `expression_functions` may use: for numbers, arrays, and outputs along a run.
OF_PARAMETERS: dict[str, Any] = {name: value for name, value in vars(math).items() if name[0] != "_"}
OF_PARAMETERS |= {function.__name__: _checked(function) for function in KERNELS}
OF_PARAMETERS |= {"integer_power": integer_power, "real_power": real_power, "abs": abs}
# Given "numpy", sympy loads all of it, test tools and f2py too: a tenth of a second at every start.
OF_ARRAYS: dict[str, Any] = {name: value for name, value in vars(np).items() if name[0] != "_"}
OF_OUTPUTS: dict[str, Any] = OF_ARRAYS | {"power": nonnegative_power}
