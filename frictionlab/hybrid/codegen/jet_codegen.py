"""Machine code of a mode's jets: its operations in sequence, within a loop over the orders asked for.

It does the same operations in the same sequence as :func:`frictionlab.hybrid.kernels.jets.run_tape`, so its
results are those of the interpreter to the last bit, and a run may change from one to the other at any step.
If only the current coefficient of a slot is read, its row is not stored.  The values of the states' rates are
always stored.  Affine sums of mostly the same slots are one vector, and so are the states whose derivatives
they are (`side_by_side`).
`LaneWriter` writes the same for several runs side by side: every value has one number for each run (lane).

Functions and powers are computed by calls of their kernels, so that their code exists only once; a call takes
little time beside theirs.  The kernels' names are registered with LLVM when code that holds them is loaded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache, partial
from itertools import islice
from typing import Any, NamedTuple

from frictionlab.compilation import machine_code
from frictionlab.compilation.decorators import c_address
from frictionlab.compilation.llvm_instructions import (
    Instructions,
    Values,
    llvm_constant,
    write_exp2,
    write_loop,
)
from frictionlab.compilation.targets import processor_features
from frictionlab.hybrid.codegen.side_by_side import Group, states_side_by_side, sums_side_by_side
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


Pair = tuple[int, int]  # of slots
CONVOLUTIONS_PER_LOOP = 2  # with more, AVX2 has too few registers
# Rows of `control`, with a number for each lane; one row more for each guard has its number of leading zeros.
LEFT, LENGTH, REGULAR, MEASURED, SUITED, TOL, LOG_TOL, GUARD_TOL = range(8)
CONTROL_ROWS = 8
MEASURE, MOVE = range(2)  # the parts of a step of lanes


@cache
def lane_count() -> int:
    """How many runs step side by side: eight where AVX-512 has vectors of so many numbers, else four."""
    wide = machine_code.HAS_MACHINE_CODE and processor_features().get("avx512f")
    return 2 * PARTS if wide else PARTS


class ModeTape(NamedTuple):
    """The tape of one mode, from which its code is written."""

    tape: Tape
    first: tuple[int, int]  # where its operations, and its terms, begin among those of all tapes
    flow: tuple[int, ...]  # slot that holds each state's derivative
    kept: frozenset[int]  # slots whose rows are wanted


def convolutions_of(tape: Tape) -> list[Pair]:
    """The pairs of slots whose series operations of a tape multiply, each once."""
    pairs = []
    for out, (kind, a, b) in enumerate(tape.ops, start=tape.inputs):
        if kind in (PRODUCT, SQUARE):
            pairs.append((a, b))
        elif kind == QUOTIENT:
            pairs.append((b, out))
        elif kind == POWER:
            pairs += [(out - 1, out), (a, out)]
        elif kind > POWER:
            pairs.append((out - 1, b))
    return list(dict.fromkeys(pairs))


class OrderInLoop(NamedTuple):
    """The current order k = 4 fours + 1 + rest, the same as a float, and the address of column k of J."""

    fours: Any
    rest: int
    number: Any
    column: Any


def jets_module(function: ModeTape, name: str) -> Any:
    """LLVM module with the function `name`(z, constants, terms, J, order)."""
    from llvmlite import ir

    body = empty_function(ir, 4, 1, name)
    JetWriter(ir, body, function).write()
    return body.module


def empty_function(ir: Any, arrays: int, integers: int, name: str) -> Any:
    """An empty function `name` of these numbers of arrays, which do not overlap, and of integers."""
    pointers = [ir.DoubleType().as_pointer()] * arrays
    signature = ir.FunctionType(ir.VoidType(), [*pointers, *[ir.IntType(64)] * integers])
    body = ir.Function(ir.Module(name=name), signature, name)
    body.attributes.add("nounwind")
    body.attributes.alignstack = 8 * PARTS  # vectors kept there do not lie across the lines of a cache
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
        self.shares = self._table_of_shares()
        self.sum_groups = sums_side_by_side(function.tape, function.flow) if self.width == 1 else []
        self.state_groups = states_side_by_side(function.flow, self.sum_groups)
        self.vectors: dict[Group, Any] = {}  # the coefficients of groups at the current order
        self.factors: dict[Group, Values] = {}  # the addresses of the factors of sums
        self.first_block = True
        self.sums: dict[Pair, Values] = {}  # of convolutions, for the next orders of the block
        self.block: list[dict[int, Any]] = []  # the values at the orders of this block before the current one

    def _table_of_shares(self) -> Any:
        """The address of 1/k for k from 0 on; the first is not used."""
        shares = [0.0, *(1.0 / k for k in range(1, JET_COLUMNS))]
        kind = self.ir.ArrayType(self.ir.DoubleType(), len(shares))
        table = self.ir.GlobalVariable(self.build.module, kind, "shares")
        table.global_constant, table.linkage = True, "internal"
        table.initializer = self.ir.Constant(kind, shares)
        return self.build.gep(table, [self.whole(0), self.whole(0)])

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
        first, done = (self.build.append_basic_block() for _ in range(2))
        self.build.cbranch(self.build.icmp_signed("<", self.whole(0), self.order), first, done)
        self.build.position_at_end(first)
        self._prepare_factors()
        rates = self._columns(done, self.whole(0), self._rates())
        self.first_block = False
        write_loop(self.build, self.order, rates, partial(self._following_columns, done))
        self.build.branch(done)
        self.build.position_at_end(done)

    def _rates(self) -> Values:
        """The coefficients of the derivatives of all states, a vector for each group."""
        flow = self.function.flow
        return [self._group(tuple(flow[state] for state in group)) for group in self.state_groups]

    def _group(self, slots: Group) -> Any:
        """The coefficients of some slots, as a vector if they are more than one."""
        if slots in self.vectors:
            return self.vectors[slots]
        return self._together([self.values[slot] for slot in slots])

    def _together(self, values: Values) -> Any:
        """One value, or several numbers as a vector."""
        if len(values) == 1:
            return values[0]
        vector = self.ir.Constant(self.ir.VectorType(self.kind, len(values)), self.ir.Undefined)
        for place, value in enumerate(values):
            vector = self.build.insert_element(vector, value, self.ir.IntType(32)(place))
        return vector

    def _set_group(self, slots: Group, at: OrderInLoop, value: Any) -> None:
        self.vectors[slots] = value
        for place, slot in enumerate(slots):
            one = len(slots) == 1
            each = value if one else self.build.extract_element(value, self.ir.IntType(32)(place))
            self._set(slot, at, each)

    def _prepare_factors(self) -> None:
        """Put the factors of sums that are one vector side by side."""
        first = self.function.first[1]
        for group in self.sum_groups:
            self.factors[group] = []
            for numbers in self._terms_of(group):
                factors = self._together([self._load(self.terms, first + j) for j in numbers])
                with self.build.goto_entry_block():
                    place = self.build.alloca(factors.type)
                self.build.store(factors, place)
                self.factors[group].append(place)

    def _terms_of(self, group: Group) -> Iterable[Group]:
        """The numbers of the first terms of all sums, then of the second ones, and so on."""
        tape = self.function.tape
        return zip(*(range(*tape.ops[slot - tape.inputs][1:]) for slot in group), strict=True)

    def _sums(self, group: Group) -> Any:
        """Affine sums as one vector."""
        build, total = self.build, None
        for place, numbers in zip(self.factors[group], self._terms_of(group), strict=True):
            slots = tuple(self.function.tape.terms[j][0] for j in numbers)
            term = build.fmul(build.load(place), self._group(slots))
            total = term if total is None else build.fadd(total, term)
        return total

    def _following_columns(self, done: Any, before: Any, rates: Values) -> Values:
        fours = self.build.add(before, self.whole(1))
        self._prepare_convolutions(fours)
        return self._columns(done, fours, rates)

    def _columns(self, done: Any, fours: Any, rates: Values) -> Values:
        """The four columns of a block; goes on at `done` after the last order."""
        build, first = self.build, self.build.shl(fours, self.whole(2))
        self.block = []
        for rest in range(PARTS):
            k = build.add(first, self.whole(rest + 1))
            at = OrderInLoop(fours, rest, self._as_number(k), self._ahead(self.J, k))
            share = self._spread(build.load(build.gep(self.shares, [k])))
            shares = (self._together([share] * len(group)) for group in self.state_groups)
            rates = self._column(at, list(map(build.fmul, rates, shares)))
            self.block.append(dict(self.values))
            following = build.append_basic_block()
            build.cbranch(build.icmp_signed("==", k, self.order), done, following)
            build.position_at_end(following)
            if rest + 1 < PARTS:
                self._add_newest(at)
        return rates

    def _column(self, at: OrderInLoop, states: Values) -> Values:
        """A column, from the coefficients of the states; returns the rates."""
        for group, coefficient in zip(self.state_groups, states, strict=True):
            self._set_group(group, at, coefficient)
        self._operations(at)
        return self._rates()

    def _operations(self, at: OrderInLoop | None) -> None:
        groups = {slot: group for group in self.sum_groups for slot in group}
        for slot, (kind, a, b) in enumerate(self.function.tape.ops, start=self.function.tape.inputs):
            i, group = slot - self.function.tape.inputs, groups.get(slot, (slot,))
            if at is None:
                self._set(slot, at, self._value(i, kind, a, b))
            elif slot == group[-1]:
                value = self._sums(group) if slot in groups else self._coefficient(i, kind, a, b, at)
                self._set_group(group, at, value)

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
            total = build.fsub(values[a], self._convolution_with_last(b, out, at))
            return build.fdiv(total, self._at(b, self.J))
        if kind == RATE:
            return build.fmul(at.number, values[a])
        if kind == POWER:
            return self._power(i, a, out, at)
        return build.fdiv(self._convolution_with_last(out - 1, b, at), at.number)

    def _affine(self, first: int, last: int, total: Any) -> Any:
        for j in range(first, last):
            total = self._with_term(j, total)
        return self._number(0.0) if total is None else total

    def _with_term(self, j: int, total: Any) -> Any:
        """A term of an affine sum added to the others; factors 1 and -1 in the equations need no product."""
        (slot, factor), build = self.function.tape.terms[j], self.build
        if factor is None:
            term = build.fmul(self._load(self.terms, self.function.first[1] + j), self.values[slot])
        else:
            term = self.values[slot] if factor > 0 else self._with_sign(j, self.values[slot])
        return term if total is None else build.fadd(total, term)

    def _with_sign(self, j: int, value: Any) -> Any:
        """A value times the factor -1, which is 1 in a majorant, of no more orders than the first block."""
        if self.first_block:
            return self.build.fmul(self._load(self.terms, self.function.first[1] + j), value)
        return self.build.fneg(value)

    def _product(self, a: int, b: int, at: OrderInLoop) -> Any:
        total = self._convolution_with_last(a, b, at)
        return self._multiply_add(self._at(a, self.J), self.values[b], total)

    def _square(self, a: int, at: OrderInLoop) -> Any:
        twice = self.build.fmul(self._number(2.0), self._at(a, self.J))
        return self._multiply_add(twice, self.values[a], self._convolution(a, a, at))

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
        rates, plain = (self._convolution_with_last(slot, out, at) for slot in (out - 1, a))
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

    def _convolution_with_last(self, a: int, b: int, at: OrderInLoop) -> Any:
        """Sum over 1 <= j <= k of the coefficients j of a and k - j of b."""
        return self._multiply_add(self.values[a], self._at(b, self.J), self._convolution(a, b, at))

    def _convolution(self, a: int, b: int, at: OrderInLoop) -> Any:
        """Sum over 1 <= j < k of the coefficients j of a and k - j of b, as :func:`jets.convolution`."""
        if not self.first_block:
            return self.build.extract_element(self.sums[a, b][0], self.ir.IntType(32)(0))
        return self._with_block(a, b, self._number(0.0), at)

    def _with_block(self, a: int, b: int, total: Any, at: OrderInLoop) -> Any:
        """A convolution with the products that have a coefficient from the current block."""
        for n, newer in enumerate(self.block):
            low = self._ahead(self.J, self.whole(at.rest - n))
            total = self._multiply_add(newer[a], self._at(b, low), total)
            if not self.first_block:
                total = self._multiply_add(self._at(a, low), newer[b], total)
        return total

    def _prepare_convolutions(self, fours: Any) -> None:
        """Compute what is known of all convolutions before a block, as vectors of the sums for its orders."""
        four, pairs = self.ir.VectorType(self.kind, PARTS), convolutions_of(self.function.tape)
        for start in range(0, len(pairs), CONVOLUTIONS_PER_LOOP):
            some = pairs[start : start + CONVOLUTIONS_PER_LOOP]
            self.sums.update(self._known_sums(some, fours, [1], four))

    def _add_newest(self, at: OrderInLoop) -> None:
        """Add products with the coefficients of this order to the sums for the next orders of the block."""
        places = self.ir.VectorType(self.ir.IntType(32), PARTS)([1, 2, 3, 3])  # the last one is of no use
        for (a, b), (sums,) in self.sums.items():
            four, following = sums.type, self.build.shuffle_vector(sums, sums, places)
            for older, newer in (b, a), (a, b):
                low = self._vector(self._place(older, self.J), 1, four)
                newest = self._broadcast(self._place(newer, at.column), 0, four)
                following = self._multiply_add(newest, low, following)
            self.sums[a, b] = [following]

    def _known_sums(self, pairs: list[Pair], fours: Any, least: list[int], kind: Any) -> dict[Pair, Values]:
        """What is known of convolutions before the block after order 4 `fours`.

        They are for its orders with the numbers `least`, or for vectors of orders from these on.
        """
        build, base = self.build, self._ahead(self.J, self.build.shl(fours, self.whole(2)))

        def group(i: Any, sums: Values) -> Values:
            done = build.shl(i, self.whole(2))
            front, back = self._ahead(base, build.neg(done)), self._ahead(self.J, done)
            factors = [
                (
                    self._broadcast(self._place(a, front), -n, kind),
                    self._vector(self._place(b, back), number + n, kind),
                )
                for a, b in pairs
                for number in least
                for n in range(PARTS)
            ]
            return [self._multiply_add(*both, part) for both, part in zip(factors, sums, strict=True)]

        zeros = [llvm_constant(self.ir, kind, 0.0)] * (PARTS * len(pairs) * len(least))
        parts = iter(write_loop(build, build.sub(fours, self.whole(1)), zeros, group))
        return {
            pair: [self._with_newest(*pair, list(islice(parts, PARTS)), base, number) for number in least]
            for pair in pairs
        }

    def _with_newest(self, a: int, b: int, parts: Values, base: Any, least: int) -> Any:
        """Four partial sums and the products with the newest coefficients of `b`, up to order 4 of `a`."""
        build, kind = self.build, parts[0].type
        first, newest = self._place(a, self.J), self._place(b, base)
        for n in range(PARTS + 1 - least):
            older = self._broadcast(first, PARTS - n, kind)
            product = build.fmul(older, self._vector(newest, least + n - PARTS, kind))
            parts[n] = build.fadd(self._first_numbers(product, PARTS - n), parts[n])
        return build.fadd(build.fadd(parts[0], parts[1]), build.fadd(parts[2], parts[3]))

    def _broadcast(self, array: Any, i: int, kind: Any) -> Any:
        """A coefficient in all places of a vector."""
        integer = self.ir.IntType(32)
        empty = self.ir.Constant(kind, self.ir.Undefined)
        vector = self.build.insert_element(empty, self._load(array, i), integer(0))
        return self.build.shuffle_vector(vector, empty, self.ir.VectorType(integer, PARTS)([0] * PARTS))

    def _first_numbers(self, vector: Any, count: int) -> Any:
        """A vector with zeros behind the first numbers."""
        places = [place if place < count else PARTS for place in range(PARTS)]
        zero = llvm_constant(self.ir, vector.type, 0.0)
        return self.build.shuffle_vector(vector, zero, self.ir.VectorType(self.ir.IntType(32), PARTS)(places))

    def _set(self, slot: int, at: OrderInLoop | None, value: Any) -> None:
        self.values[slot] = value
        if slot in self.stored:
            self._store(value, self.J if at is None else at.column, slot * self.row)


class LaneWriter(JetWriter):
    """The recurrences for several runs side by side, and other operations on all lanes."""

    def __init__(self, ir: Any, body: Any, function: ModeTape) -> None:
        self.width = lane_count()
        super().__init__(ir, body, function)
        self.control = body.args[4]

    def _with_sign(self, j: int, value: Any) -> Any:
        return self.build.fneg(value)

    def _prepare_convolutions(self, fours: Any) -> None:
        """As for one run; a vector holds one coefficient of all lanes, so each order has a sum of its own."""
        together = self.width // 2  # orders in a loop: with vectors of eight numbers come 32 registers
        for pair in convolutions_of(self.function.tape):
            self.sums[pair] = []
            for first in range(1, PARTS + 1, together):
                orders = list(range(first, first + together))
                self.sums[pair] += self._known_sums([pair], fours, orders, self.kind)[pair]

    def _add_newest(self, at: OrderInLoop) -> None:
        """Products with coefficients of the block are added where the convolution is wanted."""

    def _convolution(self, a: int, b: int, at: OrderInLoop) -> Any:
        total = self._number(0.0) if self.first_block else self.sums[a, b][at.rest]
        return self._with_block(a, b, total, at)

    def _broadcast(self, array: Any, i: int, kind: Any) -> Any:
        return self._load(array, i)

    def _first_numbers(self, vector: Any, count: int) -> Any:
        return vector

    def _largest(self, first: int, last: int, k: Any) -> Any:
        """Largest coefficient k of the states [first, last); infinite where one is NaN."""
        build, size = self.build, self._number(0.0)
        column = self._ahead(self.J, k)
        for i in range(first, last):
            c = self._abs(self._at(i, column))
            clean = build.select(build.fcmp_ordered("ord", c, c), c, self._number(float("inf")))
            size = build.select(build.fcmp_unordered(">", c, size), clean, size)
        return size

    def _call(self, name: str, *arguments: Any) -> Any:
        result = self._number(0.0)
        for lane in range(self.width):
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
        for lane in range(self.width):
            result = self.build.insert_element(result, value, self.ir.IntType(32)(lane))
        return result
