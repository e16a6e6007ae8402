"""Machine code of a whole step without an event, for several runs side by side.

Every value is a vector with one number for each run (lane).  The operations are those of one run, in the same
sequence (`jet_codegen`, :func:`step_length.step_length`, :func:`event_location.lower_bound_of_guard`), so the
numbers of a lane are those that the run would have alone, to the last bit.  A lane with an event or a rare
case is marked, and its state is left unchanged for the kernels of single runs.
"""

from __future__ import annotations

import math
from functools import reduce
from typing import Any

from frictionlab.compilation.llvm_instructions import (
    Values,
    write_branch,
    write_exp2,
    write_log2,
    write_loop,
)
from frictionlab.hybrid.codegen.jet_codegen import (
    CONTROL_ROWS,
    GUARD_TOL,
    LEFT,
    LENGTH,
    LOG_TOL,
    MEASURED,
    MOVE,
    REGULAR,
    SUITED,
    ModeTape,
    empty_function,
)
from frictionlab.hybrid.codegen.remainder_codegen import RemainderWriter, StepStructure
from frictionlab.hybrid.kernels.arithmetic import PARTS


def lane_step_module(function: ModeTape, structure: StepStructure, name: str) -> Any:
    """LLVM module with the function `name`(z, constants, terms, J, control, part, order).

    All arrays have the lanes as their last axis.  Row LEFT of `control` holds the longest step wanted.  The
    rows from CONTROL_ROWS on hold how many leading coefficients of each guard count as zero.

    The part MEASURE computes the jets `J` at `z`.  It writes the length of the step into row LENGTH, and 1 or
    0 into three others.  SUITED says whether this length suits the states.  MEASURED says whether it suits
    the guards too, so that it is the length of a step without an event.  REGULAR says whether besides no
    guard comes to zero in it.  After a regular step no leading coefficients count as zero.  In lanes that are
    measured but not regular, all coefficients of a guard that stays positive count as zero.

    The part MOVE advances `z` along the jets by row LENGTH, which may have been made shorter since.
    """
    from llvmlite import ir

    body = empty_function(ir, 5, 2, name)
    _StepWriter(ir, body, function, structure).write()
    return body.module


