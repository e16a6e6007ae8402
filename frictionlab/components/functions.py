"""Functions for laws: of floats, arrays and sympy symbols alike.

Some are in pieces: `piecewise`, `minimum`, `maximum`, `absolute`, `sign`, `interpolate`.  Where they depend on the
state each of their borders is an event of the motion, so that they are as exact as smooth ones.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

NAMES_IN_NUMPY = {"atan": "arctan", "asinh": "arcsinh"}  # of those that sympy calls otherwise


def _evaluate(name: str, x: Any) -> Any:
    # a sympy expression, so sympy is loaded already; laws themselves do not need it
    if hasattr(x, "free_symbols"):
        return getattr(sys.modules["sympy"], name)(x)
    import numpy  # imported here, as the command line reads the laws' parameters and should start quickly

    return getattr(numpy, NAMES_IN_NUMPY.get(name, name))(x)


def _evaluate_two(name: str, a: Any, b: Any) -> Any:
    import numpy

    return getattr(numpy, name)(a, b)


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


def piecewise(x: Any, borders: Sequence[Any], values: Sequence[Any]) -> Any:
    """The first of some values where x is below the first border, the second up to the next border, and so on.

    Parameters
    ----------
    x : float, array or Expr
    borders : sequence of float or Expr
        In ascending order.
    values : sequence of float, array or Expr
        One more than there are borders.  On a border the value above it holds.

    Raises
    ------
    ValueError
        Unless there is one more value than there are borders, and these ascend.

    Examples
    --------
    A spring of stiffness 4 N/m with a backlash of 0.1 m to either side:

    >>> import frictionlab as fl
    >>> def force(x):
    ...     return fl.functions.piecewise(x, (-0.1, 0.1), (4 * (x + 0.1), 0.0, 4 * (x - 0.1)))
    >>> force(0.6), force(0.05)
    (2.0, 0.0)
    """
    borders, values = [*borders], [*values]
    if not borders or len(values) != len(borders) + 1:
        raise ValueError(
            "values must be one more than borders, and these one at least, got "
            f"{len(values)} and {len(borders)}: give what holds on each side, piecewise(x, (0,), (below, above))"
        )
    for low, high in zip(borders, borders[1:]):
        if not (hasattr(low, "free_symbols") or hasattr(high, "free_symbols")) and not low < high:
            raise ValueError(f"borders must ascend, got {high:g} after {low:g}: sort them, and the values too")
    if any(hasattr(one, "free_symbols") for one in (x, *borders, *values)):
        from frictionlab.automaton.pieces import Pieces  # it loads sympy, which is loaded already

        return Pieces(x, *borders, *values)
    import numpy

    return numpy.select([numpy.less(x, one) for one in borders], values[:-1], values[-1])[()]


def absolute(x: Any) -> Any:
    """|x|."""
    return piecewise(x, (0,), (-x, x)) if hasattr(x, "free_symbols") else _evaluate("abs", x)


def sign(x: Any) -> Any:
    """1 where x is positive, -1 where it is negative.

    A force that jumps where a velocity changes its sign is dry friction: that is a contact's, `fl.Friction`, which
    also sticks.
    """
    return piecewise(x, (0,), (-1, 1)) if hasattr(x, "free_symbols") else _evaluate("sign", x)


def minimum(a: Any, b: Any) -> Any:
    """The smaller of two values."""
    a, b = (a, b) if hasattr(a, "free_symbols") else (b, a)
    return piecewise(a, (b,), (a, b)) if hasattr(a, "free_symbols") else _evaluate_two("minimum", a, b)


def maximum(a: Any, b: Any) -> Any:
    """The greater of two values."""
    a, b = (a, b) if hasattr(a, "free_symbols") else (b, a)
    return piecewise(a, (b,), (b, a)) if hasattr(a, "free_symbols") else _evaluate_two("maximum", a, b)
