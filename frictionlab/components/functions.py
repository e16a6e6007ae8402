"""Functions for laws: of floats, arrays and sympy symbols alike.

Some are in pieces: `piecewise`, `minimum`, `maximum`, `absolute`, `sign`, `interpolate`.  Where they depend
on the state, each of their borders is an event of the motion, so that they are as exact as smooth ones.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from itertools import pairwise
from typing import Any

from frictionlab.validation import (
    P,
    R,
    abbreviate,
    check_choice,
    check_sequence,
    explains_keywords,
    float_array,
    is_sequence,
)

GIVE_NUMBER = "give a number, an array or an expression"
TINY = 1e-300  # keeps a quotient of zeros from having no value
PIECES = "piecewise(x, (0.0,), (below, above))"
NAMES_IN_NUMPY = {"atan": "arctan", "asinh": "arcsinh"}  # of those that sympy calls otherwise


def __getattr__(name: str) -> Any:
    public = [key for key, value in globals().items() if getattr(value, "__module__", "") == __name__]
    names = [key for key in public if not key.startswith("_")]
    raise AttributeError(f"fl.functions has no {name!r}: it has {', '.join(names)}")


def _evaluate(name: str, x: Any) -> Any:
    # a sympy expression, so sympy is loaded already; laws themselves do not need it
    if hasattr(x, "free_symbols"):
        return getattr(sys.modules["sympy"], name)(x)
    import numpy  # imported here, as the command line reads the laws' parameters and should start quickly

    try:
        return getattr(numpy, NAMES_IN_NUMPY.get(name, name))(x)
    except TypeError:
        float_array("x", x, GIVE_NUMBER)  # which says what is wrong with it
        raise


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


def _takes_no_pairs(function: Callable[P, R]) -> Callable[P, R]:
    """Let :func:`piecewise` answer the arguments of sympy's Piecewise, of which there may be any number."""

    @wraps(function)
    def call(*arguments: P.args, **keywords: P.kwargs) -> R:
        first: Any = arguments[0] if arguments else None
        if isinstance(first, (tuple, list)) and len(first) == 2 and _is_condition(first[1]):
            raise ValueError(
                "x must be what the borders are of, got a pair of an expression and a condition, "
                f"{abbreviate(first)}: write Piecewise((below, x < 0), (above, True)) as {PIECES}"
            )
        return function(*arguments, **keywords)

    return call


def _is_condition(value: Any) -> bool:
    """Whether it is true or false, as x < 0 is, of numbers or symbols."""
    kinds = "is_Boolean", "is_Relational"
    return isinstance(value, bool) or any(getattr(value, kind, False) for kind in kinds)


