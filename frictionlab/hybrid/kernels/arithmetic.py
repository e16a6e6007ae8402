"""Operations that Python does not have: calls by address, sums in vectors, quick logarithms.

Intrinsics of numba, for use in a @kernel; without numba they are plain arithmetic with the same bits.
"""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np

from frictionlab.compilation import llvm_instructions
from frictionlab.compilation.llvm_instructions import (
    EXP2_COEFFICIENTS,
    EXPONENT_LIMIT,
    LOG2_COEFFICIENTS,
    MANTISSA_BITS,
    write_loop,
)
from frictionlab.compilation.machine_code import NUMBA
from frictionlab.tape.elementary.double_double import (
    BITS_OF_ONE,
    EXPONENT_BIAS,
    FRACTION_BITS,
    ROUND_TO_INTEGER,
    bits_to_float,
    float_to_bits,
)
from frictionlab.tape.panels import ROWS

SIGN_AND_EXPONENT_MASK = 0xFFF
PARTS = 4  # partial sums of a convolution or a series, independent of each other
COLUMNS = 8  # Bernstein coefficients that are computed at once


def _plain_sum(J, slot, groups, last, s):
    four = (s * s) * (s * s)
    sums = [last] + [0.0] * (PARTS - 1)
    for g in range(groups - 1, -1, -1):
        for part in range(PARTS):
            sums[part] = sums[part] * four + J[slot, PARTS * g + 1 + part]
    a, b, c, d = sums
    return (a + s * (b + s * (c + s * d))) * s


def _plain_sum_of_magnitudes(J, slot, groups, last, s):
    return _plain_sum(abs(J[slot : slot + 1]), 0, groups, last, s)


def _plain_change(matrix, shift, z, first, new):
    for i in range(first, first + PARTS):
        change = shift[i]
        for j in range(len(z)):
            change += matrix[j, i] * z[j]
        new[i] = z[i] + change


def _plain_states(J, first, order, s, z):
    groups = order // PARTS
    for i in range(first, first + PARTS):
        last = 0.0
        for k in range(order, PARTS * groups, -1):
            last = last * s + J[i, k]
        z[i] = J[i, 0] + _plain_sum(J, i, groups, last, s)


def _plain_panel(terms, slots, first, column, count, k, J, out, rows):
    for row in range(rows):
        total = 0.0
        for t in range(count):
            total += terms[first + ROWS * t + row] * J[slots[column + t], k]
        J[out + row, k] = total


def _plain_bernstein(a, n, monomials, first, b):
    for j in range(first, first + COLUMNS):
        total = a[0]
        for k in range(1, min(n, first + COLUMNS - 1) + 1):
            total += monomials[k, j] * a[k]
        b[j] = total


def _plain_correction(x, coefficients):
    total = coefficients[-1]
    for c in coefficients[-2::-1]:
        total = total * x + c
    return (x * (1.0 - x)) * total


def _plain_log2(x):
    bits = float_to_bits(x)
    exponent = float((bits >> FRACTION_BITS) & SIGN_AND_EXPONENT_MASK) - EXPONENT_BIAS
    part = bits_to_float((bits & MANTISSA_BITS) | BITS_OF_ONE) - 1.0
    return exponent + (part + _plain_correction(part, LOG2_COEFFICIENTS))


def _plain_step(log_tol, order, sizes, before, end):
    best = math.inf
    for p, size in ((order - 1, before), (order, end)):
        if size > 0.0:
            room = log_tol - _plain_log2(size)
            best = min(best, max((room + _plain_log2(each)) / (p - m) for m, each in enumerate(sizes)))
    return best


def _plain_exp2(x):
    x = float(x) if x > -EXPONENT_LIMIT else -EXPONENT_LIMIT
    x = x if x < EXPONENT_LIMIT else EXPONENT_LIMIT
    floor = ((x - 0.5) + ROUND_TO_INTEGER) - ROUND_TO_INTEGER
    part = x - floor
    value = (part + 1.0) + _plain_correction(part, EXP2_COEFFICIENTS)
    return bits_to_float(float_to_bits(value) + (int(floor) << FRACTION_BITS))


def _plain_call(address, *arguments):
    """Call a mode's native code from a kernel in plain Python, where others were compiled ahead of time."""
    arrays = [isinstance(each, np.ndarray) for each in arguments]
    kinds = [ctypes.c_void_p if array else ctypes.c_int64 for array in arrays]
    words = [each.ctypes.data if array else int(each) for each, array in zip(arguments, arrays)]
    ctypes.CFUNCTYPE(None, *kinds)(int(address))(*words)


