"""What a Taylor series leaves out, bounded where its last terms do not tell.

The last terms of a series show how fast it converges, unless a function in it is tiny or saturated at the
expansion point and not elsewhere in the step: exp(-(u/v_s)^2) far from u = 0, tanh(u/v_s), a pole to come.
Cauchy's estimate covers these.  Where the states' polynomials keep a function within a distance M of its
first value on the complex disc |s| <= R, its coefficient k is at most M/R^k; so all terms from k on add up to
at most M (h/R)^k / (1 - h/R) within a step h < R.  M follows from one pass through the tape, in which every
operation says how far its result may go when its operands go so far.  Every radius R gives a bound; several
are tried, and the best is taken.  Sources: Jorba & Zou, Experimental Mathematics 14 (2005) 99-117, section 3,
for steps from Cauchy's estimate; Neher, Jackson & Nedialkov, SIAM J. Numer. Anal. 45 (2007) 236-262, for
remainders that are bounded by ranges.
"""

from __future__ import annotations

import math

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.arithmetic import exp2, log2
from frictionlab.hybrid.kernels.jets import has_series, majorant, series_range, term_slot, term_step
from frictionlab.hybrid.kernels.run_state import CLOCK_RESOLUTION, NOW
from frictionlab.hybrid.kernels.step_length import (
    FUNCTION_TOL_FACTOR,
    LAST_SIZE_TERM,
    LOG2_FUNCTION_TOL_FACTOR,
    is_cut_short,
    largest_coefficient,
    log2_step_from_later_terms,
    share_of_rounding,
)
from frictionlab.tape.elementary.exponentials import power
from frictionlab.tape.functions import AFFINE, POWER, PRODUCT, QUOTIENT, RATE, SQUARE, function_range
from frictionlab.tape.tape import Range

WHEN_BLIND, OPERATION, BOTH, SERIES = map(int, (Range.WHEN_BLIND, Range.OPERATION, Range.BOTH, Range.SERIES))
REACH, REST = 0, 1  # columns of bounds: how far a slot goes on the disc, and how far from its polynomial
FIRST_RADIUS = 3.0  # radius tried first, in steps: the one that most ordinary motions need
RADIUS_FACTOR = 0.75  # ratio of each radius to the one before
MIN_RADIUS_IN_STEPS = (
    1.1  # least radius, in steps: the terms left out then add up to at most eleven times their first
)
BOUND_EXCESS = (
    1.25  # factor by which a step may be longer: by this, bounds of ordinary motions exceed their remainders
)
LOG2_RADIUS_MARGIN = 0.4594316186372973  # log2(MIN_RADIUS_IN_STEPS BOUND_EXCESS)
# Share of a step that is taken without looking for a longer one, which costs as much as it would save.
SUFFICIENT_SHARE = 0.83
RADIUS_TRIES = 200  # most radii tried: RADIUS_FACTOR to this power is 1e-25
# The size of a series whose terms are all zero, some 1e-271: smaller than anything that matters.
LOG2_LEAST_SIZE = -900.0


@kernel
def power_range(exponent, base, d):
    """Bound of |z^p - a^p| for complex |z - a| <= d and a base a > 0, by the largest slope."""
    if not d < base:
        return math.inf
    steepest = max(power(base - d, exponent - 1.0), power(base + d, exponent - 1.0))
    return abs(exponent) * steepest * d


@inlined
def operation_range(code, numbers, op, out, order, d, e, J):
    """How far the result of a quotient, power or function goes if its operands go `d` and `e`.

    A power without a series counts as constant (:mod:`frictionlab.hybrid.kernels.power_onset`).
    """
    kind, a, b = code.ops[op, 0], code.ops[op, 1], code.ops[op, 2]
    if kind == QUOTIENT:
        least = abs(J[b, 0]) - e
        return (d + abs(J[out, 0]) * e) / least if least > 0.0 else math.inf
    if d == 0.0:
        return 0.0
    if kind == POWER:
        return power_range(numbers.constants[op], J[a, 0], d) if has_series(J, a, order, order) else 0.0
    return function_range(kind, J[a, 0], abs(J[out, 0]), abs(J[b, 0]), d)