class _StepWriter(RemainderWriter):
    """Jets, length of the step, guards, and the state at the end."""

    def write(self) -> None:
        build, part = self.build, self.build.function.args[5]
        blocks = [build.append_basic_block() for _ in range(2)]
        build.cbranch(build.icmp_signed("==", part, self.whole(MOVE)), *blocks)
        for block, write_part in zip(blocks, (self._move, self._measure), strict=True):
            build.position_at_end(block)
            write_part()
            build.ret_void()

    def _move(self) -> None:
        """The states at the end of the step; those of a lane whose step has the length zero stay."""
        build, h = self.build, self._load(self.control, LENGTH)
        moves = build.fcmp_ordered(">", h, self._number(0.0))
        for i, change in self._changes(range(self.function.tape.inputs), h).items():
            start = self._at(i, self.J)
            self._store(build.select(moves, build.fadd(start, change), start), self.z, i)

    def _measure(self) -> None:
        self.jets()
        h, fine = self._length()
        build = self.build
        left = self._load(self.control, LEFT)
        h = build.select(build.fcmp_ordered("<", left, h), left, h)
        suited, longest, degrees = fine, h, self.function.tape.degrees()
        ranges = self._ranges(self.guards, h)
        for guard in self.guards:
            fine = build.and_(fine, self._resolved(guard, degrees[guard], h, ranges[guard]))
        if self.degree > 1:
            h, fine = self._remainder_step(h, fine)
        measured = fine
        positive = self._stay_positive(h, ranges if h is longest else self._ranges(self.guards, h))
        for each in positive:
            fine = build.and_(fine, each)
        one, zero = self._number(1.0), self._number(0.0)
        self._store(build.select(measured, h, longest), self.control, LENGTH)
        for row, lanes in (SUITED, suited), (MEASURED, measured), (REGULAR, fine):
            self._store(build.select(lanes, one, zero), self.control, row)
        for i, each in enumerate(positive):
            zeros = self._load(self.control, CONTROL_ROWS + i)
            passed = build.select(build.and_(measured, each), self._order_less(-1), zeros)
            self._store(build.select(fine, zero, passed), self.control, CONTROL_ROWS + i)

    def _length(self) -> tuple[Any, Any]:
        """Length of the step by the series of the states; and in which lanes this is no rare case."""
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
            fine = build.and_(fine, build.or_(some, build.not_(moves)) if self.degree <= 1 else some)
            shorter = build.and_(moves, build.fcmp_ordered("<", longest, best))
            best = build.select(shorter, longest, best)
        return best, fine

    def _last_but_one(self) -> Any:
        return self.build.sub(self.order, self.whole(1))

    def _resolved(self, slot: int, degree: float, h: Any, reach: Any) -> Any:
        """Whether the series of a guard holds for the whole step, in which it goes so far."""
        build, row = self.build, self._place(slot, self.J)
        size = build.fadd(self._abs(self._load(row, 0)), reach)
        end = self._ahead(row, self.order)
        last = build.fmul(self._abs(self._load(end, 0)), h)
        last = self._max(self._abs(self._load(end, -1)), last)
        limit = build.fmul(self._load(self.control, GUARD_TOL), size)
        last = build.fmul(last, self._whole_power(h, self._last_but_one()))
        holds = build.fcmp_ordered("<=", last, limit)
        if degree > 1:  # that all terms are zero tells nothing of the guard
            holds = build.and_(holds, build.fcmp_ordered(">", size, self._number(0.0)))
        else:
            holds = build.or_(holds, build.fcmp_ordered("==", size, self._number(0.0)))
        return build.and_(holds, build.fcmp_ordered("<", last, self._number(math.inf)))

    def _whole_power(self, h: Any, n: Any) -> Any:
        """As :func:`step_length.whole_power`."""
        build, square = self.build, self.build.fmul(h, h)
        four = build.fmul(square, square)
        fours, rest = build.ashr(n, self.whole(2)), build.and_(n, self.whole(PARTS - 1))
        power = [self._number(1.0)]
        power = write_loop(build, fours, power, lambda i, carried: [build.fmul(carried[0], four)])
        return write_loop(build, rest, power, lambda i, carried: [build.fmul(carried[0], h)])[0]

    def _stay_positive(self, h: Any, ranges: dict[int, Any]) -> Values:
        """Whether each guard is positive throughout the step, without the coefficients that count as zero."""
        build, none = self.build, self._number(0.0)
        changes = self._changes(self.guards, h)
        bounds = [self._smallest(slot, ranges[slot], changes[slot]) for slot in self.guards]
        zeros = [self._load(self.control, CONTROL_ROWS + i) for i in range(len(bounds))]
        begins = [build.fcmp_ordered(">", each, none) for each in zeros]
        if bounds:
            some = reduce(build.or_, begins)
            bounds = write_branch(
                build,
                self._any(some),
                lambda: list(map(build.select, begins, self._smallest_beyond(zeros, h), bounds)),
                lambda: bounds,
            )
        return [build.fcmp_ordered(">", bound, none) for bound in bounds]

    def _smallest_beyond(self, zeros: Values, h: Any) -> Values:
        """As :func:`event_location.lower_bound`; infinite where all coefficients of a guard count as zero."""
        build, rows = self.build, [self._place(slot, self.J) for slot in self.guards]

        def term(k: Any, carried: Values) -> Values:
            number, column, results = self._as_number(k), self.build.mul(k, self.whole(self.width)), []
            for each, row, total, power in zip(zeros, rows, carried[::2], carried[1::2], strict=True):
                c = self._load(build.gep(row, [column]), 0)
                leads, follows = (build.fcmp_ordered(sign, number, each) for sign in ("==", ">"))
                power = build.select(follows, build.fmul(power, h), power)
                falls = build.and_(follows, build.fcmp_ordered("<", c, self._number(0.0)))
                total = build.select(falls, build.fadd(total, build.fmul(c, power)), total)
                results += [build.select(leads, c, total), power]
            return results

        start = [self._number(math.inf), self._number(1.0)] * len(zeros)
        return write_loop(build, build.add(self.order, self.whole(1)), start, term)[::2]

    def _smallest(self, slot: int, reach: Any, change: Any) -> Any:
        """Lower bound of a guard over the step."""
        falls = self.build.fsub(reach, change)
        return self.build.fsub(self._at(slot, self.J), self.build.fmul(self._number(0.5), falls))
