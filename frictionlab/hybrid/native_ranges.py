"""Upper bounds of the ranges of functions on complex discs, for all lanes at once.

They are those of :func:`remainder.function_range` or a little more, so that they do without the library's
functions.  `d` is how far the argument goes from its value `a`; `y` and `slope` are the absolute values of
the function and its derivative there.
"""

from __future__ import annotations

import math
from typing import Any

from frictionlab.hybrid.jets import ATAN, EXP, LOG, TAN, TANH
from frictionlab.hybrid.logarithms import exp2
from frictionlab.hybrid.native_vectors import LaneWriter

OVERFLOW = 690.0  # beyond, the quick power of two is cut
QUICK = 1.0 + 1e-5  # covers the error of the quick power of two
# On [0, 1] these series divided by their first term, less 1, bend upwards: they are below their chords.
EXPM1, SINH, COSH = math.e - 2.0, math.sinh(1.0) - 1.0, math.cosh(1.0) - 1.0
TANGENT = 1.5  # below the first pole of tan


class RangeWriter(LaneWriter):
    """Writes the bounds of functions."""

    def _function_range(self, kind: int, a: Any, y: Any, slope: Any, d: Any) -> Any:
        if kind == EXP:
            return self._exp_range(a, y, d)
        if kind == LOG:  # -log(1 - d/a)
            return self._quotient_range(d, self.build.fsub(a, d))
        if kind == TANH:
            return self._min(self._tan_range(y, slope, d), self._saturated_range(a, d))
        if kind == TAN:
            return self._tan_range(y, slope, d)
        return self._atan_range(a, d) if kind == ATAN else self._sine_range(y, slope, d)

    def _quotient_range(self, numerator: Any, least: Any) -> Any:
        """A quotient by no less than `least`, infinite where that is not above zero."""
        ratio = self.build.fdiv(numerator, least)
        return self._where(self.build.fcmp_ordered(">", least, self._number(0.0)), ratio, math.inf)

    def _above_exp(self, x: Any) -> Any:
        power = exp2(self.ir, self.build, self.build.fmul(x, self._number(math.log2(math.e))))
        fits = self.build.fcmp_ordered("<", x, self._number(OVERFLOW))
        return self._where(fits, self.build.fmul(power, self._number(QUICK)), math.inf)

    def _chord(self, factor: float, x: Any) -> Any:
        """1 + `factor` x."""
        return self.build.fadd(self._number(1.0), self.build.fmul(self._number(factor), x))

    def _below_one(self, d: Any) -> Any:
        return self.build.fcmp_ordered("<", d, self._number(1.0))

    def _above_expm1(self, d: Any) -> Any:
        build = self.build
        near = build.fmul(d, self._chord(EXPM1, d))
        return build.select(self._below_one(d), near, build.fsub(self._above_exp(d), self._number(1.0)))

    def _exp_range(self, a: Any, y: Any, d: Any) -> Any:
        build = self.build
        near = build.fmul(build.fmul(y, d), self._chord(EXPM1, d))
        return build.select(self._below_one(d), near, self._above_exp(build.fadd(a, d)))

    def _tan_range(self, y: Any, slope: Any, d: Any) -> Any:
        """By tan(d) < pi^2 d/(pi^2 - 4 d^2) (Becker & Stark 1978) and the addition theorem."""
        build, pi2 = self.build, self._number(math.pi**2)
        four = build.fmul(self._number(4.0), build.fmul(d, d))
        t = build.fdiv(build.fmul(pi2, d), build.fsub(pi2, four))
        t = self._where(build.fcmp_ordered("<", d, self._number(TANGENT)), t, math.inf)
        return self._quotient_range(build.fmul(slope, t), build.fsub(self._number(1.0), build.fmul(y, t)))

    def _saturated_range(self, a: Any, d: Any) -> Any:
        """That of tanh(z) = 1 - 2 q/(1 + q), q = exp(-2 z), for |z - a| <= d < |a|."""
        build, two, size = self.build, self._number(2.0), self._abs(a)
        q, twice = self._above_exp(build.fmul(self._number(-2.0), size)), build.fmul(two, d)
        far = build.fmul(build.fmul(two, q), self._above_expm1(twice))
        least = build.fsub(self._number(1.0), build.fmul(q, self._above_exp(twice)))
        return self._where(build.fcmp_ordered("<", d, size), self._quotient_range(far, least), math.inf)

    def _atan_range(self, a: Any, d: Any) -> Any:
        """Its poles are at i and -i."""
        build = self.build
        room = self._intrinsic("sqrt", build.fadd(self._number(1.0), build.fmul(a, a)))
        room = build.fsub(room, d)
        away = build.fcmp_ordered(">", room, self._number(0.0))
        return self._where(away, build.fdiv(d, build.fmul(room, room)), math.inf)

    def _sine_range(self, y: Any, slope: Any, d: Any) -> Any:
        """That of sin, cos, sinh, cosh: y (cosh(d) - 1) + slope sinh(d)."""
        build, half, one = self.build, self._number(0.5), self._number(1.0)
        grown, square, near = self._above_exp(d), build.fmul(d, d), self._below_one(d)
        fallen = build.fdiv(one, grown)
        even = build.fsub(build.fmul(half, build.fadd(grown, fallen)), one)
        even = build.select(near, build.fmul(self._number(COSH), square), even)
        odd = build.fmul(half, build.fsub(grown, fallen))
        odd = build.select(near, build.fmul(d, self._chord(SINH, square)), odd)
        return build.fadd(build.fmul(y, even), build.fmul(slope, odd))

    def _power_range(self, exponent: Any, base: Any, d: Any) -> Any:
        """That of a power of a positive base, by the largest slope."""
        build, one = self.build, self._number(1.0)
        fits, less = build.fcmp_ordered("<", d, base), build.fsub(exponent, one)
        near = build.select(fits, build.fsub(base, d), one)
        steepest = self._max(self._call("pow", near, less), self._call("pow", build.fadd(base, d), less))
        reach = build.fmul(build.fmul(self._abs(exponent), steepest), d)
        return self._where(fits, reach, math.inf)
