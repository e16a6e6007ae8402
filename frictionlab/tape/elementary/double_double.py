"""Arithmetic with twice the digits of a number, and the bits of numbers.

A pair is an unevaluated sum, high + low, with twice the digits of one number; |low| is at most half an ulp of
high.  Operations on pairs have relative errors below 2^-100; the sum or product of two single numbers as a
pair is exact.  None uses a fused multiply-add: if a compiler put one in, bits would differ.  The bits of a
number are read as an integer, and written from one, which gives powers of two.
"""

from __future__ import annotations

import math
import struct
from typing import Any

from frictionlab.compilation.decorators import inlined
from frictionlab.compilation.machine_code import NUMBA

EXPONENT_BIAS = 1023
FRACTION_BITS = 52
FRACTION_MASK = (1 << FRACTION_BITS) - 1
BITS_OF_ONE = EXPONENT_BIAS << FRACTION_BITS
SMALLEST_NORMAL = 2.2250738585072014e-308
TWO54 = 18014398509481984.0  # makes subnormal numbers normal
ROUND_TO_INTEGER = 6755399441055744.0  # 1.5 2^52: added and taken away, it rounds to integers below 2^51


def _plain_float_to_bits(x):
    return struct.unpack("<q", struct.pack("<d", x))[0]


def _plain_bits_to_float(bits):
    return struct.unpack("<d", struct.pack("<q", bits))[0]


def _intrinsics() -> tuple[Any, Any]:
    from llvmlite import ir
    from numba import types
    from numba.extending import intrinsic

    @intrinsic
    def float_to_bits(typing_context, x):
        """The bits of a number, as an integer."""

        def code(context, builder, signature, arguments):
            return builder.bitcast(arguments[0], ir.IntType(64))

        return types.int64(types.float64), code

    @intrinsic
    def bits_to_float(typing_context, bits):
        """The number with these bits."""

        def code(context, builder, signature, arguments):
            return builder.bitcast(arguments[0], ir.DoubleType())

        return types.float64(types.int64), code

    return float_to_bits, bits_to_float


float_to_bits, bits_to_float = (
    (_plain_float_to_bits, _plain_bits_to_float) if NUMBA is None else _intrinsics()
)


@inlined
def round_to_integer(x):
    """The integer nearest to a number below 2^51, as a float; the even one of two that are equally near."""
    return (x + ROUND_TO_INTEGER) - ROUND_TO_INTEGER


@inlined
def power_of_two(k):
    """2^k, where this is a normal number."""
    return bits_to_float((k + EXPONENT_BIAS) << FRACTION_BITS)


@inlined
def scale(x, k):
    """x 2^k, rounded once, for any x from 2^-1 to 2 and k from -1080 to 1025."""
    half = k >> 1
    return (x * power_of_two(half)) * power_of_two(k - half)


@inlined
def exponent_and_fraction(x):
    """k and m with x = m 2^k and 1 <= m < 2, for a finite number above zero."""
    shift = 0
    if x < SMALLEST_NORMAL:
        x *= TWO54
        shift = -54
    bits = float_to_bits(x)
    k = (bits >> FRACTION_BITS) - EXPONENT_BIAS + shift
    return k, bits_to_float((bits & FRACTION_MASK) | BITS_OF_ONE)


SPLITTER = 134217729.0  # 2^27 + 1: cuts a number into halves of 26 bits


@inlined
def two_sum(a, b):
    """a + b as a pair."""
    high = a + b
    part = high - a
    return high, (a - (high - part)) + (b - part)


@inlined
def quick_two_sum(a, b):
    """a + b as a pair, where a is zero or |a| >= |b|."""
    high = a + b
    return high, b - (high - a)


@inlined
def two_product(a, b):
    """a b as a pair, for factors below 2^996."""
    product = a * b
    wide = SPLITTER * a
    a_high = wide - (wide - a)
    a_low = a - a_high
    wide = SPLITTER * b
    b_high = wide - (wide - b)
    b_low = b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@inlined
def pair_sum(a, a_low, b, b_low):
    """Sum of two pairs."""
    high, low = two_sum(a, b)
    return quick_two_sum(high, low + (a_low + b_low))


@inlined
def pair_product(a, a_low, b, b_low):
    """Product of two pairs."""
    high, low = two_product(a, b)
    return quick_two_sum(high, low + (a * b_low + a_low * b))


@inlined
def pair_quotient(a, a_low, b, b_low):
    """Quotient of two pairs."""
    quotient = a / b
    high, low = two_product(quotient, b)
    rest = ((a - high) - low) + (a_low - quotient * b_low)
    return quick_two_sum(quotient, rest / b)


@inlined
def pair_root(a, a_low):
    """Square root of a pair that is zero or positive."""
    root = math.sqrt(a)
    if root == 0.0:
        return 0.0, 0.0
    high, low = two_product(root, root)
    rest = ((a - high) - low) + a_low
    return quick_two_sum(root, rest / (2.0 * root))