def magnitudes(ir: Any, build: Any, values: Any) -> Any:
    """Absolute values of a vector of four."""
    kind, name = values.type, f"llvm.fabs.v{PARTS}f64"
    fabs = build.module.globals.get(name) or ir.Function(build.module, ir.FunctionType(kind, [kind]), name)
    return build.call(fabs, [values])


def sum_by_fours(ir: Any, build: Any, row: Any, groups: Any, last: Any, s: Any, of: Any) -> Any:
    """Instructions of :func:`sum_of_series`; `of` is applied to the coefficients, which begin at `row`."""
    kind, half = ir.VectorType(ir.DoubleType(), PARTS), ir.IntType(32)
    square = build.fmul(s, s)
    four = spread(ir, build, build.fmul(square, square))

    def group(i: Any, carried: list[Any]) -> list[Any]:
        from_end = build.shl(build.sub(build.sub(groups, i), groups.type(1)), groups.type(2))
        place = build.bitcast(build.gep(row, [from_end]), kind.as_pointer())
        return [build.fadd(build.fmul(carried[0], four), of(build.load(place, align=8)))]

    start = build.insert_element(ir.Constant(kind, [0.0] * PARTS), last, half(0))
    (sums,) = write_loop(build, groups, [start], group)
    total, *rest = (build.extract_element(sums, half(part)) for part in reversed(range(PARTS)))
    for each in rest:
        total = build.fadd(each, build.fmul(s, total))
    return build.fmul(total, s)


def change_of_four(ir: Any, build: Any, matrix: Any, shift: Any, z: Any, length: Any, first: Any) -> Any:
    """Instructions of :func:`add_change`, for arrays by the addresses of their data; returns the vector."""
    kind = ir.VectorType(ir.DoubleType(), PARTS)

    def four(place: Any) -> Any:
        return build.load(build.bitcast(build.gep(place, [first]), kind.as_pointer()), align=8)

    def add_row(j: Any, carried: list[Any]) -> list[Any]:
        row, factor = four(build.gep(matrix, [build.mul(j, length)])), build.load(build.gep(z, [j]))
        return [build.fadd(carried[0], build.fmul(row, spread(ir, build, factor)))]

    (change,) = write_loop(build, length, [four(shift)], add_row)
    return build.fadd(four(z), change)


def states_of_four(ir: Any, build: Any, rows: list[Any], order: Any, s: Any) -> Any:
    """Instructions of :func:`write_states`; returns the vector.  The first coefficients are at `rows`.

    Each row is summed as by :func:`sum_by_fours`.  The four sums of all rows are put together at the end,
    with the rows side by side.
    """
    kind, half, whole = ir.VectorType(ir.DoubleType(), PARTS), ir.IntType(32), order.type
    zero, shift = ir.Constant(kind, [0.0] * PARTS), whole(PARTS.bit_length() - 1)
    groups, spread_s = build.ashr(order, shift), spread(ir, build, s)
    square = build.fmul(s, s)
    four = spread(ir, build, build.fmul(square, square))

    def column(k: Any) -> Any:
        values = zero
        for lane, row in enumerate(rows):
            values = build.insert_element(values, build.load(build.gep(row, [k])), half(lane))
        return values

    def later(i: Any, carried: list[Any]) -> list[Any]:
        return [build.fadd(build.fmul(carried[0], spread_s), column(build.sub(order, i)))]

    (last,) = write_loop(build, build.and_(order, whole(PARTS - 1)), [zero], later)

    def group(i: Any, carried: list[Any]) -> list[Any]:
        before = build.shl(build.sub(build.sub(groups, i), whole(1)), shift)
        places = [build.gep(row, [build.add(before, whole(1))]) for row in rows]
        new = [build.load(build.bitcast(place, kind.as_pointer()), align=8) for place in places]
        return [build.fadd(build.fmul(sums, four), each) for sums, each in zip(carried, new, strict=True)]

    starts = [
        build.insert_element(zero, build.extract_element(last, half(lane)), half(0)) for lane in range(PARTS)
    ]
    by_row = write_loop(build, groups, starts, group)
    total, *rest = (_lane_of_each(ir, build, by_row, part) for part in reversed(range(PARTS)))
    for each in rest:
        total = build.fadd(each, build.fmul(spread_s, total))
    return build.fadd(column(whole(0)), build.fmul(total, spread_s))


