"""Functions for laws: of floats, arrays and sympy symbols alike."""

from __future__ import annotations

import sys
from typing import Any

NAMES_IN_NUMPY = {"atan": "arctan", "asinh": "arcsinh"}  # of those that sympy calls otherwise


def _evaluate(name: str, x: Any) -> Any:
    # a sympy expression, so sympy is loaded already; laws themselves do not need it
    if hasattr(x, "free_symbols"):
        return getattr(sys.modules["sympy"], name)(x)
    import numpy  # imported here, as the command line reads the laws' parameters and should start quickly

    return getattr(numpy, NAMES_IN_NUMPY.get(name, name))(x)


def exp(x: Any) -> Any:
    """e^x."""
    return _evaluate("exp", x)


def log(x: Any) -> Any:
    """Natural logarithm."""
    return _evaluate("log", x)


def sqrt(x: Any) -> Any:
    """Square root."""
    return _evaluate("sqrt", x)


def sin(x: Any) -> Any:
    """Sine of an angle in radians."""
    return _evaluate("sin", x)


def cos(x: Any) -> Any:
    """Cosine of an angle in radians."""
    return _evaluate("cos", x)


def tan(x: Any) -> Any:
    """Tangent of an angle in radians."""
    return _evaluate("tan", x)


def tanh(x: Any) -> Any:
    """Hyperbolic tangent."""
    return _evaluate("tanh", x)


def sinh(x: Any) -> Any:
    """Hyperbolic sine."""
    return _evaluate("sinh", x)


def cosh(x: Any) -> Any:
    """Hyperbolic cosine."""
    return _evaluate("cosh", x)


def arctan(x: Any) -> Any:
    """Angle in radians whose tangent is x."""
    return _evaluate("atan", x)


def arcsinh(x: Any) -> Any:
    """Number whose hyperbolic sine is x: log(x + sqrt(1 + x^2)), as in rate-and-state friction."""
    return _evaluate("asinh", x)
