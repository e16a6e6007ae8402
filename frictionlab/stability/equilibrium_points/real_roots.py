"""Real roots of polynomials, none missed and none invented; a root of a function between changes of sign.

Between two neighbouring real roots of its derivative a polynomial is monotonic, so it has a root there
exactly if its signs at the two ends differ.  The derivative's roots come from the same rule, down to the
constant.  Eigenvalues of a companion matrix would need a threshold on their imaginary parts instead.
A law evaluated at a `Polynomial` gives the coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Full relative precision however small the root: only ROOT_RTOL ends the search.
ROOT_XTOL, ROOT_RTOL, MAX_ROOT_STEPS = 1e-300, 8.9e-16, 5000

Array = NDArray[np.float64]

MAX_LOG_RATIO = 300.0  # natural logarithm of the ratio of coefficients that can count in one polynomial


def bracketed_root(function: Callable[[float], float], low: float, high: float) -> float | None:
    """A root in [low, high] if the function vanishes at an end or has different signs there, else None."""
    at_low, at_high = function(low), function(high)
    if at_low == 0.0 or at_high == 0.0:
        return low if at_low == 0.0 else high
    if np.sign(at_low) == np.sign(at_high):
        return None
    return _brent(function, (low, float(at_low)), (high, float(at_high)))


def _brent(
    function: Callable[[float], float], before: tuple[float, float], latest: tuple[float, float]
) -> float:
    """The root between two points (x, value) of different signs, by Brent's method.

    R. P. Brent, Algorithms for Minimization without Derivatives (1973), chapter 4.  It gives the results of
    scipy.optimize.brentq to the last bit; importing scipy.optimize takes longer than computing a run.
    """
    opposite = before  # of the other sign than `latest`
    step = step_before = 0.0
    for _ in range(MAX_ROOT_STEPS):
        if (before[1] < 0.0) != (latest[1] < 0.0):
            opposite = before
            step = step_before = latest[0] - before[0]
        if abs(opposite[1]) < abs(latest[1]):
            before, latest = latest, opposite
            opposite = before
        finest = (ROOT_XTOL + ROOT_RTOL * abs(latest[0])) / 2
        half = (opposite[0] - latest[0]) / 2
        if latest[1] == 0.0 or abs(half) < finest:
            break
        tried = _interpolated_step(before, latest, opposite) if abs(step_before) > finest else half
        if 2 * abs(tried) < min(abs(step_before), 3 * abs(half) - finest):
            step_before, step = step, tried
        else:
            step_before = step = half
        x = latest[0] + (step if abs(step) > finest else finest if half > 0 else -finest)
        before, latest = latest, (x, float(function(x)))
    return float(latest[0])


def _interpolated_step(
    before: tuple[float, float], latest: tuple[float, float], opposite: tuple[float, float]
) -> float:
    """A step by the secant, or by inverse quadratic interpolation; infinite where it does not reduce."""
    (x0, f0), (x1, f1), (x2, f2) = before, latest, opposite
    if abs(f1) >= abs(f0):
        return np.inf
    if x0 == x2:
        return -f1 * (x1 - x0) / (f1 - f0)
    slope0, slope2 = (f0 - f1) / (x0 - x1), (f2 - f1) / (x2 - x1)
    divisor = slope2 * slope0 * (f2 - f0)
    return -f1 * (f2 * slope2 - f0 * slope0) / divisor if divisor else np.inf


class Polynomial:
    """Coefficients (degree + 1, N), constant first; a column for each of N values of the parameters.

    It takes the place of a number in a law: sums, products, quotients by numbers, and integer powers are
    polynomials again.  Anything else raises TypeError, which shows that a law is no polynomial.
    """

    __array_ufunc__ = None  # makes numpy leave array * polynomial to this class

    def __init__(self, coefficients: Any) -> None:
        self.coefficients: Array = np.asarray(coefficients, dtype=float)

    def __add__(self, other: Any) -> Polynomial:
        mine, its = self.coefficients, _coefficients(other)
        longer, shorter = (mine, its) if len(mine) >= len(its) else (its, mine)
        count = max(mine.shape[1], its.shape[1])
        total = np.broadcast_to(longer, (len(longer), count)).copy()
        total[: len(shorter)] += shorter
        return Polynomial(total)

    def __mul__(self, other: Any) -> Polynomial:
        mine, its = self.coefficients, _coefficients(other)
        longer, shorter = (mine, its) if len(mine) >= len(its) else (its, mine)
        product = np.zeros((len(mine) + len(its) - 1, max(mine.shape[1], its.shape[1])))
        for k, row in enumerate(shorter):
            product[k : k + len(longer)] += row * longer
        return Polynomial(product)

    def __pow__(self, exponent: Any) -> Polynomial:
        if not isinstance(exponent, int) or exponent < 1:
            raise TypeError(f"a polynomial to the power of {exponent!r} is no polynomial")
        return self if exponent == 1 else self * self ** (exponent - 1)

    def __truediv__(self, other: Any) -> Polynomial:
        return Polynomial(self.coefficients / _constant_coefficients(other))

    def __neg__(self) -> Polynomial:
        return Polynomial(-self.coefficients)

    def __sub__(self, other: Any) -> Polynomial:
        return self + -other

    def __rsub__(self, other: Any) -> Polynomial:
        return -self + other

    __radd__, __rmul__ = __add__, __mul__


UNKNOWN = Polynomial([[0.0], [1.0]])


def _coefficients(other: Any) -> Array:
    return other.coefficients if isinstance(other, Polynomial) else _constant_coefficients(other)


def _constant_coefficients(number: Any) -> Array:
    if not isinstance(number, (Real, np.ndarray)):
        raise TypeError(f"{number!r} is no number")
    return np.atleast_1d(np.asarray(number, dtype=float))[None]


def real_roots(polynomial: Any) -> list[float]:
    """Real roots in ascending order, each once.

    Parameters
    ----------
    polynomial : array_like (degree + 1,)
        The coefficients, constant first.

    Raises
    ------
    ValueError
        If the polynomial is identically zero.
    """
    coefficients = np.asarray(polynomial, dtype=float)
    if not coefficients.any():
        raise ValueError("every number is a root of the zero polynomial")
    scaled, scale = _rescale(coefficients)
    return [scale * root for root in _real_roots(scaled.tolist())]


def _rescale(coefficients: Array) -> tuple[Array, float]:
    """Coefficients in x/scale with the largest 1, and no root beyond 2 (Fujiwara's bound)."""
    (degrees,) = np.nonzero(coefficients)
    logs = np.log(np.abs(coefficients[degrees]))
    gaps = degrees[-1] - degrees[:-1]
    log_scale = float(np.max((logs[:-1] - logs[-1]) / gaps)) if len(gaps) else 0.0
    # By logarithms, because powers of the scale may leave the range of floats where coefficients are tiny.
    logs += degrees * log_scale
    if np.ptp(logs) > MAX_LOG_RATIO:  # a leading coefficient as good as zero, whose root lies at infinity
        return _rescale(coefficients[: degrees[-1]])
    scaled = np.zeros(degrees[-1] + 1)
    scaled[degrees] = np.sign(coefficients[degrees]) * np.exp(logs - logs.max())
    return np.trim_zeros(scaled, "b"), float(np.exp(log_scale))


def _real_roots(coefficients: list[float]) -> list[float]:
    """Real roots of the polynomial with these coefficients, constant first, the last not zero."""
    if len(coefficients) < 2:
        return []
    if coefficients[0] == 0.0:
        return sorted({0.0, *_real_roots(coefficients[1:])})
    bound = 1.0 + max(abs(c / coefficients[-1]) for c in coefficients[:-1])
    slope = [k * c for k, c in enumerate(coefficients)][1:]
    ends = [-bound, *(c for c in _real_roots(slope) if -bound < c < bound), bound]
    roots = (bracketed_root(partial(_value, coefficients[::-1]), low, high) for low, high in pairwise(ends))
    return sorted({root for root in roots if root is not None})


def _value(descending: list[float], x: float) -> float:
    # Horner's rule in plain floats: numpy's call takes ten times as long for ten coefficients.
    total = 0.0
    for coefficient in descending:
        total = total * x + coefficient
    return total
