"""Machine code of a mode's jets: its operations in sequence, within a loop over the orders asked for.

It does the same operations in the same sequence as :func:`frictionlab.hybrid.kernels.jets.run_tape`, so its
results are those of the interpreter to the last bit, and a run may change from one to the other at any step.
If only the current coefficient of a slot is read, its row is not stored.  The values of the states' rates are
always stored.
`LaneWriter` writes the same for several runs side by side: every value has one number for each run (lane).

Functions and powers are computed by calls of their kernels, so that their code exists only once; a call takes
little time beside theirs.  The kernels' names are registered with LLVM when code that holds them is loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

from frictionlab.compilation.decorators import c_address
from frictionlab.compilation.llvm_instructions import (
    Instructions,
    Values,
    llvm_constant,
    write_branch,
    write_exp2,
    write_loop,
)
from frictionlab.hybrid.kernels.arithmetic import PARTS
from frictionlab.hybrid.kernels.jets import JET_COLUMNS, LOG2_LEAST_RATIO
from frictionlab.tape.elementary.exponentials import power
from frictionlab.tape.functions import (
    AFFINE,
    POWER,
    PRODUCT,
    QUOTIENT,
    RATE,
    SQUARE,
    function_range,
    function_value,
)
from frictionlab.tape.tape import Tape

VALUE_SYMBOL, RANGE_SYMBOL = "frictionlab_function_value", "frictionlab_function_range"
POWER_SYMBOL = "frictionlab_power"


class KernelSymbol(NamedTuple):
    """A kernel that native code calls, and the types of the call."""

    function: Callable[..., float]
    signature: str


def _value(kind, x):
    return function_value(kind, x)


def _range(kind, a, y, slope, d):
    return function_range(kind, a, y, slope, d)


def _power(x, y):
    return power(x, y)


KERNELS = {
    VALUE_SYMBOL: KernelSymbol(_value, "float64(int64, float64)"),
    RANGE_SYMBOL: KernelSymbol(_range, "float64(int64, float64, float64, float64, float64)"),
    POWER_SYMBOL: KernelSymbol(_power, "float64(float64, float64)"),
}


def register_used(code: bytes) -> None:
    """Register with LLVM the kernels whose names occur in machine code."""
    for name in KERNELS:
        if name.encode() in code:
            _registered(name)


@cache  # once per process
def _registered(name: str) -> None:
    import llvmlite.binding as llvm

    llvm.add_symbol(name, c_address(name, *KERNELS[name]))


LANE_COUNT = 4
# Rows of `control`, of LANE_COUNT numbers each; one row more for each guard has its number of leading zeros.
LEFT, LENGTH, REGULAR, MEASURED, SUITED, TOL, LOG_TOL, GUARD_TOL = range(8)
CONTROL_ROWS = 8


class ModeTape(NamedTuple):
    """The tape of one mode, from which its code is written."""

    tape: Tape
    first: tuple[int, int]  # where its operations, and its terms, begin among those of all tapes
    flow: tuple[int, ...]  # slot that holds each state's derivative
    kept: frozenset[int]  # slots whose rows are wanted


class OrderInLoop(NamedTuple):
    """The current order k = 4 fours + 1 + rest, the same as a float, and the address of column k of J."""

    fours: Any
    rest: int
    number: Any
    column: Any


def jets_module(function: ModeTape, name: str) -> Any:
    """LLVM module with the function `name`(z, constants, terms, J, order)."""
    from llvmlite import ir

    body = empty_function(ir, 4, name)
    JetWriter(ir, body, function).write()
    return body.module


def empty_function(ir: Any, arrays: int, name: str) -> Any:
    """An empty function `name` of this number of arrays, which do not overlap, and of the order."""
    pointers = [ir.DoubleType().as_pointer()] * arrays
    signature = ir.FunctionType(ir.VoidType(), [*pointers, ir.IntType(64)])
    body = ir.Function(ir.Module(name=name), signature, name)
    for argument in body.args[:arrays]:
        argument.add_attribute("noalias")
    return body


class JetWriter(Instructions):
    """Writes the recurrences; `values` holds the coefficients of all slots at the current order."""

    def __init__(self, ir: Any, body: Any, function: ModeTape) -> None:
        super().__init__(ir, ir.IRBuilder(body.append_basic_block()), JET_COLUMNS)
        self.function = function
        self.z, self.constants, self.terms, self.J = body.args[:4]
        self.order = body.args[-1]
        self.values: dict[int, Any] = {}
        operands = {slot for kind, a, b in function.tape.ops if kind != AFFINE for slot in (a, b)}
        outputs = {function.tape.inputs + i for i, op in enumerate(function.tape.ops) if op[0] > SQUARE}
        self.stored = function.kept | operands | outputs | set(range(function.tape.inputs))
        self.reversed = self._reversed_rows()

    def _reversed_rows(self) -> dict[int, Any]:
        """A second row, from right to left, for each slot that convolutions read backwards.

        Four coefficients are then loaded as a vector in the sequence in which they are wanted.  The address
        is that of coefficient 0.
        """
        tape = self.function.tape
        slots = {b for kind, _, b in tape.ops if kind in (PRODUCT, SQUARE) or kind > POWER}
        slots |= {tape.inputs + i for i, (kind, _, _) in enumerate(tape.ops) if kind in (QUOTIENT, POWER)}
        rows, ends = self.build.alloca(self.kind, len(slots) * self.row), range(self.row - 1, 2**31, self.row)
        return {slot: self._ahead(rows, self.whole(end)) for slot, end in zip(sorted(slots), ends)}

    def write(self) -> None:
        self.jets()
        self.build.ret_void()

    def jets(self) -> None:
        """Write the code for columns 0 to `order` of J."""
        for i in range(self.function.tape.inputs):
            self._set(i, None, self._load(self.z, i))
        self._operations(None)
        for slot in sorted({*self.function.flow} - self.stored):
            self._store(self.values[slot], self.J, slot * self.row)
        self._prepare_powers()
        done = self.build.append_basic_block()
        write_loop(self.build, self.order, self._rates(), partial(self._columns, done))
        self.build.branch(done)
        self.build.position_at_end(done)

    def _rates(self) -> Values:
        return [self.values[slot] for slot in self.function.flow]

    def _columns(self, done: Any, fours: Any, rates: Values) -> Values:
        """The next four columns.

        As they come in fours, it is known how many terms of each convolution are left after groups of four.
        """
        build, first = self.build, self.build.shl(fours, self.whole(2))
        for rest in range(PARTS):
            k = build.add(first, self.whole(rest + 1))
            at = OrderInLoop(fours, rest, self._as_number(k), self._ahead(self.J, k))
            rates = self._column(at, rates)
            following = build.append_basic_block()
            build.cbranch(build.icmp_signed("==", k, self.order), done, following)
            build.position_at_end(following)
        return rates

    def _column(self, at: OrderInLoop, rates: Values) -> Values:
        """A column, from the rates in the one before; returns its own rates."""
        share = self.build.fdiv(self._number(1.0), at.number)
        for state, rate in enumerate(rates):
            self._set(state, at, self.build.fmul(rate, share))
        self._operations(at)
        return self._rates()

    def _operations(self, at: OrderInLoop | None) -> None:
        for i, (kind, a, b) in enumerate(self.function.tape.ops):
            value = self._value(i, kind, a, b) if at is None else self._coefficient(i, kind, a, b, at)
            self._set(self.function.tape.inputs + i, at, value)

    def _value(self, i: int, kind: int, a: int, b: int) -> Any:
        """Coefficient 0."""
        build, values = self.build, self.values
        if kind == AFFINE:
            return self._affine(a, b, self._load(self.constants, self.function.first[0] + i))
        if kind in (PRODUCT, SQUARE):  # a square's operands are the same
            return build.fmul(values[a], values[b])
        if kind == QUOTIENT:
            return build.fdiv(values[a], values[b])
        if kind == RATE:
            return self._number(0.0)
        return self._power_value(i, values[a]) if kind == POWER else self._function_value(kind, values[a])

    def _function_value(self, kind: int, a: Any) -> Any:
        return self._call(VALUE_SYMBOL, self.whole(kind), a)

    def _coefficient(self, i: int, kind: int, a: int, b: int, at: OrderInLoop) -> Any:
        """Coefficient k > 0."""
        build, values, out = self.build, self.values, self.function.tape.inputs + i
        if kind == AFFINE:
            return self._affine(a, b, None)
        if kind == PRODUCT:
            return self._product(a, b, at)
        if kind == SQUARE:
            return self._square(a, at)
        if kind == QUOTIENT:
            total = build.fsub(values[a], self._convolution(b, out, at, 1))
            return build.fdiv(total, self._at(b, self.J))
        if kind == RATE:
            return build.fmul(at.number, values[a])
        if kind == POWER:
            return self._power(i, a, out, at)
        return build.fdiv(self._convolution(out - 1, b, at, 1), at.number)

    def _affine(self, first: int, last: int, total: Any) -> Any:
        for j in range(first, last):
            slot, value = self.function.tape.terms[j][0], self._load(self.terms, self.function.first[1] + j)
            factor = self.values[slot]
            total = (
                self.build.fmul(value, factor) if total is None else self._multiply_add(value, factor, total)
            )
        return self._number(0.0) if total is None else total

    def _product(self, a: int, b: int, at: OrderInLoop) -> Any:
        total = self._convolution(a, b, at, 0)
        total = self._multiply_add(self.values[a], self._at(b, self.J), total)
        return self._multiply_add(self._at(a, self.J), self.values[b], total)

    def _square(self, a: int, at: OrderInLoop) -> Any:
        """The sum over each pair once; groups of four leave two more pairs if `fours` is odd."""
        build, two = self.build, self._number(2.0)
        ahead, behind, parts = self._groups(a, a, at, build.ashr(at.fours, self.whole(1)))
        odd = build.icmp_signed("!=", build.and_(at.fours, self.whole(1)), self.whole(0))
        single = at.rest // 2
        parts = write_branch(
            build,
            odd,
            lambda: self._rest(2 + single, ahead, behind, parts),
            lambda: self._rest(single, ahead, behind, parts),
        )
        total = build.fmul(two, self._in_pairs(parts))
        if at.rest % 2 == 1:
            middle = self._ahead(
                self.J, build.add(build.shl(at.fours, self.whole(1)), self.whole(1 + single))
            )
            total = self._multiply_add(self._at(a, middle), self._at(a, middle), total)
        return self._multiply_add(build.fmul(two, self._at(a, self.J)), self.values[a], total)

    def _prepare_powers(self) -> None:
        """Compute the least ratios of a base to its rate and curvature at which a power has a series."""
        if any(kind == POWER for kind, _, _ in self.function.tape.ops):
            build, kind, one = self.build, self.ir.DoubleType(), self.whole(1)
            order = build.select(build.icmp_signed(">", self.order, one), self.order, one)
            exponent = build.fdiv(kind(LOG2_LEAST_RATIO), build.sitofp(order, kind))
            self.shortest = self._spread(write_exp2(self.ir, build, exponent))
            self.shortest_squared = build.fmul(self.shortest, self.shortest)

    def _power_value(self, i: int, base: Any) -> Any:
        build, exponent, regular = self.build, self._exponent(i), self._regular(base)
        value = self._call(POWER_SYMBOL, build.select(regular, base, self._number(1.0)), exponent)
        return build.select(regular, value, self._limit(exponent))

    def _power(self, i: int, a: int, out: int, at: OrderInLoop) -> Any:
        build, base, exponent = self.build, self._at(a, self.J), self._exponent(i)
        has_series = self._has_series(a, base, at)
        rates, plain = self._convolution(out - 1, out, at, 1), self._convolution(a, out, at, 1)
        total = build.fmul(build.fadd(exponent, self._number(1.0)), rates)
        total = build.fadd(total, build.fmul(build.fneg(at.number), plain))
        total = build.fdiv(total, build.fmul(at.number, base))
        total = build.select(has_series, total, self._number(0.0))
        return build.select(self._regular(base), total, self._limit(exponent))

    def _has_series(self, a: int, base: Any, at: OrderInLoop) -> Any:
        """As :func:`jets.has_series`; at k = 1 the curvature of the base is not known yet."""
        build = self.build
        rate, curvature = (self._abs(self._at(a, self._ahead(self.J, self.whole(m)))) for m in (1, 2))
        slow = build.fcmp_ordered(">", base, build.fmul(self.shortest, rate))
        straight = build.fcmp_ordered(">", base, build.fmul(self.shortest_squared, curvature))
        if at.rest == 0:
            straight = build.or_(straight, build.fcmp_ordered("==", at.number, self._number(1.0)))
        return build.and_(slow, straight)

    def _exponent(self, i: int) -> Any:
        return self._load(self.constants, self.function.first[0] + i)

    def _regular(self, base: Any) -> Any:
        return self.build.fcmp_ordered(">", base, self._number(0.0))

    def _limit(self, exponent: Any) -> Any:
        """The limit of a power where its base goes to zero."""
        negative = self.build.fcmp_ordered("<", exponent, self._number(0.0))
        return self.build.select(negative, self._number(float("inf")), self._number(0.0))

    def _convolution(self, a: int, b: int, at: OrderInLoop, more: int) -> Any:
        """Sum over 1 <= j < k + `more` of the coefficients j of a and k - j of b."""
        whole, rest = divmod(at.rest + more, PARTS)
        ahead, behind, parts = self._groups(a, b, at, self.build.add(at.fours, self.whole(whole)))
        return self._in_pairs(self._rest(rest, ahead, behind, parts))

    def _groups(self, a: int, b: int, at: OrderInLoop, fours: Any) -> tuple[Any, Any, Values]:
        """Sum over `fours` groups of four pairs; returns the addresses of the next pair and the four sums."""
        ahead = self._place(a, self._ahead(self.J, self.whole(1)))
        behind = self._newest(b, at)
        parts = self._fours(fours, ahead, behind)
        done = self.build.shl(fours, self.whole(2))
        return self._ahead(ahead, done), self._back(behind, done), parts

    def _newest(self, slot: int, at: OrderInLoop) -> Any:
        """The address of coefficient k - 1 of a slot that is read backwards."""
        return self._back(self.reversed[slot], self.build.sub(self.whole(1), self._order(at)))

    def _back(self, place: Any, count: Any) -> Any:
        """The address of the coefficient `count` orders below the one at a place that is read backwards."""
        return self._ahead(place, count)

    def _order(self, at: OrderInLoop) -> Any:
        return self.build.add(self.build.shl(at.fours, self.whole(2)), self.whole(at.rest + 1))

    def _rest(self, count: int, ahead: Any, behind: Any, parts: Values) -> Values:
        """The four sums, with one more pair added to each of the first `count`."""
        return [self._further(ahead, behind, j, parts[j]) for j in range(count)] + parts[count:]

    def _further(self, ahead: Any, behind: Any, j: int, part: Any) -> Any:
        last = self._load(self._back(behind, self.whole(j)), 0)
        return self._multiply_add(self._load(ahead, j), last, part)

    def _in_pairs(self, parts: Values) -> Any:
        return self.build.fadd(self.build.fadd(parts[0], parts[1]), self.build.fadd(parts[2], parts[3]))

    def _fours(self, count: Any, ahead: Any, behind: Any) -> Values:
        """The four sums over `count` groups of four pairs, computed as one vector."""
        build, four = self.build, self.ir.VectorType(self.ir.DoubleType(), PARTS)

        def group(i: Any, sums: Values) -> Values:
            j = build.shl(i, self.whole(2))
            forward = self._vector(self._ahead(ahead, j), 0, four)
            backward = self._vector(self._back(behind, j), 0, four)
            return [self._multiply_add(forward, backward, sums[0])]

        (total,) = write_loop(build, count, [llvm_constant(self.ir, four, 0.0)], group)
        return [build.extract_element(total, self.ir.IntType(32)(j)) for j in range(PARTS)]

    def _set(self, slot: int, at: OrderInLoop | None, value: Any) -> None:
        self.values[slot] = value
        if slot in self.stored:
            self._store(value, self.J if at is None else at.column, slot * self.row)
        if slot in self.reversed:
            order = self.whole(0) if at is None else self._order(at)
            self._store(value, self._ahead(self.reversed[slot], self.build.neg(order)), 0)


class LaneWriter(JetWriter):
    """The recurrences for several runs side by side, and other operations on all lanes."""

    width = LANE_COUNT

    def __init__(self, ir: Any, body: Any, function: ModeTape) -> None:
        super().__init__(ir, body, function)
        self.control = body.args[4]

    def _reversed_rows(self) -> dict[int, Any]:
        """None: a vector holds one coefficient of all lanes."""
        return {}

    def _newest(self, slot: int, at: OrderInLoop) -> Any:
        return self._place(slot, self._ahead(at.column, self.whole(-1)))

    def _back(self, place: Any, count: Any) -> Any:
        return self._ahead(place, self.build.neg(count))

    def _largest(self, first: int, last: int, k: Any) -> Any:
        """Largest coefficient k of the states [first, last); infinite where one is NaN."""
        build, size = self.build, self._number(0.0)
        column = self._ahead(self.J, k)
        for i in range(first, last):
            c = self._abs(self._at(i, column))
            clean = build.select(build.fcmp_ordered("ord", c, c), c, self._number(float("inf")))
            size = build.select(build.fcmp_unordered(">", c, size), clean, size)
        return size

    def _fours(self, count: Any, ahead: Any, behind: Any) -> Values:
        def group(i: Any, sums: Values) -> Values:
            j = self.build.shl(i, self.whole(2))
            front, back = self._ahead(ahead, j), self._back(behind, j)
            return [self._further(front, back, part, total) for part, total in enumerate(sums)]

        return write_loop(self.build, count, [self._number(0.0)] * PARTS, group)

    def _call(self, name: str, *arguments: Any) -> Any:
        result = self._number(0.0)
        for lane in range(LANE_COUNT):
            place = self.ir.IntType(32)(lane)
            numbers = (self.build.extract_element(a, place) if a.type == self.kind else a for a in arguments)
            each = super()._call(name, *numbers)
            result = self.build.insert_element(result, each, place)
        return result

    def _max(self, a: Any, b: Any) -> Any:
        return self.build.select(self.build.fcmp_ordered(">", b, a), b, a)

    def _min(self, a: Any, b: Any) -> Any:
        return self.build.select(self.build.fcmp_ordered("<", b, a), b, a)

    def _where(self, condition: Any, value: Any, otherwise: float) -> Any:
        return self.build.select(condition, value, self._number(otherwise))

    def _spread(self, value: Any) -> Any:
        result = self._number(0.0)
        for lane in range(LANE_COUNT):
            result = self.build.insert_element(result, value, self.ir.IntType(32)(lane))
        return result
