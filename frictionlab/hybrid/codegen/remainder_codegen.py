"""Vector code for the longest steps whose remainders are bounded, and for ranges of functions on complex
discs.

This is :mod:`frictionlab.hybrid.kernels.remainder` for all lanes.  The operations are those of a single run
in the same sequence, except that zeros are not added; the kernels of functions are called for each lane
separately.  Radii are tried until every lane has its step.  In the ranges `d` is how far the argument goes
from its value `a`; `y` and `slope` are the absolute values of the function and its derivative there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any, NamedTuple

from frictionlab.compilation.llvm_instructions import (
    Values,
    write_exp2,
    write_log2,
    write_loop,
    write_while_loop,
)
from frictionlab.hybrid.codegen.jet_codegen import (
    LEFT,
    POWER_SYMBOL,
    RANGE_SYMBOL,
    TOL,
    LaneWriter,
    ModeTape,
)
from frictionlab.hybrid.kernels.arithmetic import PARTS
from frictionlab.hybrid.kernels.remainder import (
    BOUND_EXCESS,
    FIRST_RADIUS,
    LOG2_RADIUS_MARGIN,
    RADIUS_FACTOR,
    RADIUS_TRIES,
    SUFFICIENT_SHARE,
)
from frictionlab.hybrid.kernels.step_length import (
    LOG2_FUNCTION_TOL_FACTOR,
    ROUNDING_SUSPECT_SHARE,
)
from frictionlab.tape.functions import AFFINE, POWER, PRODUCT, QUOTIENT, RATE, SQUARE
from frictionlab.tape.program import NOT_POLYNOMIAL
from frictionlab.tape.tape import Range

POLYNOMIALS_PER_LOOP = 2  # polynomials that are summed in one loop: their sums fit into the registers


class RangeWriter(LaneWriter):
    """Writes the ranges of functions, quotients and powers."""

    def _function_range(self, kind: int, a: Any, y: Any, slope: Any, d: Any) -> Any:
        """Range of a function, by its kernel, for each lane."""
        return self._call(RANGE_SYMBOL, self.whole(kind), a, y, slope, d)

    def _quotient_range(self, numerator: Any, least: Any) -> Any:
        """Bound of a quotient whose denominator is `least` or more; infinite where that is not above zero."""
        ratio = self.build.fdiv(numerator, least)
        return self._where(self.build.fcmp_ordered(">", least, self._number(0.0)), ratio, math.inf)

    def _power_range(self, exponent: Any, base: Any, d: Any) -> Any:
        build, less = self.build, self.build.fsub(exponent, self._number(1.0))
        near, far = (
            self._call(POWER_SYMBOL, end, less) for end in (build.fsub(base, d), build.fadd(base, d))
        )
        reach = build.fmul(build.fmul(self._abs(exponent), self._max(near, far)), d)
        return self._where(build.fcmp_ordered("<", d, base), reach, math.inf)


class StepStructure(NamedTuple):
    """What the length of a mode's steps depends on besides its operations."""

    guards: tuple[int, ...]  # their slots
    groups: tuple[int, ...]  # bounds of the coordinates, the velocities, the other states
    degree: int  # the highest, NOT_POLYNOMIAL if there are functions that are no polynomials
    polynomial_degree: int  # the highest among the polynomials


class RangeBound(NamedTuple):
    """Range of a slot on the disc, and of its remainder; None where it is not needed or zero."""

    reach: Any
    rest: Any


