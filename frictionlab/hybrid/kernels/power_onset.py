"""Steps in which powers count as constant, as their bases are zero or too near to it for a series.

How long such a step may be depends on how far the powers may go in it.  If a base is zero and goes as far as
d, its power goes as far as d^p.  One pass through the tape says how far every slot goes, and how far it goes
from its polynomial.  In these polynomials the powers are constant.  They keep their first rate only if
nothing but the curvature of the base is too large.

The value at the end of the step would not tell: u^0.9 exp(-u/v_s) has returned to zero there if the step is
long.
"""

from __future__ import annotations

import math

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.arithmetic import exp2, log2
from frictionlab.hybrid.kernels.jets import has_series, series_range, term_slot, term_step
from frictionlab.hybrid.kernels.remainder import REACH, REST, infinite_if_nan, operation_range, power_range
from frictionlab.hybrid.kernels.run_state import CLOCK_RESOLUTION, END
from frictionlab.hybrid.kernels.step_length import FUNCTION_TOL_FACTOR, largest_coefficient
from frictionlab.tape.elementary.exponentials import power
from frictionlab.tape.functions import AFFINE, POWER, PRODUCT, QUOTIENT, RATE, SQUARE

ONSET_TRIES = 100


@inlined
def multiple(factor, bound):
    """A multiple of a bound; zero if the bound is zero, even if the factor is infinite."""
    return factor * bound if bound > 0.0 else 0.0


@kernel
def bound_affine_onset(code, magnitudes, op, order, h, J, bounds):
    """Bounds of an affine combination: how far it goes in a step, and how far from its polynomial."""
    reach = rest = 0.0
    first = code.ops[op, 1]
    for j in range(first, code.ops[op, 2], term_step(code, first)):
        slot = term_slot(code, j)
        if magnitudes.terms[j] != 0.0:
            reach += multiple(magnitudes.terms[j], bounds[slot, REACH])
            rest += multiple(magnitudes.terms[j], bounds[slot, REST])
    return reach, rest


@inlined
def range_of_power(exponent, base, d):
    """How far a power goes if its base goes `d`.  The power is zero while the base is negative."""
    if d == 0.0:
        return 0.0
    if exponent > 0.0:
        return power(max(base + d, 0.0), exponent)
    return power_range(exponent, max(base, 0.0), d)


@kernel
def bound_operation_onset(system, op, out, order, h, J, bounds):
    """As :func:`bound_affine_onset`, for the other operations.

    The argument of a function stays on a disc of radius d.  By Cauchy's estimate the slope there is at most
    the range on the disc of twice the radius, divided by d.
    """
    code, numbers = system.code, system.numbers
    kind, a, b = code.ops[op, 0], code.ops[op, 1], code.ops[op, 2]
    d, rest = bounds[a, REACH], bounds[a, REST]
    if kind in (PRODUCT, SQUARE):
        x, y, e = abs(J[a, 0]), abs(J[b, 0]), bounds[b, REACH]
        reach = multiple(x, e) + multiple(y, d) + multiple(d, e)
        return reach, multiple(x + d, bounds[b, REST]) + multiple(y + e, rest)
    if kind == QUOTIENT:
        e = bounds[b, REACH]
        reach, least = operation_range(code, numbers, op, out, order, d, e, J), abs(J[b, 0]) - e
        rest += multiple(abs(J[out, 0]) + reach, bounds[b, REST])
        return reach, rest / least if least > 0.0 else math.inf
    if kind == POWER and not has_series(J, a, order, order):
        reach = range_of_power(numbers.constants[op], J[a, 0], d)
        return reach, reach + series_range(J, out, order, h)
    reach = operation_range(code, numbers, op, out, order, d, d, J)
    if rest > 0.0:
        twice = operation_range(code, numbers, op, out, order, 2.0 * d, d, J)
        rest = min(2.0 * reach, rest / d * twice)
    return reach, rest


@kernel
def bound_onset(system, mode, order, h, J, bounds):
    """Write how far each slot goes in a step, and how far from its polynomial with constant powers."""
    code, first = system.code, system.code.mode_ops[mode]
    for i in range(code.inputs):
        bounds[i, REACH], bounds[i, REST] = series_range(J, i, order, h), 0.0
    for op in range(first, code.mode_ops[mode + 1]):
        out = code.inputs + op - first
        reach = rest = 0.0
        if code.ops[op, 0] == AFFINE:
            reach, rest = bound_affine_onset(code, system.magnitudes, op, order, h, J, bounds)
            reach = min(reach, series_range(J, out, order, h) + rest)
        elif code.ops[op, 0] != RATE:
            reach, rest = bound_operation_onset(system, op, out, order, h, J, bounds)
        bounds[out, REACH], bounds[out, REST] = infinite_if_nan(reach), infinite_if_nan(rest)


@inlined
def share_of_size(error, size, h, instant):
    """An error as a share of the allowed `size`.  If that is zero, only an `instant` is allowed."""
    if error == 0.0 or (size == 0.0 and h <= instant):
        return 0.0
    return error / size if size > 0.0 else math.inf


@kernel
def share_of_onset(code, truncation, mode, h, instant, J, bounds):
    """Largest error of a step in which powers count as constant, as a share of the allowed error."""
    share, tol = 0.0, truncation.tol
    for group in range(4):
        first = code.groups[group]
        last = code.groups[group + 1] if group < 3 else code.inputs
        moved = largest_coefficient(J, first, last, 1) * max(h, instant)
        size = tol * max(largest_coefficient(J, first, last, 0), moved)
        for i in range(first, last):
            share = max(share, share_of_size(h * bounds[code.flow[mode, i], REST], size, h, instant))
    tol *= FUNCTION_TOL_FACTOR
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        size = tol * max(abs(J[slot, 0]), abs(J[slot, 1]) * h)
        share = max(share, share_of_size(bounds[slot, REST], size, h, instant))
    for section in range(code.sections.shape[1]):
        slot = code.sections[mode, section]
        size = tol * max(abs(J[slot, 0]), abs(J[slot, 1]) * h)
        share = max(share, share_of_size(bounds[slot, REST], size, h, instant))
    return share


@kernel
def onset_step(system, truncation, mode, h, run, scratch):
    """Longest step up to `h` in which powers whose base is nearly zero may count as constant.

    This leaves out a part of the rates.  The part changes no state by more than `tol` of its size, and no
    guard or section by more than its tolerance.
    """
    code, J, bounds = system.code, scratch.jets, scratch.bounds
    instant = CLOCK_RESOLUTION * run.times[END]
    for _ in range(ONSET_TRIES):
        bound_onset(system, mode, truncation.order, h, J, bounds)
        share = share_of_onset(code, truncation, mode, h, instant, J, bounds)
        if not share > 1.0:
            break
        h *= max(0.1, 0.9 * exp2(-0.4 * log2(share)))
    return h