@inlined
def bound_product(J, a, b, out, d, e, known, bounds):
    """Bounds of a product a b = a_0 b_0 + a_0 (b - b_0) + b_0 (a - a_0) + (a - a_0)(b - b_0).

    The operands go `d` and `e`.  The remainder of the two terms in the middle is that of an operand, times a
    constant.  The remainder of the last term is at most the term itself.  If the last terms of the series
    show the remainder of the result (`known`), it counts as zero here.
    """
    x, y = abs(J[a, 0]), abs(J[b, 0])
    bounds[out, REACH] = infinite_if_nan(x * e + y * d + d * e)
    bounds[out, REST] = 0.0 if known else infinite_if_nan(x * bounds[b, REST] + y * bounds[a, REST] + d * e)


@inlined
def infinite_if_nan(bound):
    """A bound; infinite where it is NaN, as 0 times infinity."""
    return bound if bound == bound else math.inf


@inlined
def bound_affine(code, magnitudes, op, out, order, radius, J, bounds):
    """Bounds of an affine combination of slots.  For BOTH its own series bounds it too: terms may cancel."""
    reach = rest = 0.0
    first = code.ops[op, 1]
    for j in range(first, code.ops[op, 2], term_step(code, first)):
        slot = term_slot(code, j)
        if magnitudes.terms[j] > 0.0:
            reach += magnitudes.terms[j] * bounds[slot, REACH]
            rest += magnitudes.terms[j] * bounds[slot, REST]
    if code.ranges[op] == BOTH and rest < math.inf:
        reach = min(reach, series_range(J, out, order, radius) + rest)
    bounds[out, REACH] = reach
    bounds[out, REST] = rest


@inlined
def bound_ranges(system, mode, order, radius, visible, J, bounds):
    """Write how far each slot goes on the disc of a radius, and how far it goes from its polynomial.

    `visible` says that the last terms show the remainders of polynomials.  These count as zero then.
    """
    code = system.code
    least = OPERATION if visible else WHEN_BLIND
    for i in range(code.inputs):
        bounds[i, REST] = 0.0
        if code.state_ranges[mode, i] >= least:
            bounds[i, REACH] = series_range(J, i, order, radius)
    first = code.mode_ops[mode]
    for op in range(first, code.mode_ops[mode + 1]):
        out = code.inputs + op - first
        if code.ranges[op] < least:
            bounds[out, REST] = 0.0
            continue
        if code.ranges[op] == SERIES:
            bounds[out, REACH], bounds[out, REST] = series_range(J, out, order, radius), 0.0
            continue
        kind, a, b = code.ops[op, 0], code.ops[op, 1], code.ops[op, 2]
        if kind == AFFINE:
            bound_affine(code, system.magnitudes, op, out, order, radius, J, bounds)
        elif kind == RATE:  # belongs to the recurrence of the next operation
            bounds[out, REACH] = bounds[out, REST] = 0.0
        else:
            d = bounds[a, REACH]
            e = bounds[b, REACH] if kind in (PRODUCT, QUOTIENT) else d
            known = visible and code.polynomial[op] != 0
            if kind in (PRODUCT, SQUARE):
                bound_product(J, a, b, out, d, e, known, bounds)
            else:
                reach = infinite_if_nan(operation_range(code, system.numbers, op, out, order, d, e, J))
                bounds[out, REACH] = reach
                bounds[out, REST] = 0.0 if known else reach


@inlined
def log2_longest_step(room, power, size0, size1, size2):
    """Binary logarithm of the longest h with h^power <= 2^room max(size_m h^m), m = 0, 1, 2."""
    best = max((room + log2(size0)) / power, (room + log2(size1)) / (power - 1))
    return max(best, (room + log2(size2)) / (power - 2))