def sums_of_panel(ir: Any, build: Any, entries: Any, slots: Any, count: Any, column: Any, length: Any) -> Any:
    """Instructions of :func:`write_panel`; returns the sums of all rows as vectors of four.

    `entries` and `slots` are the addresses of the panel's first, `column` of the coefficient of slot 0.
    """
    kind, whole = ir.VectorType(ir.DoubleType(), PARTS), count.type
    shift = whole(ROWS.bit_length() - 1)

    def add_column(t: Any, carried: list[Any]) -> list[Any]:
        slot = build.zext(build.load(build.gep(slots, [t])), whole)
        factor = spread(ir, build, build.load(build.gep(column, [build.mul(slot, length)])))
        place = build.gep(entries, [build.shl(t, shift)])
        totals = []
        for i, total in enumerate(carried):
            four = build.bitcast(build.gep(place, [whole(PARTS * i)]), kind.as_pointer())
            totals.append(build.fadd(total, build.fmul(build.load(four, align=8), factor)))
        return totals

    return write_loop(build, count, [ir.Constant(kind, [0.0] * PARTS)] * (ROWS // PARTS), add_column)


def bernstein_columns(ir: Any, build: Any, a: Any, n: Any, column: Any, length: Any, first: Any) -> list[Any]:
    """Instructions of :func:`write_bernstein`; returns the coefficients as vectors of four.

    `column` is the address of the table's column `first`, and `length` that of its rows.
    """
    kind, one = ir.VectorType(ir.DoubleType(), PARTS), n.type(1)
    highest = build.add(first, first.type(COLUMNS - 1))  # the rows below have zeros in these columns
    highest = build.select(build.icmp_signed("<", n, highest), n, highest)

    def add_row(i: Any, carried: list[Any]) -> list[Any]:
        k = build.add(i, one)
        factor = spread(ir, build, build.load(build.gep(a, [k])))
        row = build.gep(column, [build.mul(k, length)])
        places = (build.gep(row, [one.type(PARTS * part)]) for part in range(len(carried)))
        fours = [build.load(build.bitcast(place, kind.as_pointer()), align=8) for place in places]
        return [build.fadd(total, build.fmul(four, factor)) for total, four in zip(carried, fours)]

    start = spread(ir, build, build.load(a))
    return write_loop(build, highest, [start] * (COLUMNS // PARTS), add_row)


def _lane_of_each(ir: Any, build: Any, vectors: list[Any], lane: int) -> Any:
    """One lane of four vectors, as a vector."""
    two, four = (ir.VectorType(ir.IntType(32), n) for n in (2, PARTS))
    pairs = [
        build.shuffle_vector(a, b, ir.Constant(two, [lane, lane + PARTS]))
        for a, b in (vectors[:2], vectors[2:])
    ]
    return build.shuffle_vector(*pairs, ir.Constant(four, list(range(PARTS))))


def spread(ir: Any, build: Any, number: Any) -> Any:
    """A number as a vector of four."""
    vector = ir.Constant(ir.VectorType(ir.DoubleType(), PARTS), ir.Undefined)
    for lane in range(PARTS):
        vector = build.insert_element(vector, number, ir.IntType(32)(lane))
    return vector


def step_of_terms(ir: Any, build: Any, log_tol: Any, order: Any, sizes: list[Any], ends: list[Any]) -> Any:
    """Instructions of :func:`log2_step_of_terms`."""
    number, half = ir.DoubleType(), ir.IntType(32)

    def vector(values: list[Any]) -> Any:
        result = ir.Constant(ir.VectorType(number, len(values)), ir.Undefined)
        for i, value in enumerate(values):
            result = build.insert_element(result, value, half(i))
        return result

    def greater(a: Any, b: Any) -> Any:
        return build.select(build.fcmp_ordered(">", b, a), b, a)

    starts = llvm_instructions.write_log2(ir, build, vector([*sizes, sizes[-1]]))
    lasts = llvm_instructions.write_log2(ir, build, vector(ends))
    best = infinite = number(math.inf)
    for place, back in enumerate((1, 0)):
        room = build.fsub(log_tol, build.extract_element(lasts, half(place)))
        lower = ir.Constant(starts.type, [-float(back + m) for m in (0, 1, 2, 2)])
        powers = build.fadd(spread(ir, build, build.sitofp(order, number)), lower)
        steps = build.fdiv(build.fadd(spread(ir, build, room), starts), powers)
        each = [build.extract_element(steps, half(m)) for m in range(len(sizes))]
        longest = greater(each[0], greater(each[1], each[2]))
        moves = build.fcmp_ordered(">", ends[place], number(0.0))
        longest = build.select(moves, longest, infinite)
        best = build.select(build.fcmp_ordered("<", longest, best), longest, best)
    return best


def _intrinsics() -> tuple[Any, ...]:
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    def by_address(context, builder, signature, arguments):
        address, *others = arguments
        passed = [
            context.make_array(kind)(context, builder, each).data if isinstance(kind, types.Array) else each
            for kind, each in zip(signature.args[1:], others, strict=True)
        ]
        kind = ir.FunctionType(ir.VoidType(), [each.type for each in passed])
        builder.call(builder.inttoptr(address, kind.as_pointer()), passed)
        return context.get_dummy_value()

    @intrinsic
    def call(typing_context, address, z, constants, terms, J, order):
        """Call native(z, constants, terms, J, order) at an address, with pointers to the arrays' data."""
        return types.void(types.int64, z, constants, terms, J, types.int64), by_address

    @intrinsic
    def call_step(typing_context, address, z, constants, terms, J, control, part, order):
        """Call native(z, constants, terms, J, control, part, order) at an address, as :func:`call` does."""
        integers = types.int64, types.int64
        return types.void(types.int64, z, constants, terms, J, control, *integers), by_address

    def series(context, builder, signature, arguments, of):
        array, slot, groups, last, s = arguments
        rows = context.make_array(signature.args[0])(context, builder, array)
        length = builder.extract_value(rows.shape, 1)
        row = builder.gep(rows.data, [builder.add(builder.mul(slot, length), slot.type(1))])
        return sum_by_fours(ir, builder, row, groups, last, s, of)

    def plain_series(context, builder, signature, arguments):
        return series(context, builder, signature, arguments, lambda four: four)

    def series_of_magnitudes(context, builder, signature, arguments):
        return series(context, builder, signature, arguments, lambda four: magnitudes(ir, builder, four))

    def change(context, builder, signature, arguments):
        kinds = *signature.args[:3], signature.args[4]
        arrays = *arguments[:3], arguments[4]
        matrix, shift, z, new = (
            context.make_array(kind)(context, builder, array) for kind, array in zip(kinds, arrays)
        )
        length, first = builder.extract_value(z.shape, 0), arguments[3]
        four = change_of_four(ir, builder, matrix.data, shift.data, z.data, length, first)
        place = builder.bitcast(builder.gep(new.data, [first]), four.type.as_pointer())
        builder.store(four, place, align=8)
        return context.get_dummy_value()

    def states(context, builder, signature, arguments):
        (J, first, order, s, z), kinds = arguments, signature.args
        rows, new = context.make_array(kinds[0])(context, builder, J), context.make_array(kinds[4])
        length = builder.extract_value(rows.shape, 1)
        numbers = [builder.add(first, first.type(i)) for i in range(PARTS)]
        places = [builder.gep(rows.data, [builder.mul(i, length)]) for i in numbers]
        four = states_of_four(ir, builder, places, order, s)
        place = builder.gep(new(context, builder, z).data, [first])
        builder.store(four, builder.bitcast(place, four.type.as_pointer()), align=8)
        return context.get_dummy_value()

    def panel(context, builder, signature, arguments):
        (terms, slots, first, at, count, k, J, out, rows), kinds = arguments, signature.args
        entries, places, jets = (
            context.make_array(kind)(context, builder, array)
            for kind, array in ((kinds[0], terms), (kinds[1], slots), (kinds[6], J))
        )
        length, column = builder.extract_value(jets.shape, 1), builder.gep(jets.data, [k])
        sums = sums_of_panel(
            ir,
            builder,
            builder.gep(entries.data, [first]),
            builder.gep(places.data, [at]),
            count,
            column,
            length,
        )
        kept = cgutils.alloca_once(builder, ir.ArrayType(sums[0].type, len(sums)))
        numbers = builder.bitcast(kept, ir.DoubleType().as_pointer())
        for i, four in enumerate(sums):
            place = builder.gep(numbers, [first.type(PARTS * i)])
            builder.store(four, builder.bitcast(place, four.type.as_pointer()), align=8)

        def write_row(row, _):
            place = builder.mul(builder.add(out, row), length)
            builder.store(builder.load(builder.gep(numbers, [row])), builder.gep(column, [place]))
            return []

        write_loop(builder, rows, [], write_row)
        return context.get_dummy_value()

    def bernstein(context, builder, signature, arguments):
        (a, n, monomials, first, b), kinds = arguments, signature.args
        series, table, target = (
            context.make_array(kind)(context, builder, array)
            for kind, array in ((kinds[0], a), (kinds[2], monomials), (kinds[4], b))
        )
        length, column = builder.extract_value(table.shape, 1), builder.gep(table.data, [first])
        for i, four in enumerate(bernstein_columns(ir, builder, series.data, n, column, length, first)):
            place = builder.gep(target.data, [builder.add(first, first.type(PARTS * i))])
            builder.store(four, builder.bitcast(place, four.type.as_pointer()), align=8)
        return context.get_dummy_value()

    def step(context, builder, signature, arguments):
        log_tol, order, sizes, before, end = arguments
        numbers = [builder.extract_value(sizes, i) for i in range(len(signature.args[2]))]
        return step_of_terms(ir, builder, log_tol, order, numbers, [before, end])

    number, whole = types.float64, types.int64

    @intrinsic
    def log2_step_of_terms(typing_context, log_tol, order, sizes, before, end):
        """Logarithm of the longest step h with c_p h^p <= tol c_m h^m, for some m of 0, 1, 2 for both p.

        The last terms c_p, for p of `order` - 1 and `order`, are `before` and `end`; if both are zero, it is
        infinite.  Not all `sizes` c_m may be zero.
        """
        return number(number, whole, sizes, number, number), step

    @intrinsic
    def write_panel(typing_context, terms, slots, first, column, count, k, J, out, rows):
        """Write coefficient k of the first `rows` rows of a panel of a matrix into `J`, from slot `out` on.

        The panel has `count` columns, from number `column` on, and its entries begin with term `first`.  All
        sums are computed side by side, as vectors; the arrays must be contiguous.
        """
        return types.void(terms, slots, whole, whole, whole, whole, J, whole, whole), panel

    @intrinsic
    def write_bernstein(typing_context, a, n, monomials, first, b):
        """Write eight Bernstein coefficients of a polynomial into `b`, from b[first] on.

        The polynomial is the sum of a[k] x^k up to k = `n`; row k of the table `monomials` has the Bernstein
        coefficients of x^k.  All arrays must be contiguous.
        """
        return types.void(a, whole, monomials, whole, b), bernstein

    @intrinsic
    def write_states(typing_context, J, first, order, s, z):
        """Write sums of J[i, k] s^k, from k = 0 to `order`, into four elements z[i], from element `first` on.

        The terms from k = 1 on are summed first; `J` and `z` must be contiguous.
        """
        return types.void(J, whole, whole, number, z), states

    @intrinsic
    def add_change(typing_context, matrix, shift, z, first, new):
        """Write four elements of z + (shift + matrix^T z) into `new`, from element `first` on.

        The matrix is square, and all are contiguous.
        """
        return types.void(matrix, shift, z, whole, new), change

    @intrinsic
    def sum_of_series(typing_context, J, slot, groups, last, s):
        """Sum of J[slot, k] s^k from k = 1, over `groups` groups of four; `last` stands for the terms after.

        Four sums are computed side by side, as a vector; `J` must be contiguous.
        """
        return number(J, whole, whole, number, number), plain_series

    @intrinsic
    def sum_of_magnitudes(typing_context, J, slot, groups, last, s):
        """As :func:`sum_of_series`, with the absolute values of the coefficients."""
        return number(J, whole, whole, number, number), series_of_magnitudes

    def of_one_number(emit: Any) -> Any:
        @intrinsic
        def function(typing_context, x):
            def code(context, builder, signature, arguments):
                return emit(ir, builder, arguments[0])

            return types.float64(types.float64), code

        return function

    of_one = of_one_number(llvm_instructions.write_log2), of_one_number(llvm_instructions.write_exp2)
    sums = sum_of_series, sum_of_magnitudes, add_change, write_states, write_panel, write_bernstein
    return call, call_step, *sums, log2_step_of_terms, *of_one


_PLAIN_SUMS = (
    _plain_sum,
    _plain_sum_of_magnitudes,
    _plain_change,
    _plain_states,
    _plain_panel,
    _plain_bernstein,
)
_PLAIN = _plain_call, _plain_call, *_PLAIN_SUMS, _plain_step, _plain_log2, _plain_exp2
_MADE = _PLAIN if NUMBA is None else _intrinsics()
call_jets, call_lane_step, sum_of_series, sum_of_magnitudes, add_change = _MADE[:5]
write_states, write_panel, write_bernstein = _MADE[5:-3]
log2_step_of_terms, log2, exp2 = _MADE[-3:]
