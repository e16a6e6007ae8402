"""Pairs of numbers: an unevaluated sum, high + low, with twice the digits of one number.

|low| is at most half an ulp of high.  Operations on pairs have relative errors below 2^-100, those on single
numbers none.  None uses a fused multiply-add: where a compiler put one in, bits would differ.
"""

from __future__ import annotations

import math

from frictionlab.hybrid.compilation import inlined

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
    """Square root of a pair that is not below zero."""
    root = math.sqrt(a)
    if root == 0.0:
        return 0.0, 0.0
    high, low = two_product(root, root)
    rest = ((a - high) - low) + a_low
    return quick_two_sum(root, rest / (2.0 * root))
