"""Exponential and hyperbolic functions, logarithms, inverse hyperbolic functions, and powers.

For the exponential x = k log 2 + r with |r| <= log(2)/2, and exp(x) = 2^k exp(r).  The first terms of the
series of exp(r) - 1 are summed as a pair, so that rounding in the others, which are small beside them, does
not matter.

For the logarithm x = 2^k m with m between sqrt(1/2) and sqrt(2), and log m = 2 artanh(s) =
2 (s + s^3/3 + ...) with s = (m - 1)/(m + 1).  The sum is a pair of some 60 bits; for a power
x^y = exp(y log x) the logarithm needs 70.
"""

from __future__ import annotations

import math

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.tape.elementary.double_double import (
    exponent_and_fraction,
    pair_product,
    pair_quotient,
    pair_root,
    pair_sum,
    power_of_two,
    quick_two_sum,
    round_to_integer,
    scale,
    two_product,
    two_sum,
)

LOG2_E = 1.4426950408889634
LN2_HIGH, LN2_LOW = 0.6931471805598903, 5.497923018708371e-14  # the first has 42 bits: k LN2_HIGH is exact
LARGEST_EXPONENT, LEAST_EXPONENT = 711.0, -748.0  # beyond: exp, half and four times it are infinite or zero
EXPM1_SATURATION = -38.0  # below, exp(x) is less than half an ulp of 1
ONE_EXPONENTIAL = 20.0  # above, exp(-x) is less than half an ulp of exp(x)
ONE_OVERFLOWS = 64  # from this k on, 2^-k is below rounding beside 1


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
    """2^shift exp(x + x_low), for a shift of -1 to 2."""
    if not x <= LARGEST_EXPONENT:
        return x + math.inf  # NaN stays NaN
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


THIRD, THIRD_LOW = 0.3333333333333333, 1.850371707708594e-17
FIFTH, FIFTH_LOW = 0.2, -1.1102230246251566e-17
SQRT2 = 1.4142135623730951
LINEAR = 2.0**-28  # below, asinh and atanh are their argument up to rounding
LARGE = 1e9  # above, 1 is below rounding beside the square
ONE_VANISHES = 1e20  # above, log(1 + x) is log(x) up to rounding
EXPONENT_RANGE = 760.0  # beyond, exp is infinite or zero


@inlined
def artanh_series_tail(w):
    """1/7 + w/9 + w^2/11 + ... for w <= 0.0295."""
    v = w * w
    even = 1.0 / 7.0 + v * (1.0 / 11.0 + v * (1.0 / 15.0 + v * (1.0 / 19.0 + v * (1.0 / 23.0))))
    odd = 1.0 / 9.0 + v * (1.0 / 13.0 + v * (1.0 / 17.0 + v * (1.0 / 21.0 + v * (1.0 / 25.0))))
    return even + w * odd


@inlined
def reduced_argument(u, u_low):
    """s = u/(2 + u) as a pair."""
    two, two_low = pair_sum(2.0, 0.0, u, u_low)
    return pair_quotient(u, u_low, two, two_low)


@kernel
def reduced_logarithm(u, u_low):
    """log(1 + u) as a pair of 60 bits, for sqrt(1/2) <= 1 + u <= sqrt(2)."""
    s, s_low = reduced_argument(u, u_low)
    w = s * s
    p = THIRD + w * (FIFTH + w * artanh_series_tail(w))
    high, low = quick_two_sum(s, s_low + s * (w * p))
    return 2.0 * high, 2.0 * low


@kernel
def long_reduced_logarithm(u):
    """log(1 + u) of a number in the same range, as a pair of the 70 bits that powers need."""
    s, s_low = reduced_argument(u, 0.0)
    w, w_low = pair_product(s, s_low, s, s_low)
    p, p_low = pair_sum(FIFTH, FIFTH_LOW, w * artanh_series_tail(w), 0.0)
    p, p_low = pair_product(w, w_low, p, p_low)
    p, p_low = pair_sum(THIRD, THIRD_LOW, p, p_low)
    p, p_low = pair_product(w, w_low, p, p_low)
    p, p_low = pair_product(s, s_low, p, p_low)
    s, s_low = pair_sum(s, s_low, p, p_low)
    return 2.0 * s, 2.0 * s_low


@inlined
def with_exponent(k, high, low):
    """k log 2 + high + low as a pair."""
    total, rest = two_sum(k * LN2_HIGH, high)
    return quick_two_sum(total, rest + (low + k * LN2_LOW))


@inlined
def exponent_and_nearest_fraction(x):
    """k and m with x = 2^k m and sqrt(1/2) < m <= sqrt(2), for a finite x above zero."""
    k, m = exponent_and_fraction(x)
    return (k + 1, 0.5 * m) if m > SQRT2 else (k, m)


