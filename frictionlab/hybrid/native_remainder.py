"""Vector code that tells whether a step is short enough for what its series leave out.

A single run goes through some radii (:mod:`remainder`) and stops at the first if that supports the whole
step, as it mostly does.  Lanes look at that radius alone.  Their bounds are those of the single run or a
little more, so a step that they find supported is one that the single run takes too; all others are left to
its kernel.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

from frictionlab.hybrid.jets import AFFINE, POWER, PRODUCT, QUOTIENT, RATE, SQUARE
from frictionlab.hybrid.logarithms import exp2, log2
from frictionlab.hybrid.loops import Values, choose, repeat
from frictionlab.hybrid.native_ranges import RangeWriter
from frictionlab.hybrid.native_vectors import LEFT, TOL, WIDTH
from frictionlab.hybrid.powers import INSTANT
from frictionlab.hybrid.remainder import FIRST_RADIUS, MARGIN, ROOM
from frictionlab.hybrid.step_length import SLACK

TOGETHER = 8  # polynomials that are summed in one loop: their sums fit into the registers
ABOVE = 1.0 + 1e-9  # covers the rounding errors that differ from those of a single run, in an operand
SURE = 1.001  # the same in the length of a step


class Bound(NamedTuple):
    """How far a slot goes on the disc, and without its polynomial; None where it is of the first degree."""

    reach: Any
    rest: Any


class RemainderWriter(RangeWriter):
    """Writes the pass through the tape; `bounds` and `series` are what it knows of the slots."""

    bounds: dict[int, Bound]
    series: dict[int, Any]

    def _supported(self, h: Any, degree: int, groups: tuple[int, ...], guards: tuple[int, ...]) -> Any:
        """Whether steps `h` are supported, or need not be as their last terms tell (:func:`is_blind`)."""
        build, mask = self.build, self.ir.VectorType(self.ir.IntType(1), WIDTH)
        all_lanes = self.ir.Constant(mask, [1] * WIDTH)
        at_end = build.fcmp_ordered("==", h, self._load(self.control, LEFT))
        always = build.icmp_signed(">=", self.whole(degree), self.order)
        blind = build.select(always, all_lanes, at_end)
        lanes = self.ir.IntType(WIDTH)
        some = build.icmp_unsigned("!=", build.bitcast(blind, lanes), lanes(0))
        (result,) = choose(
            build,
            some,
            lambda: [build.or_(build.not_(blind), self._on_disc(h, groups, guards))],
            lambda: [all_lanes],
        )
        return result

    def _on_disc(self, h: Any, groups: tuple[int, ...], guards: tuple[int, ...]) -> Any:
        """Whether the ranges on the disc of the first radius support `h`."""
        build, ir, flow = self.build, self.ir, self.function.flow
        radius = build.fmul(self._number(FIRST_RADIUS), h)
        self._pass(radius, guards)
        log_radius = log2(ir, build, radius)
        room = build.fmul(self._as_number(self.order), log_radius)
        room = build.fadd(log2(ir, build, self._load(self.control, TOL)), room)
        best = build.fsub(log_radius, self._number(math.log2(ROOM * MARGIN)))
        room_of_rates = build.fadd(room, log2(ir, build, self._order_less(-1)))
        for first, last in pairwise(groups):
            rests = [rest for slot in flow[first:last] if (rest := self.bounds[slot].rest) is not None]
            if rests:
                best = self._shorter(best, room_of_rates, rests, self._sizes(first, last))
        room = build.fadd(room, build.fadd(self._number(math.log2(SLACK)), log_radius))
        for slot in guards:
            if self.bounds[slot].rest is not None:
                sizes = [self._abs(self._load(self._place(slot, self.J), m)) for m in range(3)]
                best = self._shorter(best, room, [self.bounds[slot].rest], sizes)
        longest = build.fmul(self._number(MARGIN), exp2(ir, build, best))
        return build.fcmp_ordered(">=", longest, build.fmul(self._number(SURE), h))

    def _sizes(self, first: int, last: int) -> Values:
        """Of the first three terms of a group of states, at an instant after the start at the least."""
        instant = self._number(INSTANT)
        start, rate, second = (self._largest(first, last, self.whole(m)) for m in range(3))
        moved = self._max(rate, self.build.fmul(second, instant))
        return [self._max(start, self.build.fmul(moved, instant)), rate, second]

    def _order_less(self, m: int) -> Any:
        """The order less `m`, as a number."""
        return self._as_number(self.build.sub(self.order, self.whole(m)))

    def _shorter(self, best: Any, room: Any, rests: Values, sizes: Values) -> Any:
        """Logarithm of the longest step, not above `best`, that suits what some slots leave out."""
        build, ir, zero = self.build, self.ir, self._number(0.0)
        rest = rests[0]
        for other in rests[1:]:
            rest = self._max(rest, other)
        room = build.fsub(room, log2(ir, build, rest))
        each = [
            build.fdiv(build.fadd(room, log2(ir, build, size)), self._order_less(m - 1))
            for m, size in enumerate(sizes)
        ]
        longest = self._max(self._max(each[0], each[1]), each[2])
        some = build.fcmp_ordered(">", self._max(self._max(sizes[0], sizes[1]), sizes[2]), zero)
        known = build.and_(some, build.fcmp_ordered("<", rest, self._number(math.inf)))
        longest = self._where(known, self._min(best, longest), -math.inf)
        return build.select(build.fcmp_ordered(">", rest, zero), longest, best)

    def _pass(self, radius: Any, guards: tuple[int, ...]) -> None:
        """The bounds of all slots that the states' rates and the guards depend on."""
        tape, needed = self.function.tape, {*self.function.flow, *guards}
        for i, op in reversed(list(enumerate(tape.ops))):
            if tape.inputs + i in needed:
                needed.update(self._sources(*op))
        operands = {
            s
            for i, op in enumerate(tape.ops)
            if tape.inputs + i in needed and op[0] != AFFINE
            for s in self._sources(*op)
        }
        self.series = self._on_radius(sorted(operands | {s for s in needed if s < tape.inputs}), radius)
        self.bounds = {s: Bound(self.series[s], None) for s in needed if s < tape.inputs}
        for i, op in enumerate(tape.ops):
            if tape.inputs + i in needed:
                self.bounds[tape.inputs + i] = self._bound(i, *op)

    def _sources(self, kind: int, a: int, b: int) -> list[int]:
        """Slots whose ranges an operation depends on."""
        if kind == AFFINE:
            return [slot for slot, _ in self.function.tape.terms[a:b]]
        if kind == RATE:  # belongs to the recurrence of the next operation
            return []
        return [a, b] if kind in (PRODUCT, SQUARE, QUOTIENT) else [a]

    def _on_radius(self, slots: list[int], radius: Any) -> dict[int, Any]:
        """How far the polynomials of slots go at the most."""
        build, totals = self.build, []
        for start in range(0, len(slots), TOGETHER):
            some = slots[start : start + TOGETHER]

            def term(i: Any, sums: Values, some: list[int] = some) -> Values:
                column = self._ahead(self.J, build.sub(self.order, i))
                sizes = [self._abs(self._at(slot, column)) for slot in some]
                return [build.fmul(build.fadd(s, size), radius) for s, size in zip(sums, sizes)]

            totals += repeat(build, self.order, [self._number(0.0)] * len(some), term)
        return dict(zip(slots, totals))

    def _bound(self, i: int, kind: int, a: int, b: int) -> Bound:
        """Of the slot that an operation writes."""
        if kind == AFFINE:
            return self._affine_bound(a, b)
        if kind == RATE:
            return Bound(self._number(0.0), None)
        if kind in (PRODUCT, SQUARE):
            return self._product_bound(a, b)
        reach = self._finite(self._operation_range(i, kind, a, b))
        return Bound(reach, reach)

    def _affine_bound(self, first: int, last: int) -> Bound:
        build, zero = self.build, self._number(0.0)
        reach, rest = zero, None
        for j in range(first, last):
            bound = self.bounds[self.function.tape.terms[j][0]]
            factor = self._abs(self._load(self.terms, self.function.first[1] + j))
            there = build.fcmp_ordered(">", factor, zero)
            reach = build.fadd(reach, self._where(there, build.fmul(factor, bound.reach), 0.0))
            if bound.rest is not None:
                more = self._where(there, build.fmul(factor, bound.rest), 0.0)
                rest = more if rest is None else build.fadd(rest, more)
        return Bound(reach, rest)

    def _product_bound(self, a: int, b: int) -> Bound:
        """As :func:`remainder.bound_product`."""
        build, d, e = self.build, self._range_of(a), self._range_of(b)
        x, y, both = self._size(a), self._size(b), build.fmul(d, e)
        reach = build.fadd(build.fadd(build.fmul(x, e), build.fmul(y, d)), both)
        rest = both
        for size, slot in (x, b), (y, a):
            if self.bounds[slot].rest is not None:
                rest = build.fadd(rest, build.fmul(size, self.bounds[slot].rest))
        return Bound(self._finite(reach), self._finite(rest))

    def _operation_range(self, i: int, kind: int, a: int, b: int) -> Any:
        """That of a quotient, power or function."""
        build, y, d = self.build, self._size(self.function.tape.inputs + i), self._range_of(a)
        if kind == QUOTIENT:
            e = self._range_of(b)
            return self._quotient_range(build.fadd(d, build.fmul(y, e)), build.fsub(self._size(b), e))
        at = self._at(a, self.J)
        if kind == POWER:
            return self._power_range(self._exponent(i), at, d)
        return self._function_range(kind, at, y, self._size(b), d)

    def _range_of(self, slot: int) -> Any:
        """How far an operand goes: by the operations, or by its own series, where terms of these cancel."""
        build, bound, series = self.build, self.bounds[slot], self.series[slot]
        if bound.rest is not None:
            series = build.fadd(series, bound.rest)
        return build.fmul(self._min(bound.reach, series), self._number(ABOVE))

    def _size(self, slot: int) -> Any:
        return self._abs(self._at(slot, self.J))

    def _finite(self, bound: Any) -> Any:
        """Infinite where it is no number, as 0 times infinity."""
        return self._where(self.build.fcmp_ordered("ord", bound, bound), bound, math.inf)
