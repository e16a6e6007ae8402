"""The bits of a number as an integer, and the other way round; powers of two by their bits."""

from __future__ import annotations

import struct
from typing import Any

from frictionlab.hybrid.compilation import NUMBA, inlined

EXPONENT_BIAS = 1023
FRACTION_BITS = 52
FRACTION_MASK = (1 << FRACTION_BITS) - 1
BITS_OF_ONE = EXPONENT_BIAS << FRACTION_BITS
SMALLEST_NORMAL = 2.2250738585072014e-308
TWO54 = 18014398509481984.0  # makes subnormal numbers normal
ROUNDING = 6755399441055744.0  # 1.5 2^52: added and taken away again, it rounds to an integer below 2^51


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
    """The integer next to a number below 2^51, as a number; of two the even one."""
    return (x + ROUNDING) - ROUNDING


@inlined
def power_of_two(k):
    """2^k for a normal number."""
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
