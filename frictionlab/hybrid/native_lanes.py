"""Straight-line machine code of a whole step without an event, for several runs side by side.

Every value is a vector with one number for each run (lane).  The operations are those of one run, in the same
sequence (:mod:`native`, :func:`step_length.step_length`, :func:`guards.smallest`), so a lane's numbers are
those that the run would have alone, to the last bit.  Where a lane needs more than the usual, which is an
event or anything rare, it is marked, and its state is left for the kernel of single runs.
"""

from __future__ import annotations

from typing import Any

from frictionlab.hybrid.logarithms import exp2, log2, number
from frictionlab.hybrid.native import Function, Writer

WIDTH = 8
LEFT, LENGTH, FINE, TOL, LOG_TOL, GUARD_TOL = range(6)  # rows of `control`, all of WIDTH numbers
ROWS = 6


def step_module_of(function: Function, guards: tuple[int, ...], groups: tuple[int, ...], name: str) -> Any:
    """LLVM module with the function `name`(z, constants, terms, J, control).

    All arrays have the lanes as their last axis.  Row LEFT of `control` holds the longest step wanted;
    LENGTH and FINE (1 or 0) are written; `z` is moved on where the lane is fine.
    """
    from llvmlite import ir

    module = ir.Module(name=name)
    pointer = ir.DoubleType().as_pointer()
    body = ir.Function(module, ir.FunctionType(ir.VoidType(), [pointer] * 5), name)
    for argument in body.args:
        argument.add_attribute("noalias")
    _StepWriter(ir, body, function, guards, groups).write()
    return module


