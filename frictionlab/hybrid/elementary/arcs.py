"""Inverse trigonometric functions.

atan(x) = atan(c) + atan((x - c)/(1 + c x)), where c is the multiple of 1/8 next to x, so that the last
argument is at most 1/16; above 1, atan(x) = pi/2 - atan(1/x).  The others are arctangents of pairs.
"""

from __future__ import annotations

import math

import numpy as np

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.elementary.double_double import (
    pair_product,
    pair_quotient,
    pair_root,
    pair_sum,
    quick_two_sum,
    two_product,
    two_sum,
)
from frictionlab.hybrid.elementary.float_bits import round_to_integer
from frictionlab.hybrid.elementary.trigonometry import HALF_PI, HALF_PI_LOW

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
    """Angle of the point (x, y) in the first quadrant, both pairs, of which one at least is not zero."""
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
    """Arcsine, between -pi/2 and pi/2; no number beyond 1 and -1."""
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
    """Arccosine, from 0 to pi; no number beyond 1 and -1."""
    x = float(x)
    if not -1.0 <= x <= 1.0:
        return math.nan
    near, near_low = two_sum(1.0, -x)
    far, far_low = two_sum(1.0, x)
    near, near_low = pair_root(near, near_low)
    far, far_low = pair_root(far, far_low)
    return 2.0 * arctangent_of_ratio(near, near_low, far, far_low)[0]
