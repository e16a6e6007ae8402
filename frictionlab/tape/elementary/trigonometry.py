"""Sine, cosine, tangent, and their inverses.

An angle is split into a number n of quarter turns and a rest r with |r| <= pi/4, a pair.  The rest of any
angle above pi/4 is computed from the digits of 2/pi that matter for it (Payne & Hanek 1983): earlier digits
give multiples of four quarter turns, later ones are below rounding even for the angle nearest to a multiple
of pi/2.

atan(x) = atan(c) + atan((x - c)/(1 + c x)), where c is the multiple of 1/8 nearest to x, so that the last
argument is at most 1/16; above 1, atan(x) = pi/2 - atan(1/x).  asin and acos are arctangents of ratios of
pairs.
"""

from __future__ import annotations

import math

import numpy as np

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
    two_product,
    two_sum,
)

QUARTER_PI = 0.7853981633974483
HALF_PI, HALF_PI_LOW = 1.5707963267948966, 6.123233995736766e-17
SIXTH, SIXTH_LOW = 0.16666666666666666, 9.25185853854297e-18

# 2/pi in digits of 24 bits, the first of weight 2^-24, after two zeros
DIGIT_BITS = 24
DIGITS_USED = 8
LEADING_ZEROS = 2
DIGITS_OF_TWO_OVER_PI = np.array(
    """
    0 0 10680707 7228996 1387004 2578385 16069853 12639074 9804092 4427841 16666979 11263675 12935607
    2387514 4345298 14681673 3074569 13734428 16653803 1880361 10960616 8533493 3062596 8710556 7349940
    6258241 3772886 3769171 3798172 8675211 12450088 3874808 9961438 366607 15675153 9132554 7151469 3571407
    2607881 12013382 4155038 6285869 7677882 13102053 15825725 473591 9065106 15363067 6271263 9264392 5636912
    """.split(),
    dtype=float,
)


