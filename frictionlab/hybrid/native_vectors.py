"""Vector code for several runs side by side: every value has one number for each run (lane)."""

from __future__ import annotations

from typing import Any

from frictionlab.hybrid.arithmetic import PARTS
from frictionlab.hybrid.loops import Values, repeat
from frictionlab.hybrid.native import Function, Writer

WIDTH = 4
LEFT, LENGTH, FINE, TOL, LOG_TOL, GUARD_TOL = range(6)  # rows of `control`, all of WIDTH numbers
ROWS = 6


class LaneWriter(Writer):
    """The recurrences, and what else all lanes do at once."""

    width = WIDTH

    def __init__(self, ir: Any, body: Any, function: Function) -> None:
        super().__init__(ir, body, function)
        self.control = body.args[4]

    def _largest(self, first: int, last: int, k: Any) -> Any:
        """Largest coefficient k of the states [first, last); infinite where one is no number."""
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
            front, back = self._ahead(ahead, j), self._ahead(behind, self.build.neg(j))
            return [self._further(front, back, part, total) for part, total in enumerate(sums)]

        return repeat(self.build, count, [self._number(0.0)] * PARTS, group)

    def _call(self, name: str, *arguments: Any) -> Any:
        result = self._number(0.0)
        for lane in range(WIDTH):
            place = self.ir.IntType(32)(lane)
            each = super()._call(name, *(self.build.extract_element(vector, place) for vector in arguments))
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
        for lane in range(WIDTH):
            result = self.build.insert_element(result, value, self.ir.IntType(32)(lane))
        return result