@kernel
def log2_later_support(room, order, first, last, J):
    """As :func:`log2_longest_step` for slots [first, last) whose first three terms are zero.

    The first term that is not zero gives the size.  If all are zero, a slot may begin later than the series
    shows, as t^40 does.  Then the least size counts, so that the slot is followed from where it begins.
    """
    longest = log2_step_from_later_terms(room, order + 1, first, last, J)
    return longest if longest < math.inf else (room + LOG2_LEAST_SIZE) / (order + 1)


@kernel
def log2_group_support(room, order, first, last, J):
    """As :func:`log2_longest_step` for the states [first, last); -inf if all their terms are zero."""
    size0 = largest_coefficient(J, first, last, 0)
    size1 = largest_coefficient(J, first, last, 1)
    size2 = largest_coefficient(J, first, last, 2)
    if size0 > 0.0 or size1 > 0.0 or size2 > 0.0:
        return log2_longest_step(room, order + 1, size0, size1, size2)
    longest = log2_step_from_later_terms(room, order + 1, first, last, J)
    return longest if longest < math.inf else -math.inf


@kernel
def log2_zero_group_support(room, order, first, last, share, J, majorants):
    """As :func:`log2_group_support` for states whose terms are all zero.

    They may have cancelled.  So the states' size is a `share` of the majorants of the first three terms.
    """
    if share > 0.0:
        size0 = share * largest_coefficient(majorants, first, last, 0)
        size1 = share * largest_coefficient(majorants, first, last, 1)
        size2 = share * largest_coefficient(majorants, first, last, 2)
        if size0 > 0.0 or size1 > 0.0 or size2 > 0.0:
            return log2_longest_step(room, order + 1, size0, size1, size2)
    return log2_later_support(room, order, first, last, J)


@kernel
def are_zero(J, first, last, order):
    """Whether all terms of all slots [first, last) are zero."""
    for slot in range(first, last):
        for k in range(order + 1):
            if J[slot, k] != 0.0:
                return False
    return True


@inlined
def has_zero_guard(code, order, mode, J):
    """Whether a guard that is not affine in the states has terms that are all zero."""
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        if J[slot, 0] == 0.0 and code.guard_degrees[g] > 1 and are_zero(J, slot, slot + 1, order):
            return True
    return False


@inlined
def has_zero_series(code, order, mode, J):
    """Whether all terms of a guard, a section, an integral or a group of states are zero.

    Then the series does not show what the function does within the step.  Even a polynomial of low degree may
    be hidden so: x^9, if x begins as t^3.
    """
    if code.degrees[mode] <= 1:
        return False
    for section in range(code.sections.shape[1]):
        slot = code.sections[mode, section]
        if J[slot, 0] == 0.0 and are_zero(J, slot, slot + 1, order):
            return True
    for group in range(3 + code.inputs - code.groups[3]):
        first, last = group_bounds(code, group)
        if last > first and J[first, 0] == 0.0 and are_zero(J, first, last, order):
            return True
    return has_zero_guard(code, order, mode, J)


@inlined
def group_bounds(code, group):
    """States [first, last) whose errors are relative to the largest of them; each integral is a group."""
    if group < 3:
        return code.groups[group], code.groups[group + 1]
    return code.groups[3] + group - 3, code.groups[3] + group - 2


@inlined
def supported_step(code, truncation, mode, radius, rounds, shortest, scratch):
    """Longest step that the ranges on a disc support: the remainder of each slot is within its tolerance.

    Guards and sections ask for no less than the `shortest`.  `rounds` says whether their rounding errors
    count; the majorants in ``scratch.values`` bound these.
    """
    J, bounds = scratch.jets, scratch.bounds
    order, log_radius = truncation.order, log2(radius)
    log_room = log2(truncation.tol) + order * log_radius
    best = log_radius - LOG2_RADIUS_MARGIN
    share = share_of_rounding(truncation.tol) if rounds else 0.0
    least = log2(shortest) if shortest > 0.0 else -math.inf
    for group in range(3 + code.inputs - code.groups[3]):
        first, last = group_bounds(code, group)
        rest = 0.0
        for i in range(first, last):
            rest = max(rest, bounds[code.flow[mode, i], REST])
        if rest > 0.0:
            if rest == math.inf:
                return 0.0
            room = log_room + log2(order + 1.0) - log2(rest)
            longest = log2_group_support(room, order, first, last, J)
            if longest == -math.inf:
                majorants, of_group = scratch.values, FUNCTION_TOL_FACTOR * share
                longest = log2_zero_group_support(room, order, first, last, of_group, J, majorants)
                longest = max(least, longest)
            best = min(best, longest)
    log_room += LOG2_FUNCTION_TOL_FACTOR + log_radius
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        best = min(best, max(least, log2_function_support(slot, log_room, order, share, scratch)))
    for section in range(code.sections.shape[1]):
        slot = code.sections[mode, section]
        best = min(best, max(least, log2_function_support(slot, log_room, order, share, scratch)))
    return BOUND_EXCESS * exp2(best)


