"""Machine code of a whole step without an event, for several runs side by side.

Every value is a vector with one number for each run (lane).  The operations are those of one run, in the same
sequence (`jet_codegen`, :func:`step_length.step_length`, :func:`event_location.lower_bound`), so a lane's
numbers are those that the run would have alone, to the last bit.  A lane with an event or a rare case is
marked, and its state is left unchanged for the kernels of single runs.
"""

from __future__ import annotations

from typing import Any

from frictionlab.hybrid.codegen.jet_codegen import (
    GUARD_TOL,
    LEFT,
    LENGTH,
    LOG_TOL,
    REGULAR,
    ModeTape,
    empty_function,
)
from frictionlab.hybrid.codegen.remainder_codegen import RemainderWriter, StepStructure
from frictionlab.hybrid.llvm_instructions import Values, write_exp2, write_log2, write_loop


def lane_step_module(function: ModeTape, structure: StepStructure, name: str) -> Any:
    """LLVM module with the function `name`(z, constants, terms, J, control, order).

    All arrays have the lanes as their last axis.  Row LEFT of `control` holds the longest step wanted;
    LENGTH and REGULAR (1 or 0) are written; `z` is advanced in regular lanes.
    """
    from llvmlite import ir

    body = empty_function(ir, 5, name)
    _StepWriter(ir, body, function, structure).write()
    return body.module


class _StepWriter(RemainderWriter):
    """Jets, length of the step, guards, and the state at the end."""

    def write(self) -> None:
        self.jets()
        h, fine = self._length()
        build = self.build
        left = self._load(self.control, LEFT)
        h = build.select(build.fcmp_ordered("<", left, h), left, h)
        for guard in self.guards:
            fine = build.and_(fine, self._resolved(guard, h))
        if self.degree > 1:
            h, fine = self._remainder_step(h, fine)
        for guard in self.guards:
            fine = build.and_(fine, build.fcmp_ordered(">", self._smallest(guard, h), self._number(0.0)))
        one, zero = self._number(1.0), self._number(0.0)
        self._store(h, self.control, LENGTH)
        self._store(build.select(fine, one, zero), self.control, REGULAR)
        for i, end in enumerate(self._ends(h)):
            self._store(build.select(fine, end, self._at(i, self.J)), self.z, i)
        build.ret_void()

    def _length(self) -> tuple[Any, Any]:
        """Length of the step, and whether it is regular."""
        build, best = self.build, self._number(float("inf"))
        fine = self._number(0.0)
        fine = build.fcmp_ordered("==", fine, fine)
        for first, last in zip(self.groups, self.groups[1:]):
            if last > first:
                best, fine = self._group_length(first, last, best, fine)
        return write_exp2(self.ir, build, best), fine

    def _group_length(self, first: int, last: int, best: Any, fine: Any) -> tuple[Any, Any]:
        build, ir, zero = self.build, self.ir, self._number(0.0)
        sizes = [self._largest(first, last, self.whole(m)) for m in range(3)]
        starts = [write_log2(ir, build, size) for size in sizes]
        log_tol = self._load(self.control, LOG_TOL)
        fine = build.and_(fine, build.fcmp_ordered("<", sizes[1], self._number(float("inf"))))
        some = build.fcmp_ordered(">", self._max(sizes[0], self._max(sizes[1], sizes[2])), zero)
        for p in (self._last_but_one(), self.order):
            end = self._largest(first, last, p)
            fine = build.and_(fine, build.fcmp_ordered("<", end, self._number(float("inf"))))
            room = build.fsub(log_tol, write_log2(ir, build, end))
            powers = [self._as_number(build.sub(p, self.whole(m))) for m in range(3)]
            each = [build.fdiv(build.fadd(room, start), power) for start, power in zip(starts, powers)]
            longest = self._max(each[0], self._max(each[1], each[2]))
            moves = build.fcmp_ordered(">", end, zero)
            fine = build.and_(fine, build.or_(some, build.not_(moves)))
            shorter = build.and_(moves, build.fcmp_ordered("<", longest, best))
            best = build.select(shorter, longest, best)
        return best, fine

    def _last_but_one(self) -> Any:
        return self.build.sub(self.order, self.whole(1))

    def _resolved(self, slot: int, h: Any) -> Any:
        """Whether the series of a guard holds for the whole step."""
        build, row = self.build, self._place(slot, self.J)

        def term(k: Any, carried: Values) -> Values:
            size, power = carried
            c = self._abs(self._load(self._ahead(row, k), 0))
            return [self._max(size, build.fmul(c, power)), build.fmul(power, h)]

        size, power = write_loop(build, self._last_but_one(), [self._number(0.0), self._number(1.0)], term)
        end = self._ahead(row, self.order)
        last = build.fmul(self._abs(self._load(end, 0)), h)
        last = self._max(self._abs(self._load(end, -1)), last)
        limit = build.fmul(self._load(self.control, GUARD_TOL), size)
        holds = build.fcmp_unordered("<=", build.fmul(last, power), limit)
        return build.or_(holds, build.fcmp_ordered("==", size, self._number(0.0)))

    def _smallest(self, slot: int, h: Any) -> Any:
        """Lower bound of a guard over the step."""
        build, row, zero = self.build, self._place(slot, self.J), self._number(0.0)

        def term(i: Any, carried: Values) -> Values:
            total, power = carried
            c, power = self._load(self._ahead(row, i), 1), build.fmul(power, h)
            falls = build.select(build.fcmp_ordered("<", c, zero), build.fmul(c, power), zero)
            return [build.fadd(total, falls), power]

        start = [self._load(row, 0), self._number(1.0)]
        return write_loop(build, self.order, start, term)[0]

    def _ends(self, h: Any) -> Values:
        """The states at the end of the step."""
        build, states = self.build, range(self.function.tape.inputs)

        def term(i: Any, totals: Values) -> Values:
            column = self._ahead(self.J, build.sub(self._last_but_one(), i))
            return [build.fadd(build.fmul(totals[s], h), self._at(s, column)) for s in states]

        last = self._ahead(self.J, self.order)
        return write_loop(build, self.order, [self._at(s, last) for s in states], term)
