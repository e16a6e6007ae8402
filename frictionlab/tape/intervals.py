"""Arithmetic of intervals, by which a function of numbers gives bounds of its values in a box.

An :class:`Interval` takes the place of an array: in formulas (:mod:`frictionlab.tape.formulas`), by which
equilibria are searched for, and in the operations of modes, by which a run's guards are bounded.  Results are
rounded outwards, so that no value in the box is left out.  If a function is defined in a part of the box, it
is bounded there.  If it is defined nowhere, its bounds are NaN, the empty interval.  R. E. Moore, R. B.
Kearfott, M. J. Cloud, "Introduction to Interval Analysis", SIAM 2009.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FUNCTION_ULPS = 4  # by which numpy's functions may be off, and more
TURN = 2 * np.pi


class Interval:
    """Bounds (N,) of N numbers.

    Parameters
    ----------
    low, high : array (N,)
        NaN where there is no number.
    """

    def __init__(self, low: Any, high: Any) -> None:
        self.low, self.high = low, high

    def __getitem__(self, some: Any) -> Interval:
        return Interval(self.low[some], self.high[some])

    @property
    def width(self) -> Any:
        """How far the ends are apart."""
        return self.high - self.low

    @property
    def magnitude(self) -> Any:
        """The largest absolute value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def __add__(self, other: Any) -> Interval:
        other = interval(other)
        low, high = self.low + other.low, self.high + other.high
        lost = np.isnan(low) | np.isnan(high)
        if lost.any():  # infinity less infinity; what was empty before stays empty
            lost &= ~(np.isnan(self.low) | np.isnan(other.low))
            low, high = np.where(lost, -np.inf, low), np.where(lost, np.inf, high)
        return _outwards(low, high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __pos__(self) -> Interval:
        return self

    def __sub__(self, other: Any) -> Interval:
        return self + -interval(other)

    def __rsub__(self, other: Any) -> Interval:
        return interval(other) + -self

    def __mul__(self, other: Any) -> Interval:
        if other is self:
            return self**2
        if not isinstance(other, Interval) and np.isfinite(other).all() and np.all(other):
            return _outwards(*_ordered(self.low * other, self.high * other))
        other = interval(other)
        products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        low, high = _extremes(products)
        if np.isnan(low).any():
            empty = np.isnan(self.low) | np.isnan(other.low)
            # Zero times a number however large is zero.
            low, high = _extremes([np.where(np.isnan(each), 0.0, each) for each in products])
            low, high = np.where(empty, np.nan, low), np.where(empty, np.nan, high)
        return _outwards(low, high)

    def reciprocal(self) -> Interval:
        """1/x; without bounds where zero lies inside."""
        low = np.where((self.low < 0) & (self.high >= 0), -np.inf, 1.0 / _signed(self.high, 1.0))
        high = np.where((self.low <= 0) & (self.high > 0), np.inf, 1.0 / _signed(self.low, -1.0))
        zero = (self.low == 0) & (self.high == 0)
        return _outwards(np.where(zero, np.nan, low), np.where(zero, np.nan, high))

    def __truediv__(self, other: Any) -> Interval:
        if not isinstance(other, Interval):
            return _outwards(*_ordered(self.low / other, self.high / other))
        return self * other.reciprocal()

    def __rtruediv__(self, other: Any) -> Interval:
        return interval(other) * self.reciprocal()

    def __pow__(self, exponent: Any) -> Interval:
        if isinstance(exponent, Interval):
            return self._varying_power(exponent)
        if not np.isrealobj(exponent):
            raise TypeError(f"an interval to the power of {exponent!r} has no bounds")
        exponent = np.asarray(exponent, float)
        whole, odd = exponent == np.floor(exponent), exponent % 2 == 1
        power = self._root_or_power(np.abs(exponent), whole, odd)
        if not (exponent < 0).any():
            return power
        inverse = power.reciprocal()
        return Interval(
            np.where(exponent < 0, inverse.low, power.low), np.where(exponent < 0, inverse.high, power.high)
        )

    def _root_or_power(self, exponent: Any, whole: Any, odd: Any) -> Interval:
        """A power with an exponent of at least 0, defined for positive numbers only where it is not whole."""
        positive = self if whole.all() else self._where_positive()
        least = np.where(whole, self.low, positive.low)
        low, high = _ordered(least**exponent, np.where(whole, self.high, positive.high) ** exponent)
        low = np.where(~odd & (least <= 0) & (self.high >= 0), exponent == 0, low)
        return _outwards(low, high, FUNCTION_ULPS).cut(np.where(odd, -np.inf, 0.0), np.inf)

    def _varying_power(self, exponent: Interval) -> Interval:
        """A power by its logarithm; unknown where the base may be negative, as a whole exponent may be."""
        power, positive = np.exp(exponent * np.log(self)), self.low >= 0
        return Interval(np.where(positive, power.low, -np.inf), np.where(positive, power.high, np.inf))

    def __rpow__(self, base: Any) -> Interval:
        if isinstance(base, Interval) or not np.all(np.asarray(base) > 0):
            raise TypeError(f"{base!r} to the power of an interval has no bounds")
        return np.exp(self * np.log(base))

    def __abs__(self) -> Interval:
        low, high = _ordered(np.abs(self.low), np.abs(self.high))
        return Interval(np.where(self.contains_zero(), 0.0, low), high)

    __radd__, __rmul__ = __add__, __mul__

    def cut(self, least: Any, most: Any) -> Interval:
        """The part of it between two numbers: what is known of the function by itself."""
        return Interval(np.maximum(self.low, least), np.minimum(self.high, most))

    def within(self, least: float, most: float) -> Interval:
        """The part in which a function is defined that needs arguments between two numbers."""
        none = (self.high < least) | (self.low > most)
        part = self.cut(least, most)
        return Interval(np.where(none, np.nan, part.low), np.where(none, np.nan, part.high))

    def _where_positive(self) -> Interval:
        """The part in which roots and logarithms are defined."""
        return self.within(0.0, np.inf)

    def contains_zero(self) -> Any:
        """Whether zero lies inside."""
        return (self.low <= 0) & (self.high >= 0)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            return NotImplemented
        if ufunc in OPERATIONS:
            return OPERATIONS[ufunc](*map(interval, inputs))
        if ufunc is np.power:
            base, exponent = inputs
            return base**exponent if isinstance(base, Interval) else exponent.__rpow__(base)
        if ufunc is np.true_divide:
            return (
                inputs[0] * inputs[1].reciprocal()
                if isinstance(inputs[1], Interval)
                else inputs[0] / inputs[1]
            )
        raise TypeError(f"{ufunc.__name__} of an interval has no bounds")


def interval(value: Any) -> Interval:
    """A number, or an array, as an interval."""
    return (
        value if isinstance(value, Interval) else Interval(np.asarray(value, float), np.asarray(value, float))
    )


def _signed(x: Any, sign: float) -> Any:
    """Zeros with the sign from which they are approached."""
    return np.where(x == 0, np.copysign(0.0, sign), x)


def _ordered(one: Any, other: Any) -> tuple[Any, Any]:
    return np.minimum(one, other), np.maximum(one, other)


def _extremes(numbers: Sequence[Any]) -> tuple[Any, Any]:
    """The least and the greatest of four, NaN where one is."""
    one, two, three, four = numbers
    low = np.minimum(np.minimum(one, two), np.minimum(three, four))
    return low, np.maximum(np.maximum(one, two), np.maximum(three, four))


def _outwards(low: Any, high: Any, ulps: int = 1) -> Interval:
    for _ in range(ulps):
        low, high = np.nextafter(low, -np.inf), np.nextafter(high, np.inf)
    return Interval(low, high)


def _ascending(function: Callable[[Any], Any], least: float = -np.inf, most: float = np.inf) -> Any:
    return lambda x: _outwards(function(x.low), function(x.high), FUNCTION_ULPS).cut(least, most)


def _where_defined(function: Callable[[Any], Any], least: float = -np.inf) -> Any:
    def bounds(x: Interval) -> Interval:
        x = x._where_positive()
        return _outwards(function(x.low), function(x.high), FUNCTION_ULPS).cut(least, np.inf)

    return bounds


def _cosh(x: Interval) -> Interval:
    low, high = _ordered(np.cosh(x.low), np.cosh(x.high))
    return _outwards(np.where(x.contains_zero(), 1.0, low), high, FUNCTION_ULPS).cut(1.0, np.inf)


def _sine(x: Interval, shift: float = 0.0) -> Interval:
    """sin(x + shift): 1 and -1 where a crest or a trough may lie inside."""
    wide = ~(x.high - x.low < TURN)
    low, high = np.where(wide, 0.0, x.low), np.where(wide, 0.0, x.high)
    values = _ordered(np.sin(low + shift), np.sin(high + shift))
    # Rounding of large arguments moves crests by that much; with them the bounds are widened.
    room = 8 * np.finfo(float).eps * (np.maximum(np.abs(low), np.abs(high)) + TURN)

    def holds(phase: float) -> Any:
        first = np.ceil((low - room + shift - phase) / TURN)
        return wide | (phase + TURN * first <= high + room + shift)

    least = np.where(holds(-np.pi / 2), -1.0, values[0] - room)
    most = np.where(holds(np.pi / 2), 1.0, values[1] + room)
    empty = np.isnan(x.low)
    return Interval(np.where(empty, np.nan, least), np.where(empty, np.nan, most)).cut(-1.0, 1.0)


def _tangent(x: Interval) -> Interval:
    """It ascends between poles, which are zeros of the cosine."""
    pole = _sine(x, np.pi / 2).contains_zero()
    between = _ascending(np.tan)(x)
    return Interval(np.where(pole, -np.inf, between.low), np.where(pole, np.inf, between.high))


def _jump(x: Interval, below: float, middle: Any) -> Interval:
    """A step at zero from `below` to 1."""
    low = np.where(x.low > 0, 1.0, np.where(x.low == 0, np.fmin(middle, 1.0), below))
    high = np.where(x.high < 0, below, np.where(x.high == 0, np.fmax(middle, below), 1.0))
    empty = np.isnan(x.low)
    return Interval(np.where(empty, np.nan, low), np.where(empty, np.nan, high))


def _angle(y: Interval, x: Interval) -> Interval:
    """The angle of a point in a rectangle: from corner to corner, unless that meets the negative axis."""
    low, high = _extremes([np.arctan2(b, a) for b in (y.low, y.high) for a in (x.low, x.high)])
    around = crosses_negative_axis(y, x)
    whole = _outwards(np.where(around, -np.pi, low), np.where(around, np.pi, high), FUNCTION_ULPS)
    empty = np.isnan(x.low) | np.isnan(y.low)
    return Interval(np.where(empty, np.nan, whole.low), np.where(empty, np.nan, whole.high))


def crosses_negative_axis(y: Interval, x: Interval) -> Any:
    """Whether a rectangle may meet the half line y = 0, x <= 0, where angles jump."""
    return y.contains_zero() & (x.low <= 0)


def _less(x: Interval, y: Interval) -> Interval:
    return _truth(x.high < y.low, x.low < y.high)


def _less_or_equal(x: Interval, y: Interval) -> Interval:
    return _truth(x.high <= y.low, x.low <= y.high)


def _equal(x: Interval, y: Interval) -> Interval:
    meet = (x.low <= y.high) & (y.low <= x.high)
    return _truth(meet & (x.low == x.high) & (y.low == y.high), meet)


def _truth(sure: Any, possible: Any) -> Interval:
    """0 or 1, or both where it is not known."""
    return Interval(np.asarray(sure, float), np.asarray(possible, float))


def select(condition: Any, a: Any, b: Any) -> Any:
    """`a` where a condition holds and `b` elsewhere; of intervals both where that is not known."""
    if not any(isinstance(each, Interval) for each in (condition, a, b)):
        return np.where(condition, a, b)
    holds, a, b = map(interval, (condition, a, b))
    both = [np.fmin(a.low, b.low), np.fmax(a.high, b.high)]
    ends = zip((a.low, a.high), both, (b.low, b.high), strict=True)
    low, high = (
        np.where(holds.low > 0, one, np.where(holds.high > 0, union, other)) for one, union, other in ends
    )
    return Interval(low, high)


def _largest(x: Interval, y: Interval) -> Interval:
    return Interval(np.maximum(x.low, y.low), np.maximum(x.high, y.high))


OPERATIONS: dict[Any, Callable[..., Interval]] = {
    np.add: Interval.__add__,
    np.subtract: Interval.__sub__,
    np.multiply: Interval.__mul__,
    np.negative: Interval.__neg__,
    np.positive: Interval.__pos__,
    np.square: lambda x: x**2,
    np.absolute: Interval.__abs__,
    np.sign: lambda x: _jump(x, -1.0, 0.0),
    np.heaviside: lambda x, middle: _jump(x, 0.0, middle.low),
    np.floor: lambda x: Interval(np.floor(x.low), np.floor(x.high)),
    np.ceil: lambda x: Interval(np.ceil(x.low), np.ceil(x.high)),
    np.less: _less,
    np.less_equal: _less_or_equal,
    np.equal: _equal,
    np.logical_and: lambda x, y: -_largest(-x, -y),
    np.logical_or: _largest,
    np.logical_not: lambda x: Interval(1.0 - x.high, 1.0 - x.low),
    np.arctan2: _angle,
    np.maximum: _largest,
    np.minimum: lambda x, y: -_largest(-x, -y),
    np.exp: _ascending(np.exp, 0.0),
    np.sinh: _ascending(np.sinh),
    np.tanh: _ascending(np.tanh, -1.0, 1.0),
    np.arctan: _ascending(np.arctan),
    np.arcsinh: _ascending(np.arcsinh),
    np.arcsin: lambda x: _ascending(np.arcsin)(x.within(-1.0, 1.0)),
    np.arccos: lambda x: -_ascending(lambda y: -np.arccos(y))(x.within(-1.0, 1.0)),
    np.arccosh: lambda x: _ascending(np.arccosh, 0.0)(x.within(1.0, np.inf)),
    np.arctanh: lambda x: _ascending(np.arctanh)(x.within(-1.0, 1.0)),
    np.cosh: _cosh,
    np.sqrt: _where_defined(np.sqrt, 0.0),
    np.log: _where_defined(np.log),
    np.sin: _sine,
    np.cos: lambda x: _sine(x, np.pi / 2),
    np.tan: _tangent,
}
