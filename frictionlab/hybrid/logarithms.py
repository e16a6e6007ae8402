"""Quick logarithm and power of two, as LLVM instructions for one number or a vector of them.

They serve the choice of a step's length, for which six digits are plenty.  The same instructions stand in the
kernels and in the code of lanes, so that both take the same steps to the last bit.
"""

from __future__ import annotations

from typing import Any

MANTISSA, ONE, BIAS = (1 << 52) - 1, 0x3FF << 52, 1023
TWO52 = 0x433 << 52  # the bits of 2^52: a small integer put into its mantissa is added to it
# (log2(1 + x) - x) / (x (1 - x)) and (2^x - 1 - x) / (x (1 - x)) on [0, 1], fitted at Chebyshev points
LOG = (
    0.4426594387743502,
    -0.2767283340874907,
    0.18486223229215762,
    -0.0983876164788712,
    0.026273050822950013,
)
EXP = (-0.3068511498524207, -0.06667901296350223, -0.010864628584566875, -0.0018978154489040823)
LARGEST = 1000.0


def number(ir: Any, kind: Any, value: float) -> Any:
    """A constant of a scalar type, or one in every place of a vector type."""
    return ir.Constant(kind, [value] * kind.count if hasattr(kind, "count") else value)


def log2(ir: Any, build: Any, x: Any) -> Any:
    """log2(x) within 1e-5 for positive normal numbers; -1023 at zero."""
    whole = _like(ir, x.type, ir.IntType(64))
    bits = build.bitcast(x, whole)
    exponent = build.or_(build.lshr(bits, number(ir, whole, 52)), number(ir, whole, TWO52))
    exponent = build.fsub(build.bitcast(exponent, x.type), number(ir, x.type, 2.0**52 + BIAS))
    mantissa = build.or_(build.and_(bits, number(ir, whole, MANTISSA)), number(ir, whole, ONE))
    part = build.fsub(build.bitcast(mantissa, x.type), number(ir, x.type, 1.0))
    return build.fadd(exponent, build.fadd(part, _bow(ir, build, part, LOG)))


def exp2(ir: Any, build: Any, x: Any) -> Any:
    """2^x within 1e-6, x cut to +-1000."""
    kind, whole = x.type, _like(ir, x.type, ir.IntType(64))
    low, high = number(ir, kind, -LARGEST), number(ir, kind, LARGEST)
    x = build.select(build.fcmp_ordered(">", x, low), x, low)
    x = build.select(build.fcmp_ordered("<", x, high), x, high)
    # Adding 1.5 2^52 rounds to an integer, which is then in the last bits.
    shifted = build.fadd(build.fsub(x, number(ir, kind, 0.5)), number(ir, kind, 1.5 * 2.0**52))
    floor = build.fsub(shifted, number(ir, kind, 1.5 * 2.0**52))
    part = build.fsub(x, floor)
    value = build.fadd(build.fadd(part, number(ir, kind, 1.0)), _bow(ir, build, part, EXP))
    power = build.shl(build.bitcast(shifted, whole), number(ir, whole, 52))
    return build.bitcast(build.add(build.bitcast(value, whole), power), kind)


def _bow(ir: Any, build: Any, x: Any, coefficients: tuple[float, ...]) -> Any:
    """x (1 - x) times a polynomial: what bends between two ends that are met exactly."""
    total = number(ir, x.type, coefficients[-1])
    for c in coefficients[-2::-1]:
        total = build.fadd(build.fmul(total, x), number(ir, x.type, c))
    return build.fmul(build.fmul(x, build.fsub(number(ir, x.type, 1.0), x)), total)


def _like(ir: Any, kind: Any, element: Any) -> Any:
    return ir.VectorType(element, kind.count) if hasattr(kind, "count") else element
