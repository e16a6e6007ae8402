"""Ranges of functions on complex discs, as vector code.

The operations are those of :func:`remainder.function_range`, the library's functions for each lane by itself.
`d` is how far the argument goes from its value `a`; `y` and `slope` are the absolute values of the function
and its derivative there.
"""

from __future__ import annotations

import math
from typing import Any

from frictionlab.hybrid.jets import ATAN, EXP, LOG, SECH2, TAN, TANH
from frictionlab.hybrid.native_vectors import LaneWriter
from frictionlab.hybrid.remainder import FAR


class RangeWriter(LaneWriter):
    """Writes the ranges of functions, quotients and powers."""

    def _function_range(self, kind: int, a: Any, y: Any, slope: Any, d: Any) -> Any:
        if kind == EXP:
            return self._exp_range(a, y, d)
        if kind == LOG:
            return self._log_range(a, d)
        if kind == TANH:
            return self._min(self._tan_range(y, slope, d), self._saturated_range(a, d))
        if kind == SECH2:
            return self._sech2_range(a, y, slope, d)
        if kind == TAN:
            return self._tan_range(y, slope, d)
        return self._atan_range(a, d) if kind == ATAN else self._sine_range(y, slope, d)

    def _quotient_range(self, numerator: Any, least: Any) -> Any:
        """A quotient by no less than `least`, infinite where that is not above zero."""
        ratio = self.build.fdiv(numerator, least)
        return self._where(self.build.fcmp_ordered(">", least, self._number(0.0)), ratio, math.inf)

    def _exp_range(self, a: Any, y: Any, d: Any) -> Any:
        build = self.build
        near = build.fmul(y, self._call("expm1", d))
        far = self._call("exp", build.fadd(a, d))
        return build.select(build.fcmp_ordered("<", d, self._number(1.0)), near, far)

    def _log_range(self, a: Any, d: Any) -> Any:
        build = self.build
        reach = build.fneg(self._call("log1p", build.fdiv(build.fneg(d), a)))
        return self._where(build.fcmp_ordered("<", d, a), reach, math.inf)

    def _tan_range(self, y: Any, slope: Any, d: Any) -> Any:
        """From the addition theorem, for tan and tanh."""
        build, one = self.build, self._number(1.0)
        t = self._call("tan", d)
        grown = build.fmul(y, t)
        reach = build.fdiv(build.fmul(slope, t), build.fsub(one, grown))
        holds = build.and_(build.fcmp_ordered("<", d, self._number(1.5)), build.fcmp_ordered("<", grown, one))
        return self._where(holds, reach, math.inf)

    def _saturated_range(self, a: Any, d: Any) -> Any:
        """That of tanh(z) = 1 - 2 q/(1 + q), q = exp(-2 z), which is at most w."""
        build, size = self.build, self._abs(a)
        w = self._call("exp", build.fmul(self._number(2.0), build.fsub(d, size)))
        above = build.fmul(self._number(-2.0), w)
        above = build.fmul(above, self._call("expm1", build.fmul(self._number(-2.0), d)))
        below = build.fsub(self._number(1.0), w)
        return self._where(build.fcmp_ordered("<", d, size), build.fdiv(above, below), math.inf)

    def _sech2_range(self, a: Any, y: Any, slope: Any, d: Any) -> Any:
        return self._min(self._sech2_near(y, slope, d), self._sech2_far(a, d))

    def _sech2_near(self, y: Any, slope: Any, d: Any) -> Any:
        """From the addition theorem."""
        build, one, two = self.build, self._number(1.0), self._number(2.0)
        short = build.select(build.fcmp_ordered("<", two, d), two, d)
        half = self._call("sinh", build.fmul(self._number(0.5), short))
        share = build.fdiv(build.fmul(self._number(0.5), slope), y)
        share = build.select(build.fcmp_ordered("<", one, share), one, share)
        tanh = self._where(build.fcmp_ordered(">", y, self._number(0.0)), share, 1.0)
        g = build.fmul(build.fmul(two, half), half)
        g = build.fadd(g, build.fmul(tanh, self._call("sinh", short)))
        rest = build.fsub(one, g)
        reach = build.fmul(build.fmul(y, g), build.fsub(two, g))
        reach = build.fdiv(reach, build.fmul(rest, rest))
        return self._where(build.fcmp_ordered("<", g, one), reach, math.inf)

    def _sech2_far(self, a: Any, d: Any) -> Any:
        """By 4 q/(1 + q)^2, q = exp(-2 z)."""
        build, size = self.build, self._abs(a)
        w = self._call("exp", build.fmul(self._number(2.0), build.fsub(d, size)))
        rest = build.fsub(self._number(1.0), w)
        reach = build.fdiv(build.fmul(self._number(4.0), w), build.fmul(rest, rest))
        return self._where(build.fcmp_ordered("<", d, size), reach, math.inf)

    def _atan_range(self, a: Any, d: Any) -> Any:
        build = self.build
        room = self._intrinsic("sqrt", build.fadd(self._number(1.0), build.fmul(a, a)))
        room = build.fsub(room, d)
        away = build.fcmp_ordered(">", room, self._number(0.0))
        return self._where(away, build.fdiv(d, build.fmul(room, room)), math.inf)

    def _sine_range(self, y: Any, slope: Any, d: Any) -> Any:
        """That of sin, cos, sinh and cosh."""
        build = self.build
        half = self._call("sinh", build.fmul(self._number(0.5), d))
        even = build.fmul(build.fmul(build.fmul(self._number(2.0), y), half), half)
        reach = build.fadd(even, build.fmul(slope, self._call("sinh", d)))
        return self._where(build.fcmp_ordered("<", d, self._number(FAR)), reach, math.inf)

    def _power_range(self, exponent: Any, base: Any, d: Any) -> Any:
        build, less = self.build, self.build.fsub(exponent, self._number(1.0))
        near, far = (self._call("pow", end, less) for end in (build.fsub(base, d), build.fadd(base, d)))
        reach = build.fmul(build.fmul(self._abs(exponent), self._max(near, far)), d)
        return self._where(build.fcmp_ordered("<", d, base), reach, math.inf)