@kernel
def quarter_turns(x):
    """n and the pair r with x = n pi/2 + r, |r| <= pi/4, for a finite x above pi/4; n is modulo four.

    With x = 2^k (m_0 + m_1 2^-24 + m_2 2^-48), x 2/pi is a sum over d of
    (m_0 t_d + m_1 t_(d-1) + m_2 t_(d-2)) 2^(k - 24 (d + 1)), in which t are the digits of 2/pi.  Terms of
    weight 4 and more are left out; integers are subtracted as terms are added, so that a pair holds all bits.
    """
    k, m = exponent_and_fraction(x)
    m *= power_of_two(DIGIT_BITS - 1)
    k -= DIGIT_BITS - 1
    first = float(int(m))
    part = (m - first) * power_of_two(DIGIT_BITS)
    second = float(int(part))
    third = (part - second) * power_of_two(DIGIT_BITS)
    start = max(0, (k - 2) // DIGIT_BITS)
    turns, high, low = 0.0, 0.0, 0.0
    for d in range(start, start + DIGITS_USED):
        at = d + LEADING_ZEROS
        term = first * float(DIGITS_OF_TWO_OVER_PI[at])
        term += second * float(DIGITS_OF_TWO_OVER_PI[at - 1])
        term += third * float(DIGITS_OF_TWO_OVER_PI[at - 2])
        high, low = pair_sum(high, low, term * power_of_two(k - DIGIT_BITS * (d + 1)), 0.0)
        whole = round_to_integer(high)
        turns += whole
        high, low = quick_two_sum(high - whole, low)
    r, r_low = pair_product(high, low, HALF_PI, HALF_PI_LOW)
    return int(turns) & 3, r, r_low


@inlined
def sine_pair(r, r_low):
    """sin(r) as a pair, for |r| <= pi/4."""
    w, w_low = two_product(r, r)
    w_low += 2.0 * r * r_low
    cube, cube_low = pair_product(r, r_low, w, w_low)
    cube, cube_low = pair_product(cube, cube_low, SIXTH, SIXTH_LOW)
    tail = 1.0 / 6227020800.0 + w * (
        -1.0 / 1307674368000.0 + w * (1.0 / 355687428096000.0 + w * (-1.0 / 121645100408832000.0))
    )
    tail = 1.0 / 120.0 + w * (-1.0 / 5040.0 + w * (1.0 / 362880.0 + w * (-1.0 / 39916800.0 + w * tail)))
    high, low = quick_two_sum(r, -cube)
    return quick_two_sum(high, low + ((r_low - cube_low) + r * (w * w) * tail))


@inlined
def cosine_pair(r, r_low):
    """cos(r) as a pair, for |r| <= pi/4."""
    w, w_low = two_product(r, r)
    w_low += 2.0 * r * r_low
    tail = -1.0 / 87178291200.0 + w * (
        1.0 / 20922789888000.0 + w * (-1.0 / 6402373705728000.0 + w * (1.0 / 2432902008176640000.0))
    )
    tail = 1.0 / 24.0 + w * (
        -1.0 / 720.0 + w * (1.0 / 40320.0 + w * (-1.0 / 3628800.0 + w * (1.0 / 479001600.0 + w * tail)))
    )
    high, low = quick_two_sum(1.0, -0.5 * w)
    return quick_two_sum(high, low + (-0.5 * w_low + (w * w) * tail))


@inlined
def reduced_angle(size):
    """n and the pair r of an angle that is not below zero."""
    if size <= QUARTER_PI:
        return 0, size, 0.0
    return quarter_turns(size)


@kernel
def sin(x):
    """Sine; NaN for infinite angles."""
    x = float(x)
    size = abs(x)
    if not 0.0 < size < math.inf:
        return x if size == 0.0 else math.nan
    n, r, r_low = reduced_angle(size)
    high, _ = sine_pair(r, r_low) if n & 1 == 0 else cosine_pair(r, r_low)
    return -high if (n > 1) != (x < 0.0) else high


@kernel
def cos(x):
    """Cosine; NaN for infinite angles."""
    size = abs(float(x))
    if not size < math.inf:
        return math.nan
    n, r, r_low = reduced_angle(size)
    high, _ = cosine_pair(r, r_low) if n & 1 == 0 else sine_pair(r, r_low)
    return -high if n in (1, 2) else high


@kernel
def tan(x):
    """Tangent; NaN for infinite angles."""
    x = float(x)
    size = abs(x)
    if not 0.0 < size < math.inf:
        return x if size == 0.0 else math.nan
    n, r, r_low = reduced_angle(size)
    sine, sine_low = sine_pair(r, r_low)
    cosine, cosine_low = cosine_pair(r, r_low)
    if n & 1 == 0:
        value = pair_quotient(sine, sine_low, cosine, cosine_low)[0]
    else:
        value = -pair_quotient(cosine, cosine_low, sine, sine_low)[0]
    return -value if x < 0.0 else value


# atan(i/8) for i = 0 to 8, as pairs
ARCS = np.array(
    [
        (0.0, 0.0),
        (0.12435499454676144, -3.1253241424539383e-18),
        (0.24497866312686414, 1.0698755618734451e-17),
        (0.35877067027057225, -2.4623815582638635e-17),
        (0.4636476090008061, 2.2698777452961687e-17),
        (0.5585993153435624, -5.4556305485916264e-18),
        (0.6435011087932844, 1.5834785051444286e-17),
        (0.7188299996216245, -2.1478388444456983e-17),
        (0.7853981633974483, 3.061616997868383e-17),
    ]
)
INTERVALS = 8.0
SATURATION = 1e18  # above, atan is pi/2 up to rounding


@inlined
def arctangent_series(t, t_low):
    """atan(t) as a pair, for |t| <= 1/16."""
    w = t * t
    tail = -1.0 / 7.0 + w * (1.0 / 9.0 + w * (-1.0 / 11.0 + w * (1.0 / 13.0 + w * (-1.0 / 15.0))))
    tail = -1.0 / 3.0 + w * (1.0 / 5.0 + w * tail)
    return quick_two_sum(t, t_low + t * w * tail)


@kernel
def arctangent_up_to_one(x, x_low):
    """atan of a pair from 0 to 1, as a pair."""
    i = round_to_integer(INTERVALS * x)
    c = i / INTERVALS
    above, above_low = two_sum(x - c, x_low)
    below, below_low = two_product(c, x)
    below, below_low = pair_sum(1.0, 0.0, below, below_low + c * x_low)
    t, t_low = pair_quotient(above, above_low, below, below_low)
    t, t_low = arctangent_series(t, t_low)
    row = int(i)
    return pair_sum(float(ARCS[row, 0]), float(ARCS[row, 1]), t, t_low)


@inlined
def arctangent_of_ratio(y, y_low, x, x_low):
    """Angle of the point (x, y) in the first quadrant, both pairs, at least one of which is not zero."""
    if y <= x:
        t, t_low = pair_quotient(y, y_low, x, x_low)
        return arctangent_up_to_one(t, t_low)
    t, t_low = pair_quotient(x, x_low, y, y_low)
    t, t_low = arctangent_up_to_one(t, t_low)
    return pair_sum(HALF_PI, HALF_PI_LOW, -t, -t_low)


@kernel
def atan(x):
    """Arctangent, between -pi/2 and pi/2."""
    x = float(x)
    size = abs(x)
    if not size > 0.0:
        return x
    value = HALF_PI if size > SATURATION else arctangent_of_ratio(size, 0.0, 1.0, 0.0)[0]
    return -value if x < 0.0 else value


@kernel
def asin(x):
    """Arcsine, between -pi/2 and pi/2; NaN beyond 1 and -1."""
    x = float(x)
    size = abs(x)
    if not 0.0 < size <= 1.0:
        return x if size == 0.0 else math.nan
    near, near_low = two_sum(1.0, -size)
    far, far_low = two_sum(1.0, size)
    square, square_low = pair_product(near, near_low, far, far_low)
    root, root_low = pair_root(square, square_low)
    value = arctangent_of_ratio(size, 0.0, root, root_low)[0]
    return -value if x < 0.0 else value


@kernel
def acos(x):
    """Arccosine, from 0 to pi; NaN beyond 1 and -1."""
    x = float(x)
    if not -1.0 <= x <= 1.0:
        return math.nan
    near, near_low = two_sum(1.0, -x)
    far, far_low = two_sum(1.0, x)
    near, near_low = pair_root(near, near_low)
    far, far_low = pair_root(far, far_low)
    return 2.0 * arctangent_of_ratio(near, near_low, far, far_low)[0]
