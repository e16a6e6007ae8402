"""Straight-line machine code of a mode's jets: the tape unrolled over its operations and orders.

It does the same operations in the same sequence as :func:`frictionlab.hybrid.jets.run_tape`, so its results
are those of the interpreter to the last bit, and a run may change from one to the other at any step.  It
leaves out the rows of slots that nobody reads.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from frictionlab.hybrid.tape import AFFINE, FUNCTIONS, POWER, PRODUCT, QUOTIENT, RATE, SQUARE, Tape

LANES = 4
SMALLEST = 1e-290  # as in :func:`frictionlab.hybrid.jets.has_series`
SYMBOLS = {POWER: "pow"} | {POWER + 1 + i: f.__name__ for i, f in enumerate(FUNCTIONS)}


class Function(NamedTuple):
    """What the code of one mode is made from."""

    tape: Tape
    first: tuple[int, int]  # place of the tape's operations, and of its terms, among all
    flow: tuple[int, ...]  # slot that holds each state's derivative
    kept: frozenset[int]  # slots whose rows are wanted
    order: int
    row: int  # length of a row of J


def module_of(function: Function, name: str) -> Any:
    """LLVM module with the function `name`(z, constants, terms, J)."""
    from llvmlite import ir

    module = ir.Module(name=name)
    pointer = ir.DoubleType().as_pointer()
    body = ir.Function(module, ir.FunctionType(ir.VoidType(), [pointer] * 4), name)
    for argument in body.args:
        argument.add_attribute("noalias")
    Writer(ir, body, function).write()
    return module


class Writer:
    """Writes the instructions; `values` are those of all slots, by order."""

    width = 1  # numbers in a value

    def __init__(self, ir: Any, body: Any, function: Function) -> None:
        self.ir, self.function = ir, function
        self.build = ir.IRBuilder(body.append_basic_block())
        four = ir.VectorType(ir.DoubleType(), LANES)
        self.fma = ir.Function(body.module, ir.FunctionType(four, [four] * 3), "llvm.fma.v4f64")
        self.z, self.constants, self.terms, self.J = body.args[:4]
        self.values: list[list[Any]] = [[] for _ in range(function.tape.slots)]
        operands = {slot for kind, a, b in function.tape.ops if kind != AFFINE for slot in (a, b)}
        outputs = {function.tape.inputs + i for i, op in enumerate(function.tape.ops) if op[0] > SQUARE}
        self.stored = function.kept | operands | outputs | set(range(function.tape.inputs))
        self.called: dict[str, Any] = {}

    def write(self) -> None:
        self.jets()
        self.build.ret_void()

    def jets(self) -> None:
        tape, flow = self.function.tape, self.function.flow
        for i in range(tape.inputs):
            self._set(i, 0, self._load(self.z, i))
        for k in range(self.function.order + 1):
            for i, (kind, a, b) in enumerate(tape.ops):
                self._set(tape.inputs + i, k, self._operation(i, kind, a, b, k))
            if k < self.function.order:
                share = self._number(1.0 / (k + 1))
                for i in range(tape.inputs):
                    self._set(i, k + 1, self.build.fmul(self.values[flow[i]][k], share))

    def _operation(self, i: int, kind: int, a: int, b: int, k: int) -> Any:
        if kind == AFFINE:
            return self._affine(i, a, b, k)
        if kind == PRODUCT:
            return self._product(a, b, k)
        if kind == SQUARE:
            return self._square(a, k)
        out = self.function.tape.inputs + i
        if kind == QUOTIENT:
            return self._quotient(a, b, out, k)
        if kind == RATE:
            return self.build.fmul(self._number(k), self.values[a][k])
        return self._power(i, a, out, k) if kind == POWER else self._function(kind, a, b, out, k)

    def _affine(self, i: int, first: int, last: int, k: int) -> Any:
        place, terms = self.function.first
        total = self._load(self.constants, place + i) if k == 0 else None
        for j in range(first, last):
            slot, value = self.function.tape.terms[j][0], self._load(self.terms, terms + j)
            factor = self.values[slot][k]
            total = self.build.fmul(value, factor) if total is None else self._fma(value, factor, total)
        return self._number(0.0) if total is None else total

    def _product(self, a: int, b: int, k: int) -> Any:
        build, values = self.build, self.values
        if k == 0:
            return build.fmul(values[a][0], values[b][0])
        total = self._fma(values[a][0], values[b][k], self._convolution(a, b, 1, k - 1, k))
        return self._fma(values[a][k], values[b][0], total)

    def _square(self, a: int, k: int) -> Any:
        build, row = self.build, self.values[a]
        if k == 0:
            return build.fmul(row[0], row[0])
        total = build.fmul(self._number(2.0), self._convolution(a, a, 1, (k - 1) // 2, k))
        if k % 2 == 0:
            total = self._fma(row[k // 2], row[k // 2], total)
        return self._fma(build.fmul(self._number(2.0), row[0]), row[k], total)

    def _quotient(self, a: int, b: int, out: int, k: int) -> Any:
        total = self.build.fsub(self.values[a][k], self._convolution(b, out, 1, k, k))
        return self.build.fdiv(total, self.values[b][0])

    def _function(self, kind: int, a: int, slope: int, out: int, k: int) -> Any:
        if k == 0:
            return self._call(SYMBOLS[kind], self.values[a][0])
        return self.build.fdiv(self._convolution(out - 1, slope, 1, k, k), self._number(k))

    def _power(self, i: int, a: int, out: int, k: int) -> Any:
        build, base, zero = self.build, self.values[a][0], self._number(0.0)
        exponent = self._load(self.constants, self.function.first[0] + i)
        regular = build.fcmp_ordered(">", base, zero)
        negative = build.fcmp_ordered("<", exponent, zero)
        limit = build.select(negative, self._number(float("inf")), zero)
        if k == 0:
            one = self._number(1.0)
            return build.select(regular, self._call("pow", build.select(regular, base, one), exponent), limit)
        shortest = self._number(SMALLEST ** (1.0 / self.function.order))
        has_series = build.fcmp_ordered(">", base, build.fmul(shortest, self._abs(self.values[a][1])))
        rates, plain = self._convolution(out - 1, out, 1, k, k), self._convolution(a, out, 1, k, k)
        total = build.fmul(build.fadd(exponent, self._number(1.0)), rates)
        total = build.fadd(total, build.fmul(self._number(-k), plain))
        total = build.select(has_series, build.fdiv(total, build.fmul(self._number(k), base)), zero)
        return build.select(regular, total, limit)

    def _abs(self, a: Any) -> Any:
        return self.build.select(self.build.fcmp_ordered("<", a, self._number(0.0)), self.build.fneg(a), a)

    def _call(self, name: str, *arguments: Any) -> Any:
        if name not in self.called:
            number = self.ir.DoubleType()
            kind = self.ir.FunctionType(number, [number] * len(arguments))
            self.called[name] = self.ir.Function(self.build.module, kind, name)
        return self.build.call(self.called[name], arguments)

    def _convolution(self, a: int, b: int, first: int, last: int, k: int) -> Any:
        """Sum over first <= j <= last of the coefficients j of a and k - j of b, in four lanes."""
        build, quads = self.build, (last - first + 1) // LANES
        lanes: list[Any] = [None] * LANES
        if quads:
            total = None
            for j in range(first, first + LANES * quads, LANES):
                forward, backward = self._four(a, j), self._reversed(self._four(b, k - j - LANES + 1))
                if total is None:
                    total = build.fmul(forward, backward)
                else:
                    total = build.call(self.fma, [forward, backward, total])
            lanes = [build.extract_element(total, self._index(i)) for i in range(LANES)]
        for i, j in enumerate(range(first + LANES * quads, last + 1)):
            pair = self.values[a][j], self.values[b][k - j]
            lanes[i] = build.fmul(*pair) if lanes[i] is None else self._fma(*pair, lanes[i])
        return self._in_pairs(lanes)

    def _in_pairs(self, lanes: list[Any]) -> Any:
        return self._sum(self._sum(lanes[0], lanes[1]), self._sum(lanes[2], lanes[3])) or self._number(0.0)

    def _fma(self, a: Any, b: Any, c: Any) -> Any:
        return self.build.fma(a, b, c)

    def _sum(self, one: Any, other: Any) -> Any:
        return self.build.fadd(one, other) if one is not None and other is not None else one or other

    def _four(self, slot: int, k: int) -> Any:
        kind = self.ir.VectorType(self.ir.DoubleType(), LANES).as_pointer()
        place = self.build.bitcast(self._place(slot, k), kind)
        return self.build.load(place, align=8)

    def _reversed(self, vector: Any) -> Any:
        order = self.ir.Constant(
            self.ir.VectorType(self.ir.IntType(32), LANES), list(range(LANES - 1, -1, -1))
        )
        return self.build.shuffle_vector(vector, vector, order)

    def _set(self, slot: int, k: int, value: Any) -> None:
        self.values[slot].append(value)
        if slot in self.stored:
            self.build.store(value, self._place(slot, k), align=8)

    def _place(self, slot: int, k: int) -> Any:
        return self.build.gep(self.J, [self._index(slot * self.function.row + k)])

    def _load(self, array: Any, i: int) -> Any:
        return self.build.load(self.build.gep(array, [self._index(i)]))

    def _index(self, i: int) -> Any:
        return self.ir.Constant(self.ir.IntType(32), i)

    def _number(self, value: float) -> Any:
        return self.ir.Constant(self.ir.DoubleType(), float(np.float64(value)))