class _StepWriter(Writer):
    """Jets, length of the step, guards, and the state at the end."""

    width = WIDTH

    def __init__(self, ir: Any, body: Any, function: Function, guards: Any, groups: Any) -> None:
        self.kind = ir.VectorType(ir.DoubleType(), WIDTH)
        self.guards, self.groups, self.control = guards, groups, body.args[4]
        super().__init__(ir, body, function)
        kinds = [self.kind] * 3
        self._vector_fma = ir.Function(body.module, ir.FunctionType(self.kind, kinds), "llvm.fma.v8f64")
        self._vector_abs = ir.Function(body.module, ir.FunctionType(self.kind, kinds[:1]), "llvm.fabs.v8f64")

    def write(self) -> None:
        self.jets()
        h, fine = self._length()
        build = self.build
        left = self._load(self.control, LEFT)
        h = build.select(build.fcmp_ordered("<", left, h), left, h)
        for guard in self.guards:
            fine = build.and_(fine, self._resolved(guard, h))
            fine = build.and_(fine, build.fcmp_ordered(">", self._smallest(guard, h), self._number(0.0)))
        one, zero = self._number(1.0), self._number(0.0)
        self._store(h, self.control, LENGTH)
        self._store(build.select(fine, one, zero), self.control, FINE)
        for i in range(self.function.tape.inputs):
            self._store(build.select(fine, self._end(i, h), self.values[i][0]), self.z, i)
        build.ret_void()

    def _length(self) -> tuple[Any, Any]:
        """Length of the step, and whether it is one of the usual."""
        build, best = self.build, self._number(float("inf"))
        fine = self._number(0.0)
        fine = build.fcmp_ordered("==", fine, fine)
        for first, last in zip(self.groups, self.groups[1:]):
            if last > first:
                best, fine = self._group_length(first, last, best, fine)
        return exp2(self.ir, build, best), fine

    def _group_length(self, first: int, last: int, best: Any, fine: Any) -> tuple[Any, Any]:
        build, ir, order = self.build, self.ir, self.function.order
        zero = self._number(0.0)
        sizes = [self._largest(first, last, m) for m in range(3)]
        starts = [log2(ir, build, size) for size in sizes]
        log_tol = self._load(self.control, LOG_TOL)
        some = build.fcmp_ordered(">", self._max(sizes[0], self._max(sizes[1], sizes[2])), zero)
        for p in (order - 1, order):
            end = self._largest(first, last, p)
            fine = build.and_(fine, build.fcmp_ordered("<", end, self._number(float("inf"))))
            room = build.fsub(log_tol, log2(ir, build, end))
            each = [build.fdiv(build.fadd(room, starts[m]), self._number(float(p - m))) for m in range(3)]
            longest = self._max(each[0], self._max(each[1], each[2]))
            moves = build.fcmp_ordered(">", end, zero)
            fine = build.and_(fine, build.or_(some, build.not_(moves)))
            shorter = build.and_(moves, build.fcmp_ordered("<", longest, best))
            best = build.select(shorter, longest, best)
        return best, fine

    def _largest(self, first: int, last: int, k: int) -> Any:
        build, size = self.build, self._number(0.0)
        for i in range(first, last):
            c = self._abs(self.values[i][k])
            clean = build.select(build.fcmp_ordered("ord", c, c), c, self._number(float("inf")))
            size = build.select(build.fcmp_unordered(">", c, size), clean, size)
        return size

    def _resolved(self, slot: int, h: Any) -> Any:
        """Whether the series of a guard holds for the whole step."""
        build, order, row = self.build, self.function.order, self.values[slot]
        size, power = self._number(0.0), self._number(1.0)
        for k in range(order - 1):
            size = self._max(size, build.fmul(self._abs(row[k]), power))
            power = build.fmul(power, h)
        last = self._max(self._abs(row[order - 1]), build.fmul(self._abs(row[order]), h))
        limit = build.fmul(self._load(self.control, GUARD_TOL), size)
        holds = build.fcmp_unordered("<=", build.fmul(last, power), limit)
        return build.or_(holds, build.fcmp_ordered("==", size, self._number(0.0)))

    def _smallest(self, slot: int, h: Any) -> Any:
        """Lower bound of a guard over the step."""
        build, row, zero = self.build, self.values[slot], self._number(0.0)
        total, power = row[0], self._number(1.0)
        for k in range(1, self.function.order + 1):
            power = build.fmul(power, h)
            falls = build.fcmp_ordered("<", row[k], zero)
            total = build.fadd(total, build.select(falls, build.fmul(row[k], power), zero))
        return total

    def _end(self, i: int, h: Any) -> Any:
        build, row = self.build, self.values[i]
        total = row[-1]
        for c in row[-2::-1]:
            total = build.fadd(build.fmul(total, h), c)
        return total

    def _convolution(self, a: int, b: int, first: int, last: int, k: int) -> Any:
        lanes: list[Any] = [None] * 4
        for i, j in enumerate(range(first, last + 1)):
            pair = (
                self._load(self.J, a * self.function.row + j),
                self._load(self.J, b * self.function.row + k - j),
            )
            before = lanes[i % 4]
            lanes[i % 4] = self.build.fmul(*pair) if before is None else self._fma(*pair, before)
        return self._in_pairs(lanes)

    def _call(self, name: str, *arguments: Any) -> Any:
        result = self._number(0.0)
        for lane in range(WIDTH):
            place = self._index(lane)
            each = super()._call(name, *(self.build.extract_element(vector, place) for vector in arguments))
            result = self.build.insert_element(result, each, place)
        return result

    def _fma(self, a: Any, b: Any, c: Any) -> Any:
        return self.build.call(self._vector_fma, [a, b, c])

    def _abs(self, a: Any) -> Any:
        return self.build.call(self._vector_abs, [a])

    def _max(self, a: Any, b: Any) -> Any:
        return self.build.select(self.build.fcmp_ordered(">", b, a), b, a)

    def _place(self, slot: int, k: int) -> Any:
        return self._vector(self.J, slot * self.function.row + k)

    def _load(self, array: Any, i: int) -> Any:
        return self.build.load(self._vector(array, i), align=8)

    def _store(self, value: Any, array: Any, i: int) -> None:
        self.build.store(value, self._vector(array, i), align=8)

    def _vector(self, array: Any, i: int) -> Any:
        place = self.build.gep(array, [self._index(i * WIDTH)])
        return self.build.bitcast(place, self.kind.as_pointer())

    def _number(self, value: float) -> Any:
        return number(self.ir, self.kind, value)