class RemainderWriter(RangeWriter):
    """Writes the passes through the tape.

    `bounds` holds the bounds of the slots so far, `series` the ranges that follow from their own series.
    """

    bounds: dict[int, RangeBound]
    series: dict[int, Any]

    def __init__(self, ir: Any, body: Any, function: ModeTape, structure: StepStructure) -> None:
        super().__init__(ir, body, function)
        self.guards, self.groups, self.degree, self.polynomial_degree = structure

    def _remainder_step(self, h: Any, fine: Any) -> tuple[Any, Any]:
        """Longest step up to `h` with a bounded remainder; and where it is `fine` and no rare case."""
        build, zero = self.build, self._number(0.0)
        blind, hidden = self._blind(h)
        fine = build.and_(fine, build.not_(hidden))
        if self.degree < NOT_POLYNOMIAL:  # all are polynomials: `blind` and `hidden` agree
            return h, fine
        blind = build.and_(blind, fine)

        def attempt(carried: Values) -> tuple[Values, Any]:
            best, radius, active, usual, tries = carried
            support, known = self._support(radius)
            enough = build.fcmp_ordered(">=", support, build.fmul(self._number(SUFFICIENT_SHARE), h))
            better = build.not_(build.fcmp_ordered("<", support, best))
            found = build.select(enough, self._min(support, h), build.select(better, support, best))
            best = build.select(active, found, best)
            usual = build.and_(usual, build.or_(build.not_(active), known))
            active = build.and_(build.and_(active, usual), build.and_(better, build.not_(enough)))
            radius, tries = build.fmul(radius, self._number(RADIUS_FACTOR)), build.add(tries, self.whole(1))
            goes_on = build.and_(self._any(active), build.icmp_signed("<", tries, self.whole(RADIUS_TRIES)))
            return [best, radius, active, usual, tries], goes_on

        start = [zero, build.fmul(self._number(FIRST_RADIUS), h), blind, self._all(), self.whole(0)]
        best, _, _, usual, _ = write_while_loop(build, self._any(blind), start, attempt)
        suspect = build.fmul(self._number(ROUNDING_SUSPECT_SHARE), h)
        usual = build.and_(usual, build.or_(build.not_(blind), build.fcmp_ordered(">=", best, suspect)))
        h = build.select(blind, best, h)
        return h, build.and_(fine, build.and_(usual, build.fcmp_ordered(">", h, zero)))

    def _blind(self, h: Any) -> tuple[Any, Any]:
        """The lanes that need a bound of the remainder, and those of them whose polynomials are not visible.

        See :func:`remainder.needs_remainder` and :func:`remainder.polynomials_visible`.
        """
        build = self.build
        at_end = build.fcmp_ordered("==", h, self._load(self.control, LEFT))
        blind = build.select(self._reaches_order(self.degree), self._all(), at_end)
        hidden = build.select(self._reaches_order(self.polynomial_degree), self._all(), at_end)
        return blind, build.and_(blind, hidden)

    def _reaches_order(self, degree: int) -> Any:
        return self.build.icmp_signed(">=", self.whole(degree), self.order)

    def _all(self) -> Any:
        return self.ir.Constant(self.ir.VectorType(self.ir.IntType(1), self.width), [1] * self.width)

    def _any(self, lanes: Any) -> Any:
        bits = self.build.bitcast(lanes, self.ir.IntType(self.width))
        return self.build.icmp_unsigned("!=", bits, bits.type(0))

    def _support(self, radius: Any) -> tuple[Any, Any]:
        """As :func:`remainder.supported_step`; and in which lanes the first three terms told all sizes."""
        build, ir, known = self.build, self.ir, self._all()
        self._bound_ranges(radius)
        log_radius = write_log2(ir, build, radius)
        room = build.fmul(self._as_number(self.order), log_radius)
        room = build.fadd(write_log2(ir, build, self._load(self.control, TOL)), room)
        best = build.fsub(log_radius, self._number(LOG2_RADIUS_MARGIN))
        room_of_rates = build.fadd(room, write_log2(ir, build, self._order_less(-1)))
        bounded = self._all()
        for first, last in pairwise(self.groups):
            rest = self._largest_rest(self.function.flow[first:last])
            if rest is not None:
                sizes = self._sizes(first, last)
                longest = self._longest(build.fsub(room_of_rates, write_log2(ir, build, rest)), sizes)
                leaves = build.fcmp_ordered(">", rest, self._number(0.0))
                best = build.select(leaves, self._min(best, longest), best)
                known = build.and_(known, build.or_(build.not_(leaves), self._some(sizes)))
                bounded = build.and_(bounded, build.fcmp_ordered("<", rest, self._number(math.inf)))
        room = build.fadd(room, build.fadd(self._number(LOG2_FUNCTION_TOL_FACTOR), log_radius))
        for slot in self.guards:
            if self.bounds[slot].rest is not None:
                support, usual = self._guard_support(slot, room)
                best, known = self._min(best, support), build.and_(known, usual)
        longest = build.fmul(self._number(BOUND_EXCESS), write_exp2(ir, build, best))
        return self._where(bounded, longest, 0.0), known

    def _largest_rest(self, slots: tuple[int, ...]) -> Any:
        """The largest remainder of some slots; None if no slot has one."""
        largest = None
        for slot in slots:
            rest = self.bounds[slot].rest
            if rest is not None:
                largest = rest if largest is None else self._max(largest, rest)
        return largest

    def _sizes(self, first: int, last: int) -> Values:
        """Sizes of a group's first three terms."""
        return [self._largest(first, last, self.whole(m)) for m in range(3)]

    def _some(self, sizes: Values) -> Any:
        largest = self._max(self._max(sizes[0], sizes[1]), sizes[2])
        return self.build.fcmp_ordered(">", largest, self._number(0.0))

    def _guard_support(self, slot: int, room: Any) -> tuple[Any, Any]:
        """As :func:`remainder.log2_function_support`; and where the first three terms tell the size."""
        build, rest = self.build, self.bounds[slot].rest
        row = self._place(slot, self.J)
        sizes = [self._abs(self._load(row, m)) for m in range(3)]
        total = build.fadd(build.fadd(sizes[0], sizes[1]), sizes[2])
        leaves = build.fcmp_ordered(">", rest, self._number(0.0))
        told = build.and_(self._some(sizes), build.fcmp_ordered("<", total, self._number(math.inf)))
        longest = self._longest(build.fsub(room, write_log2(self.ir, build, rest)), sizes)
        longest = self._where(build.fcmp_ordered("<", rest, self._number(math.inf)), longest, -math.inf)
        return self._where(leaves, longest, math.inf), build.or_(build.not_(leaves), told)

    def _longest(self, room: Any, sizes: Values) -> Any:
        """As :func:`remainder.log2_longest_step`."""
        build = self.build
        rooms = [build.fadd(room, write_log2(self.ir, build, size)) for size in sizes]
        each = [build.fdiv(total, self._order_less(m - 1)) for m, total in enumerate(rooms)]
        return self._max(self._max(each[0], each[1]), each[2])

    def _order_less(self, m: int) -> Any:
        """The order less `m`, as a number."""
        return self._as_number(self.build.sub(self.order, self.whole(m)))

    def _bound_ranges(self, radius: Any) -> None:
        """Bounds of the slots on which those rates and guards depend that are no polynomials."""
        tape = self.function.tape
        ranges = tape.ranges((*self.function.flow, *self.guards), tape.degrees())
        measured = [slot for slot, kind in enumerate(ranges) if kind in (Range.SERIES, Range.BOTH)]
        self.series = self._ranges(measured, radius)
        polynomial = [degree < math.inf for degree in tape.degrees()]
        self.bounds = dict.fromkeys(range(tape.slots), RangeBound(None, None))
        for slot, kind in enumerate(ranges):
            if kind is Range.SERIES:
                self.bounds[slot] = RangeBound(self.series[slot], None)
            elif kind >= Range.OPERATION:
                bound = self._bound(slot - tape.inputs, *tape.ops[slot - tape.inputs])
                self.bounds[slot] = RangeBound(bound.reach, None) if polynomial[slot] else bound

    def _ranges(self, slots: Iterable[int], radius: Any) -> dict[int, Any]:
        """Bounds of how far the polynomials of slots go, as :func:`jets.series_range`."""
        return self._series(list(slots), radius, self._abs)

    def _changes(self, slots: Iterable[int], s: Any) -> dict[int, Any]:
        """Change of slots in a time, as :func:`jets.series_change`."""
        return self._series(list(slots), s, lambda coefficient: coefficient)

    def _series(self, slots: list[int], radius: Any, of: Callable[[Any], Any]) -> dict[int, Any]:
        """Polynomials of slots without their first terms, where `of` is applied to each coefficient."""
        build, square, parts = self.build, self.build.fmul(radius, radius), range(PARTS)
        four, two = build.fmul(square, square), self.whole(2)
        groups, rest = build.ashr(self.order, two), build.and_(self.order, self.whole(PARTS - 1))
        totals: dict[int, Any] = {}
        for start in range(0, len(slots), POLYNOMIALS_PER_LOOP):
            some = slots[start : start + POLYNOMIALS_PER_LOOP]

            def size(slot: int, k: Any) -> Any:
                return of(self._load(self._ahead(self._place(slot, self.J), k), 0))

            def term(i: Any, sums: Values, some: list[int] = some) -> Values:
                k = build.sub(self.order, i)
                return [build.fadd(build.fmul(s, radius), size(slot, k)) for slot, s in zip(some, sums)]

            def group(i: Any, sums: Values, some: list[int] = some) -> Values:
                before = build.shl(build.sub(build.sub(groups, i), self.whole(1)), two)
                columns = [build.add(before, self.whole(1 + part)) for part in parts]
                sizes = (size(slot, column) for slot in some for column in columns)
                return [build.fadd(build.fmul(s, four), each) for s, each in zip(sums, sizes)]

            zeros = [self._number(0.0)] * (PARTS - 1)
            lasts = write_loop(build, rest, [self._number(0.0)] * len(some), term)
            sums = write_loop(build, groups, [each for last in lasts for each in (last, *zeros)], group)
            for j, slot in enumerate(some):
                *lower, total = sums[PARTS * j : PARTS * (j + 1)]
                for each in reversed(lower):
                    total = build.fadd(each, build.fmul(radius, total))
                totals[slot] = build.fmul(total, radius)
        return totals

    def _bound(self, i: int, kind: int, a: int, b: int) -> RangeBound:
        """Bound of the slot that an operation writes."""
        if kind == AFFINE:
            return self._affine_bound(self.function.tape.inputs + i, a, b)
        if kind == RATE:
            return RangeBound(self._number(0.0), None)
        if kind in (PRODUCT, SQUARE):
            return self._product_bound(a, b)
        reach = self._finite(self._operation_range(i, kind, a, b))
        return RangeBound(reach, reach)

    def _affine_bound(self, out: int, first: int, last: int) -> RangeBound:
        """As :func:`remainder.bound_affine`."""
        build, zero = self.build, self._number(0.0)
        reach, rest = zero, None
        for j in range(first, last):
            bound = self.bounds[self.function.tape.terms[j][0]]
            factor = self._abs(self._load(self.terms, self.function.first[1] + j))
            there = build.fcmp_ordered(">", factor, zero)
            if bound.reach is not None:
                reach = build.fadd(reach, self._where(there, build.fmul(factor, bound.reach), 0.0))
            if bound.rest is not None:
                more = self._where(there, build.fmul(factor, bound.rest), 0.0)
                rest = more if rest is None else build.fadd(rest, more)
        if out in self.series:
            series = self.series[out] if rest is None else build.fadd(self.series[out], rest)
            shorter = self._min(reach, series)
            known = zero if rest is None else rest
            reach = build.select(build.fcmp_ordered("<", known, self._number(math.inf)), shorter, reach)
        return RangeBound(reach, rest)

    def _product_bound(self, a: int, b: int) -> RangeBound:
        """As :func:`remainder.bound_product`."""
        build, d, e = self.build, self.bounds[a].reach, self.bounds[b].reach
        x, y, both = self._size(a), self._size(b), build.fmul(d, e)
        reach = build.fadd(build.fadd(build.fmul(x, e), build.fmul(y, d)), both)
        rest = self._number(0.0)
        for size, slot in (x, b), (y, a):
            if self.bounds[slot].rest is not None:
                rest = build.fadd(rest, build.fmul(size, self.bounds[slot].rest))
        return RangeBound(self._finite(reach), self._finite(build.fadd(rest, both)))

    def _operation_range(self, i: int, kind: int, a: int, b: int) -> Any:
        """As :func:`remainder.operation_range`."""
        build, y, d = self.build, self._size(self.function.tape.inputs + i), self.bounds[a].reach
        if kind == QUOTIENT:
            e = self.bounds[b].reach
            return self._quotient_range(build.fadd(d, build.fmul(y, e)), build.fsub(self._size(b), e))
        at, zero = self._at(a, self.J), self._number(0.0)
        if kind == POWER:
            reach = self._power_range(self._exponent(i), at, d)
        else:
            reach = self._function_range(kind, at, y, self._size(b), d)
        return build.select(build.fcmp_ordered("==", d, zero), zero, reach)

    def _size(self, slot: int) -> Any:
        return self._abs(self._at(slot, self.J))

    def _finite(self, bound: Any) -> Any:
        """A bound; infinite where it is not a number, as 0 times infinity."""
        return self._where(self.build.fcmp_ordered("ord", bound, bound), bound, math.inf)
