"""Exponential and hyperbolic functions.

x = k log 2 + r with |r| <= log(2)/2, and exp(x) = 2^k exp(r).  The first terms of the series of exp(r) - 1
are summed as a pair, so that rounding in the others, which are small beside them, does not matter.
"""

from __future__ import annotations

import math

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.elementary.double_double import (
    pair_product,
    pair_quotient,
    pair_sum,
    quick_two_sum,
    two_product,
    two_sum,
)
from frictionlab.hybrid.elementary.float_bits import power_of_two, round_to_integer, scale

LOG2_E = 1.4426950408889634
LN2_HIGH, LN2_LOW = 0.6931471805598903, 5.497923018708371e-14  # the first has 42 bits: k LN2_HIGH is exact
LARGEST_EXPONENT, LEAST_EXPONENT = 711.0, -748.0  # beyond, exp is infinite, zero, a quarter or four of it too
EXPM1_SATURATION = -38.0  # below, exp(x) is less than half an ulp of 1
ONE_EXPONENTIAL = 20.0  # above, exp(-x) is less than half an ulp of exp(x)
ONE_OVERFLOWS = 64  # 2^-k is nothing beside 1 for larger k


@inlined
def exponential_series_tail(r):
    """(exp(r) - 1 - r - r^2/2)/r^3, for |r| <= log(2)/2."""
    w = r * r
    even = 1.0 / 39916800.0 + w * (1.0 / 6227020800.0)
    even = 1.0 / 120.0 + w * (1.0 / 5040.0 + w * (1.0 / 362880.0 + w * even))
    odd = 1.0 / 3628800.0 + w * (1.0 / 479001600.0 + w * (1.0 / 87178291200.0))
    odd = 1.0 / 24.0 + w * (1.0 / 720.0 + w * (1.0 / 40320.0 + w * odd))
    return 1.0 / 6.0 + (w * even + r * odd)


@kernel
def reduced_exponential(x, x_low):
    """k, high, low with exp(x + x_low) = 2^k (1 + high + low), for |x| below 1000."""
    k = round_to_integer(x * LOG2_E)
    r, r_low = two_sum(x - k * LN2_HIGH, x_low - k * LN2_LOW)
    square, rest = two_product(r, r)
    high, low = quick_two_sum(r, 0.5 * square)
    low += (r_low + (0.5 * rest + r * r_low)) + r * square * exponential_series_tail(r)
    high, low = quick_two_sum(high, low)
    return int(k), high, low


@kernel
def scaled_exponential(x, x_low, shift):
    """2^shift exp(x + x_low), for a shift of -2 to 2."""
    if not x <= LARGEST_EXPONENT:
        return x + math.inf  # what is no number stays so
    if x < LEAST_EXPONENT:
        return 0.0
    k, high, low = reduced_exponential(x, x_low)
    one, rest = quick_two_sum(1.0, high)
    return scale(one + (rest + low), k + shift)


@kernel
def exp(x):
    """e^x."""
    return scaled_exponential(float(x), 0.0, 0)


@kernel
def expm1(x):
    """e^x - 1, with all digits where x is small."""
    x = float(x)
    if not x <= LARGEST_EXPONENT:
        return x + math.inf
    if x < EXPM1_SATURATION:
        return -1.0
    if x == 0.0:
        return x
    k, high, low = reduced_exponential(x, 0.0)
    if k == 0:
        return high + low
    total, more = two_sum(1.0, -power_of_two(-k) if k < ONE_OVERFLOWS else 0.0)
    total, rest = two_sum(total, high)
    return scale(total + (rest + (more + low)), k)


@inlined
def exponential_less_one(x):
    """e^x - 1 as a pair, for 0 <= x <= 2 ONE_EXPONENTIAL."""
    k, high, low = reduced_exponential(x, 0.0)
    size = power_of_two(k)
    return pair_sum(size - 1.0, 0.0, size * high, size * low)


@inlined
def inverse_pair(a, a_low):
    """1/a."""
    return pair_quotient(1.0, 0.0, a, a_low)


@kernel
def sinh(x):
    """(e^x - e^-x)/2."""
    x = float(x)
    size = abs(x)
    if not 0.0 < size < math.inf:
        return x
    if size > ONE_EXPONENTIAL:
        value = scaled_exponential(size, 0.0, -1)
    else:  # (m + m/(1 + m))/2 with m = e^x - 1
        m, m_low = exponential_less_one(size)
        e, e_low = pair_sum(1.0, 0.0, m, m_low)
        other, other_low = pair_quotient(m, m_low, e, e_low)
        value = 0.5 * pair_sum(m, m_low, other, other_low)[0]
    return -value if x < 0.0 else value


@inlined
def twice_hyperbolic_cosine(size):
    """e^x + e^-x as a pair, for 0 <= x <= ONE_EXPONENTIAL."""
    m, m_low = exponential_less_one(size)
    e, e_low = pair_sum(1.0, 0.0, m, m_low)
    other, other_low = inverse_pair(e, e_low)
    return pair_sum(e, e_low, other, other_low)


@kernel
def cosh(x):
    """(e^x + e^-x)/2."""
    size = abs(float(x))
    if not size <= ONE_EXPONENTIAL:
        return scaled_exponential(size, 0.0, -1)
    return 0.5 * twice_hyperbolic_cosine(size)[0]


@kernel
def tanh(x):
    """sinh(x)/cosh(x)."""
    x = float(x)
    size = abs(x)
    if not size > 0.0:
        return x
    if size > ONE_EXPONENTIAL:
        value = 1.0
    else:  # m/(2 + m) with m = e^2x - 1
        m, m_low = exponential_less_one(2.0 * size)
        total, total_low = pair_sum(2.0, 0.0, m, m_low)
        value = pair_quotient(m, m_low, total, total_low)[0]
    return -value if x < 0.0 else value


@kernel
def sech2(x):
    """1/cosh(x)^2, the derivative of tanh."""
    size = abs(float(x))
    if not size <= ONE_EXPONENTIAL:
        return scaled_exponential(-2.0 * size, 0.0, 2)
    twice, twice_low = twice_hyperbolic_cosine(size)
    square, square_low = pair_product(twice, twice_low, twice, twice_low)
    return pair_quotient(4.0, 0.0, square, square_low)[0]