@kernel
def log2_function_support(slot, log_room, order, share, scratch):
    """Logarithm of the longest step that the range of a guard or section supports.

    Its size is at least a `share` of the majorants of its first three terms.  A function that is not finite
    at the start does not limit the step.
    """
    c, majorants, rest = scratch.jets[slot], scratch.values[slot], scratch.bounds[slot, REST]
    size0, size1, size2 = abs(c[0]), abs(c[1]), abs(c[2])
    if rest == 0.0 or not size0 + size1 + size2 < math.inf:
        return math.inf
    if rest == math.inf:
        return -math.inf
    if share > 0.0:
        size0 = max(size0, share * majorants[0])
        size1 = max(size1, share * majorants[1])
        size2 = max(size2, share * majorants[2])
    room = log_room - log2(rest)
    if size0 > 0.0 or size1 > 0.0 or size2 > 0.0:
        return log2_longest_step(room, order + 1, size0, size1, size2)
    return log2_later_support(room, order, slot, slot + 1, scratch.jets)


@inlined
def needs_remainder(code, order, mode, longest, left):
    """Whether the last two terms of the series may not tell how long a step may be.

    They tell for polynomials of a degree below `order`.  At a higher degree all terms may be zero.

    If the last terms of the states are zero, the states allow a step to the end of the run: the `longest` is
    all that is `left`.  Then the last terms tell for degrees up to 1 only.
    """
    degree = code.degrees[mode]
    return degree >= order or (degree > 1 and longest == left)


@inlined
def polynomials_visible(code, order, mode, longest, left):
    """Whether the last two terms show the remainders of polynomials."""
    return code.polynomial_degrees[mode] < order and longest < left


@kernel
def longest_supported_step(system, truncation, mode, h, visible, rounds, shortest, scratch):
    """Longest step up to `h` that the ranges on any disc support."""
    best, radius = 0.0, FIRST_RADIUS * h
    for _ in range(RADIUS_TRIES):
        bound_ranges(system, mode, truncation.order, radius, visible, scratch.jets, scratch.bounds)
        support = supported_step(system.code, truncation, mode, radius, rounds, shortest, scratch)
        if support >= SUFFICIENT_SHARE * h:
            return min(support, h)
        if support < best:
            break
        best = support
        radius *= RADIUS_FACTOR
    return best


@inlined
def remainder_step(system, truncation, mode, h, visible, hidden, run, scratch):
    """Longest step up to `h` whose remainder is bounded within the tolerances.

    `visible` says that the last terms of polynomials show their remainders.  Rounding errors of guards and
    sections count in two cases: if they may be the reason for a short step, as in `measured_function_step`,
    and if a series is zero (`hidden`).
    """
    code, magnitudes, least = system.code, system.magnitudes, CLOCK_RESOLUTION * run.times[NOW]
    shorter = 0.0
    if not hidden:
        shorter = longest_supported_step(system, truncation, mode, h, visible, False, 0.0, scratch)
    if is_cut_short(shorter, h) or shorter < least:
        majorant(code, magnitudes, mode, LAST_SIZE_TERM, run.state, scratch.jets, scratch.values)
        shorter = longest_supported_step(system, truncation, mode, h, visible, True, least, scratch)
    return shorter