@kernel
def logarithm_pair(x):
    """log(x) as a pair of 60 bits, for a finite x above zero."""
    k, m = exponent_and_nearest_fraction(x)
    high, low = reduced_logarithm(m - 1.0, 0.0)
    return with_exponent(k, high, low)


@kernel
def logarithm_of_one_more(u, u_low):
    """log(1 + u) as a number, for a finite pair u above -1."""
    if u > ONE_VANISHES:
        return logarithm_pair(u)[0]
    one, one_low = pair_sum(1.0, 0.0, u, u_low)
    k, _ = exponent_and_nearest_fraction(one)
    if k != 0:
        u, u_low = two_sum(one * power_of_two(-k) - 1.0, one_low * power_of_two(-k))
    high, low = reduced_logarithm(u, u_low)
    return with_exponent(k, high, low)[0]


@kernel
def log(x):
    """Natural logarithm; -inf at zero, NaN below."""
    x = float(x)
    if not 0.0 < x < math.inf:
        if x == 0.0:
            return -math.inf
        return x if x > 0.0 else math.nan
    return logarithm_pair(x)[0]


@kernel
def log1p(x):
    """log(1 + x), with all digits where x is small."""
    x = float(x)
    if not -1.0 < x < math.inf:
        if x == -1.0:
            return -math.inf
        return x if x > 0.0 else math.nan
    return logarithm_of_one_more(x, 0.0) if abs(x) > LINEAR * LINEAR else x


@kernel
def asinh(x):
    """log(x + sqrt(x^2 + 1))."""
    x = float(x)
    size = abs(x)
    if not LINEAR < size < math.inf:
        return x
    if size > LARGE:
        high, low = logarithm_pair(size)
        value = pair_sum(high, low, LN2_HIGH, LN2_LOW)[0]
    else:  # log(1 + x + x^2/(1 + sqrt(1 + x^2)))
        square, square_low = two_product(size, size)
        root, root_low = pair_sum(1.0, 0.0, square, square_low)
        root, root_low = pair_root(root, root_low)
        root, root_low = pair_sum(1.0, 0.0, root, root_low)
        more, more_low = pair_quotient(square, square_low, root, root_low)
        more, more_low = pair_sum(size, 0.0, more, more_low)
        value = logarithm_of_one_more(more, more_low)
    return -value if x < 0.0 else value


@kernel
def acosh(x):
    """log(x + sqrt(x^2 - 1)), not below zero; NaN for x below 1."""
    x = float(x)
    if not 1.0 <= x < math.inf:
        return x if x > 1.0 else math.nan
    if x > LARGE:
        high, low = logarithm_pair(x)
        return pair_sum(high, low, LN2_HIGH, LN2_LOW)[0]
    t = x - 1.0
    sum_, sum_low = two_sum(x, 1.0)
    square, square_low = pair_product(t, 0.0, sum_, sum_low)
    root, root_low = pair_root(square, square_low)
    root, root_low = pair_sum(t, 0.0, root, root_low)
    return logarithm_of_one_more(root, root_low)


@kernel
def atanh(x):
    """log((1 + x)/(1 - x))/2; infinite at 1 and -1, NaN beyond."""
    x = float(x)
    size = abs(x)
    if not LINEAR < size < 1.0:
        if size == 1.0:
            return x * math.inf
        return x if size < 1.0 else math.nan
    rest, rest_low = two_sum(1.0, -size)
    ratio, ratio_low = pair_quotient(2.0 * size, 0.0, rest, rest_low)
    value = 0.5 * logarithm_of_one_more(ratio, ratio_low)
    return -value if x < 0.0 else value


@kernel
def power(x, y):
    """x^y; 1 for y = 0, otherwise NaN for x below zero."""
    x, y = float(x), float(y)
    if y == 0.0 or x == 1.0:
        return 1.0
    if not x > 0.0 or x == math.inf or abs(y) == math.inf or y != y:
        return power_at_limits(x, y)
    k, m = exponent_and_nearest_fraction(x)
    high, low = long_reduced_logarithm(m - 1.0)
    high, low = with_exponent(k, high, low)
    rough = y * high
    if not abs(rough) < EXPONENT_RANGE:
        return math.inf if rough > 0.0 else 0.0
    total, rest = two_product(y, high)
    total, rest = quick_two_sum(total, rest + y * low)
    return scaled_exponential(total, rest, 0)


@inlined
def power_at_limits(x, y):
    """x^y where x is zero, infinite or below zero, or y infinite."""
    if x != x or y != y or x < 0.0:
        return math.nan
    if x == 0.0 or x == math.inf:
        return math.inf if (x == 0.0) == (y < 0.0) else 0.0
    return math.inf if (x > 1.0) == (y > 0.0) else 0.0
