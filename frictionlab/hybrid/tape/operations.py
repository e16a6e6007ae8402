"""The operations of a tape by their numbers, which kernels, code generation and the builder of tapes share.

A function f(a) is an operation too: its numbers follow those here
(:mod:`frictionlab.hybrid.tape.functions`).
"""

from __future__ import annotations

AFFINE, PRODUCT, SQUARE, QUOTIENT, RATE, POWER = range(6)
FIRST_FUNCTION = 6  # the number of the first function; so an operation is a function where kind > POWER
NAMES_OF_OPERATIONS = ("affine", "product", "square", "quotient", "rate", "power")
