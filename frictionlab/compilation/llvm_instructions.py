"""Operations written as LLVM instructions: arithmetic, places in arrays, loops, branches, quick logarithms.

A value is one number, or a vector with a number for each of several runs, which are the last axis of arrays.
Values that a loop changes are passed to its body and returned by it.  The quick logarithm and power of two
serve to choose the length of a step, for which six digits are plenty.  The kernels
(:mod:`frictionlab.hybrid.kernels.arithmetic`) and the code of lanes (:mod:`frictionlab.hybrid.codegen`)
contain the same instructions, so that both take the same steps to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

MANTISSA_BITS, BITS_OF_ONE, EXPONENT_BIAS = (1 << 52) - 1, 0x3FF << 52, 1023
BITS_OF_TWO52 = 0x433 << 52  # the bits of 2^52: a small integer put into its mantissa is added to it
# (log2(1 + x) - x) / (x (1 - x)) and (2^x - 1 - x) / (x (1 - x)) on [0, 1], fitted at Chebyshev points
LOG2_COEFFICIENTS = (
    0.4426594387743502,
    -0.2767283340874907,
    0.18486223229215762,
    -0.0983876164788712,
    0.026273050822950013,
)
EXP2_COEFFICIENTS = (-0.3068511498524207, -0.06667901296350223, -0.010864628584566875, -0.0018978154489040823)
EXPONENT_LIMIT = 1000.0

Values = list[Any]


def llvm_constant(ir: Any, kind: Any, value: float) -> Any:
    """A constant of a scalar type, or of a vector type with the value in every place."""
    return ir.Constant(kind, [value] * kind.count if hasattr(kind, "count") else value)


def write_log2(ir: Any, build: Any, x: Any) -> Any:
    """log2(x) within 1e-5 for positive normal numbers; -1023 at zero."""
    whole = _same_shape(ir, x.type, ir.IntType(64))
    bits = build.bitcast(x, whole)
    exponent = build.or_(
        build.lshr(bits, llvm_constant(ir, whole, 52)), llvm_constant(ir, whole, BITS_OF_TWO52)
    )
    exponent = build.fsub(build.bitcast(exponent, x.type), llvm_constant(ir, x.type, 2.0**52 + EXPONENT_BIAS))
    mantissa = build.or_(
        build.and_(bits, llvm_constant(ir, whole, MANTISSA_BITS)), llvm_constant(ir, whole, BITS_OF_ONE)
    )
    part = build.fsub(build.bitcast(mantissa, x.type), llvm_constant(ir, x.type, 1.0))
    return build.fadd(exponent, build.fadd(part, _write_correction(ir, build, part, LOG2_COEFFICIENTS)))


def write_exp2(ir: Any, build: Any, x: Any) -> Any:
    """2^x within 1e-6; x is limited to +-1000."""
    kind, whole = x.type, _same_shape(ir, x.type, ir.IntType(64))
    low, high = llvm_constant(ir, kind, -EXPONENT_LIMIT), llvm_constant(ir, kind, EXPONENT_LIMIT)
    x = build.select(build.fcmp_ordered(">", x, low), x, low)
    x = build.select(build.fcmp_ordered("<", x, high), x, high)
    # Adding 1.5 2^52 rounds to an integer, which is then in the last bits.
    shifted = build.fadd(build.fsub(x, llvm_constant(ir, kind, 0.5)), llvm_constant(ir, kind, 1.5 * 2.0**52))
    floor = build.fsub(shifted, llvm_constant(ir, kind, 1.5 * 2.0**52))
    part = build.fsub(x, floor)
    value = build.fadd(
        build.fadd(part, llvm_constant(ir, kind, 1.0)), _write_correction(ir, build, part, EXP2_COEFFICIENTS)
    )
    power = build.shl(build.bitcast(shifted, whole), llvm_constant(ir, whole, 52))
    return build.bitcast(build.add(build.bitcast(value, whole), power), kind)


def _write_correction(ir: Any, build: Any, x: Any, coefficients: tuple[float, ...]) -> Any:
    """x (1 - x) times a polynomial: the correction to a straight line that is exact at both ends."""
    total = llvm_constant(ir, x.type, coefficients[-1])
    for c in coefficients[-2::-1]:
        total = build.fadd(build.fmul(total, x), llvm_constant(ir, x.type, c))
    return build.fmul(build.fmul(x, build.fsub(llvm_constant(ir, x.type, 1.0), x)), total)


def _same_shape(ir: Any, kind: Any, element: Any) -> Any:
    return ir.VectorType(element, kind.count) if hasattr(kind, "count") else element


def write_loop(build: Any, count: Any, carried: Values, body: Callable[[Any, Values], Values]) -> Values:
    """Write `carried = body(i, carried)` for i from 0 to `count` - 1; returns `carried` at the end."""
    before, inside, after = _blocks(build)
    zero, one = count.type(0), count.type(1)
    build.cbranch(build.icmp_signed("<", zero, count), inside, after)
    build.position_at_end(inside)
    i = build.phi(count.type)
    i.add_incoming(zero, before)
    inner = [_phi(build, (value, before)) for value in carried]
    results = body(i, inner)
    end, following = build.block, build.add(i, one)
    for phi, result in zip([i, *inner], [following, *results], strict=True):
        phi.add_incoming(result, end)
    build.cbranch(build.icmp_signed("<", following, count), inside, after)
    build.position_at_end(after)
    return [_phi(build, (old, before), (new, end)) for old, new in zip(carried, results, strict=True)]


def write_while_loop(
    build: Any, goes_on: Any, carried: Values, body: Callable[[Values], tuple[Values, Any]]
) -> Values:
    """Write `carried, goes_on = body(carried)` while `goes_on`; returns `carried` at the end."""
    before, inside, after = _blocks(build)
    build.cbranch(goes_on, inside, after)
    build.position_at_end(inside)
    inner = [_phi(build, (value, before)) for value in carried]
    results, goes_on = body(inner)
    end = build.block
    for phi, result in zip(inner, results, strict=True):
        phi.add_incoming(result, end)
    build.cbranch(goes_on, inside, after)
    build.position_at_end(after)
    return [_phi(build, (old, before), (new, end)) for old, new in zip(carried, results, strict=True)]


def write_branch(build: Any, condition: Any, yes: Callable[[], Values], no: Callable[[], Values]) -> Values:
    """Write `yes() if condition else no()`; only the branch taken is computed."""
    inside, other, after = (build.append_basic_block() for _ in range(3))
    build.cbranch(condition, inside, other)
    incoming = []
    for block, values in (inside, yes), (other, no):
        build.position_at_end(block)
        incoming.append([(value, build.block) for value in values()])
        build.branch(after)
    build.position_at_end(after)
    return [_phi(build, *pair) for pair in zip(*incoming, strict=True)]


def _blocks(build: Any) -> tuple[Any, Any, Any]:
    return build.block, build.append_basic_block(), build.append_basic_block()


def _phi(build: Any, *incoming: tuple[Any, Any]) -> Any:
    phi = build.phi(incoming[0][0].type)
    for value, block in incoming:
        phi.add_incoming(value, block)
    return phi


class Instructions:
    """Instructions on values; `row` is the length of a row of J, in values."""

    width = 1  # numbers in a value

    def __init__(self, ir: Any, build: Any, row: int) -> None:
        self.ir, self.build, self.row, self.whole = ir, build, row, ir.IntType(64)
        self.kind = ir.VectorType(ir.DoubleType(), self.width) if self.width > 1 else ir.DoubleType()
        self.called: dict[str, Any] = {}

    def _abs(self, a: Any) -> Any:
        return self._intrinsic("fabs", a)

    def _multiply_add(self, a: Any, b: Any, c: Any) -> Any:
        """a b + c, rounded twice: not every processor can round it only once."""
        return self.build.fadd(self.build.fmul(a, b), c)

    def _intrinsic(self, name: str, *arguments: Any) -> Any:
        """An LLVM intrinsic, of numbers or of vectors."""
        kind = arguments[0].type
        vector = f"v{kind.count}" if hasattr(kind, "count") else ""
        return self._called(f"llvm.{name}.{vector}f64", kind, *arguments)

    def _call(self, name: str, *arguments: Any) -> Any:
        return self._called(name, self.ir.DoubleType(), *arguments)

    def _called(self, name: str, kind: Any, *arguments: Any) -> Any:
        if name not in self.called:
            signature = self.ir.FunctionType(kind, [argument.type for argument in arguments])
            self.called[name] = self.ir.Function(self.build.module, signature, name)
        return self.build.call(self.called[name], arguments)

    def _at(self, slot: int, column: Any) -> Any:
        return self._load(column, slot * self.row)

    def _place(self, slot: int, column: Any) -> Any:
        return self._ahead(column, self.whole(slot * self.row))

    def _ahead(self, place: Any, count: Any) -> Any:
        """The address `count` values further on."""
        numbers = count if self.width == 1 else self.build.mul(count, self.whole(self.width))
        return self.build.gep(place, [numbers])

    def _load(self, array: Any, i: int) -> Any:
        return self._vector(array, i, self.kind)

    def _store(self, value: Any, array: Any, i: int) -> None:
        self.build.store(value, self._pointer(array, i, self.kind), align=8)

    def _vector(self, array: Any, i: int, kind: Any) -> Any:
        return self.build.load(self._pointer(array, i, kind), align=8)

    def _pointer(self, array: Any, i: int, kind: Any) -> Any:
        place = self.build.gep(array, [self.whole(i * self.width)])
        return self.build.bitcast(place, kind.as_pointer())

    def _spread(self, value: Any) -> Any:
        """A number as a value: in lanes, the same for all."""
        return value

    def _as_number(self, count: Any) -> Any:
        return self._spread(self.build.sitofp(count, self.ir.DoubleType()))

    def _number(self, value: float) -> Any:
        return llvm_constant(self.ir, self.kind, value)