@_takes_no_pairs
@explains_keywords
def piecewise(x: Any, borders: Sequence[Any], values: Sequence[Any]) -> Any:
    """The first value where x is below the first border, the second from there to the next, and so on.

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
    cure = f"give what holds on each side, {PIECES}"
    x = _number_or_expression("x", x)
    borders = [_number_or_expression("borders", one) for one in check_sequence("borders", borders, cure)]
    values = [_number_or_expression("values", one) for one in check_sequence("values", values, cure)]
    if not borders or len(values) != len(borders) + 1:
        raise ValueError(
            f"values must be one more than borders, and these one at least, got {len(values)} and "
            f"{len(borders)}: {cure}"
        )
    if nan := [one for one in borders if not hasattr(one, "free_symbols") and one != one]:
        raise ValueError(f"borders must be numbers or expressions, got {nan[0]}: {cure}")
    for low, high in pairwise(borders):
        if not _are_expressions(low, high) and not low < high:
            raise ValueError(
                f"borders must ascend, got {high:g} after {low:g}: sort them, and the values too"
            )
    if _are_expressions(x, *borders, *values):
        from frictionlab.automaton.pieces import Pieces  # it loads sympy, which is loaded already

        return Pieces(x, *borders, *values)
    import numpy

    chosen = numpy.select([numpy.less(x, one) for one in borders], values[:-1], values[-1])
    missing = numpy.isnan(x)
    return _plain(numpy.where(missing, numpy.nan, chosen) if missing.any() else chosen)


def _are_expressions(*arguments: Any) -> bool:
    return any(hasattr(one, "free_symbols") for one in arguments)


def _is_number_of_sympy(value: Any) -> bool:
    return hasattr(value, "free_symbols") and not value.free_symbols


def _number_or_expression(name: str, value: Any) -> Any:
    """An expression and a plain number as they are; other numbers as a float or an array of floats."""
    if _is_condition(value):
        raise ValueError(f"{name} must be numbers or expressions, got the condition {value}: {GIVE_NUMBER}")
    if hasattr(value, "free_symbols") or type(value) is float or (type(value) is int and abs(value) < 2**53):
        return value
    return _plain(float_array(name, value, GIVE_NUMBER))


def _plain(numbers: Any) -> Any:
    return numbers if numbers.ndim else numbers.item()


def absolute(x: Any) -> Any:
    """|x|."""
    return piecewise(x, (0,), (-x, x)) if hasattr(x, "free_symbols") else _evaluate("abs", x)


def sign(x: Any) -> Any:
    """1 where x is positive, -1 where it is negative.

    A force that jumps where a velocity changes its sign is dry friction.  That is a contact's, `fl.Friction`,
    which also sticks.
    """
    return piecewise(x, (0,), (-1, 1)) if hasattr(x, "free_symbols") else _evaluate("sign", x)


def minimum(a: Any, b: Any) -> Any:
    """The smaller of two values."""
    return _of_two("minimum", a, b)


def maximum(a: Any, b: Any) -> Any:
    """The greater of two values."""
    return _of_two("maximum", a, b)


def _of_two(name: str, a: Any, b: Any) -> Any:
    a, b = _number_or_expression("a", a), _number_or_expression("b", b)
    if not _are_expressions(a, b):
        import numpy

        return _plain(getattr(numpy, name)(a, b))
    a, b = (a, b) if _are_expressions(a) else (b, a)
    return piecewise(a, (b,), (a, b) if name == "minimum" else (b, a))


def interpolate(x: Any, xs: Sequence[Any], ys: Sequence[Any], kind: str = "pchip") -> Any:
    """A curve through measured points: y at x, constant below the first point and above the last.

    Parameters
    ----------
    x : float, array or Expr
    xs, ys : sequence of float or Expr
        The points, with ascending xs; they may be parameters.
    kind : {"pchip", "linear"}
        "pchip" is a monotone cubic between each two points, with a continuous slope: it does not overshoot.
        F. N. Fritsch, J. Butland, SIAM Journal on Scientific and Statistical Computing 5 (1984) 300-304,
        with the end slopes of scipy's `PchipInterpolator`.

    Raises
    ------
    ValueError
        Unless there are as many xs as ys, two at least, and the xs ascend; for a y that is NaN or infinite.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.functions.interpolate(1.5, (0.0, 1.0, 2.0), (0.3, 0.2, 0.2), kind="linear")
    0.2
    """
    check_choice("kind", kind, ("pchip", "linear"))
    x = _number_or_expression("x", x)
    xs, ys = (
        [
            _number_or_expression(name, one)
            for one in check_sequence(name, values, "give a number for each point")
        ]
        for name, values in {"xs": xs, "ys": ys}.items()
    )
    if len(xs) != len(ys) or len(xs) < 2:
        raise ValueError(
            f"ys must be as many as xs, and two at least, got {len(ys)} and {len(xs)}: give a point for each"
        )
    steps = [after - before for before, after in pairwise(xs)]
    if not all(
        step.is_positive if _is_number_of_sympy(step) else _are_expressions(step) or step > 0
        for step in steps
    ):
        raise ValueError(f"xs must ascend, got {abbreviate(xs)}: sort the points by x, and leave out doubles")
    import numpy

    if not all(
        y.is_real if _is_number_of_sympy(y) else _are_expressions(y) or numpy.isfinite(y).all() for y in ys
    ):
        raise ValueError(f"ys must be finite numbers, got {abbreviate(ys)}: leave out points without a value")
    chords = [(after - before) / step for before, after, step in zip(ys, ys[1:], steps)]
    if kind == "linear" or len(xs) == 2:
        between = [y + chord * (x - at) for at, y, chord in zip(xs, ys, chords)]
        return piecewise(x, xs, [ys[0], *between, ys[-1]])
    slopes = _monotone_slopes(steps, chords)
    cubics = []
    for i, (step, chord) in enumerate(zip(steps, chords)):
        s, first, last = x - xs[i], slopes[i], slopes[i + 1]
        square = (3 * chord - 2 * first - last) / step
        cube = (first + last - 2 * chord) / step**2
        cubics.append(ys[i] + s * (first + s * (square + s * cube)))
    return piecewise(x, xs, [ys[0], *cubics, ys[-1]])


def _monotone_slopes(steps: Sequence[Any], chords: Sequence[Any]) -> list[Any]:
    """The slopes at the points: a weighted harmonic mean of those of the chords, or 0 at a turning point."""
    inner = []
    for before, after, one, other in zip(steps, steps[1:], chords, chords[1:]):
        first, second = 2 * after + before, after + 2 * before
        below = maximum(first * absolute(other) + second * absolute(one), TINY)
        inner.append(piecewise(-one * other, (0,), ((first + second) * one * absolute(other) / below, 0)))
    return [_end_slope(steps[:2], chords[:2]), *inner, _end_slope(steps[:-3:-1], chords[:-3:-1])]


def _end_slope(steps: Sequence[Any], chords: Sequence[Any]) -> Any:
    """The slope at an end by three points, limited so that the curve is monotone there."""
    (near, far), (chord, other) = steps, chords
    slope = ((2 * near + far) * chord - near * other) / (near + far)
    turns = piecewise(-chord * other, (0,), (0, 1))  # the chords have different signs
    steep = piecewise(absolute(slope) - 3 * absolute(chord), (0,), (0, 1))
    slope = slope + turns * steep * (3 * chord - slope)
    return piecewise(-slope * chord, (0,), (slope, 0))


def ramp(t: Any, start: Any, end: Any, duration: Any) -> Any:
    """A value that goes linearly from `start` at t = 0 to `end` at t = `duration`, and stays there.

    Parameters
    ----------
    t : float, array or Expr
        The time ``q.t``, or ``q.t - 5.0`` for a ramp that begins at 5 s.
    start, end : float or Expr
    duration : float or Expr
        s, above 0.

    Raises
    ------
    ValueError
        Where the duration is a number that is not above 0.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.ramp(2.0, start=0.0, end=1.0, duration=8.0)
    0.25
    """
    t, start, end, duration = (
        _number_or_expression(name, value)
        for name, value in {"t": t, "start": start, "end": end, "duration": duration}.items()
    )
    if not _are_expressions(duration) and (getattr(duration, "ndim", 0) or not duration > 0):
        raise ValueError(
            f"duration must be a number above 0, got {abbreviate(duration)}: write piecewise for a step"
        )
    return piecewise(t, (0.0, duration), (start, start + (end - start) * t / duration, end))


def table(t: Any, values: Any, kind: str = "pchip") -> Any:
    """A value that is given at some times, and interpolated between them.

    Parameters
    ----------
    t : float, array or Expr
        The time ``q.t``.
    values : mapping, or sequence of pairs
        The value at each time, ``{0.0: 1.0, 5.0: 0.2}`` or ``[(0.0, 1.0), (5.0, 0.2)]``.
    kind : {"pchip", "linear"}
        As of :func:`interpolate`.

    Raises
    ------
    ValueError
        Unless there are two pairs at least, by ascending times.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.table(1.0, {0.0: 1.0, 5.0: 0.0}, kind="linear")
    0.8
    """
    cure = "write {0.0: 1.0, 5.0: 0.2}, a value for each time, or list(zip(times, values))"
    pairs = list(values.items() if isinstance(values, Mapping) else check_sequence("values", values, cure))
    if any(not is_sequence(pair) or len(pair) != 2 for pair in pairs):
        raise ValueError(f"values must give a value for each time, got {abbreviate(values)}: {cure}")
    if len(pairs) < 2:
        raise ValueError(f"values must be given at two times at least, got {abbreviate(values)}: {cure}")
    times, given = zip(*((_number_or_expression("values", time), value) for time, value in pairs))
    if any(not after > before for before, after in pairwise(times) if not _are_expressions(before, after)):
        raise ValueError(
            f"the times of values must ascend, got {abbreviate(times)}: sort them, with one value for each"
        )
    return interpolate(t, times, given, kind)
