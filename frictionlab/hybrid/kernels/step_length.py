"""How long a Taylor step may be, from the last two terms of the series; and steps near the zero of a base.

A power has no Taylor series of full order if its base is zero, or nearly so.  The force penetration^1.5 of
two spheres is such a power, as their contact begins and ends.  Its coefficients grow like (rate/base)^k, or
like (curvature/base)^(k/2) if the rate is nearly zero too.  For a small base that is beyond the largest
number.  Then the series is cut at a lower order.  This is enough: so near to zero the power hardly affects
the motion.  At zero itself it counts as constant for a step.
"""

from __future__ import annotations

import math

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.arithmetic import PARTS, exp2, log2, log2_step_of_terms
from frictionlab.hybrid.kernels.jets import (
    MACHINE_EPSILON,
    has_series,
    majorant,
    mode_jets,
    series_range,
    states_at,
)
from frictionlab.hybrid.kernels.run_state import CLOCK_RESOLUTION, END, NOW
from frictionlab.tape.functions import POWER

# Factor by which the tolerance of a function of the states is wider than theirs: room for rounding.
FUNCTION_TOL_FACTOR, LOG2_FUNCTION_TOL_FACTOR = 64.0, 6.0
SERIES_TRIES = 200  # most lengths tried
BELOW_LIMIT = 0.999  # of the length that would do: the size falls with it, so it is approached from above
LAST_SIZE_TERM = 2  # the size of a function is that of its first three terms
# Share of a step; a function that asks for less may be all rounding error.
ROUNDING_SUSPECT_SHARE = 0.02


@kernel
def log2_of_tolerance(tol):
    """The logarithm by which steps are chosen, for callers that are not kernels."""
    return log2(tol)


@inlined
def largest_coefficient(J, first, last, k):
    """Largest Taylor coefficient number `k` of the states [first, last); infinite where one is NaN."""
    size = 0.0
    for i in range(first, last):
        c = abs(J[i, k])
        if not c <= size:
            size = c if c == c else math.inf
    return size


@kernel
def log2_step_from_later_terms(room, p, first, last, J):
    """Logarithm of the longest step, by the first non-zero term after three zeros; infinite for none."""
    for m in range(3, p):
        size = largest_coefficient(J, first, last, m)
        if size > 0.0:
            return (room + log2(size)) / (p - m)
    return math.inf


@inlined
def largest_coefficients(J, first, last, order):
    """The five largest coefficients by which a step is chosen: numbers 0, 1, 2, `order` - 1 and `order`.

    They are found together, without a branch for each, where all are finite, as nearly always.
    """
    size0 = size1 = size2 = before = end = total = 0.0
    for i in range(first, last):
        c0, c1, c2, c, d = abs(J[i, 0]), abs(J[i, 1]), abs(J[i, 2]), abs(J[i, order - 1]), abs(J[i, order])
        size0, size1, size2 = max(size0, c0), max(size1, c1), max(size2, c2)
        before, end = max(before, c), max(end, d)
        total += ((c0 + c1) + (c2 + c)) + d
    if not total < math.inf:
        size0, size1 = largest_coefficient(J, first, last, 0), largest_coefficient(J, first, last, 1)
        size2, before = largest_coefficient(J, first, last, 2), largest_coefficient(J, first, last, order - 1)
        end = largest_coefficient(J, first, last, order)
    return size0, size1, size2, before, end


@inlined
def log2_group_step(code, order, log_tol, first, last, J):
    """Binary logarithm of the longest step that suits the states [first, last); -inf where none does."""
    size0, size1, size2, before, end = largest_coefficients(J, first, last, order)
    # Rates may not be finite, though all later terms are zero.
    if not (size1 < math.inf and before < math.inf and end < math.inf):
        return -math.inf
    if size0 > 0.0 or size1 > 0.0 or size2 > 0.0:
        return log2_step_of_terms(log_tol, order, (size0, size1, size2), before, end)
    best = math.inf
    for p, size in ((order - 1, before), (order, end)):
        if size > 0.0:
            best = min(best, log2_step_from_later_terms(log_tol - log2(size), p, first, last, J))
    return best


@inlined
def step_length(code, order, tol, J):
    """Longest step for which the last two terms stay below `tol` times the size of their group of states.

    Jorba & Zou, Experimental Mathematics 14 (2005) 99-117, section 3.  The size of a group is the largest of
    its first three terms at the end of the step, so that no absolute tolerance is needed: a step h will do
    if, for one m of 0, 1, 2, |c_p| h^p <= tol |c_m| h^m; where those three are zero, for the next that is
    not.  Returns zero where a rate or one of the last two terms is not finite.
    """
    log_tol = log2(tol)
    best = math.inf
    for group in range(3):
        first, last = code.groups[group], code.groups[group + 1]
        if last > first:
            best = min(best, log2_group_step(code, order, log_tol, first, last, J))
    if best == -math.inf:
        return 0.0
    return exp2(best)


@inlined
def whole_power(h, n):
    """h^n for an integer n >= 0."""
    four = (h * h) * (h * h)
    power = 1.0
    for _ in range(n // PARTS):
        power *= four
    for _ in range(n % PARTS):
        power *= h
    return power


@inlined
def share_of_rounding(tol):
    """The share of a majorant that is the size of a function whose tolerance is its rounding error."""
    return MACHINE_EPSILON / (FUNCTION_TOL_FACTOR * tol)


@inlined
def size_of_rounding(tol, slot, h, majorants):
    """The size of a function whose tolerance is its rounding error, by its first three terms."""
    terms = majorants[slot, 0] + h * (majorants[slot, 1] + h * majorants[slot, 2])
    return share_of_rounding(tol) * terms


@kernel
def series_step(J, slot, truncation, h, rounds, majorants):
    """Longest step up to `h` in which the last two terms of a function's series stay below its tolerance.

    The tolerance is a share of the sum of all terms.  If the function `rounds`, the size is at least the one
    of :func:`size_of_rounding`.  If a function is not finite, the step is zero, but `h` if it `rounds`.
    """
    order, tol, longest = truncation.order, truncation.tol, h
    if not abs(J[slot, 0]) < math.inf:
        return longest if rounds else 0.0
    for _ in range(SERIES_TRIES):
        last = max(abs(J[slot, order - 1]), abs(J[slot, order]) * h) * whole_power(h, order - 1)
        if not last < math.inf:  # beyond the largest number, as h is long or a pole is near
            h *= 0.1
            continue
        if last <= FUNCTION_TOL_FACTOR * tol * (abs(J[slot, 0]) + abs(J[slot, 1]) * h):
            return h  # two terms of the sum are enough in nearly all steps, and far cheaper
        size = abs(J[slot, 0]) + series_range(J, slot, order, h)
        if rounds:
            size = max(size, size_of_rounding(tol, slot, h, majorants))
        most = FUNCTION_TOL_FACTOR * tol * size
        if size == 0.0 or not last > most:
            return h
        shorter = h * max(0.1, BELOW_LIMIT * exp2(log2(most / last) / (order - 1)))
        if shorter == h:
            return h
        h = shorter
    return longest


@inlined
def function_step(code, truncation, mode, h, rounds, J, majorants):
    """Longest step up to `h` in which the series of guards, sections and integrals are accurate too.

    The states' series do not show this: a guard x^5 needs a fifth of the step that x does.  `rounds` says
    whether the rounding errors of these functions count; the `majorants` of their series bound these.
    """
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        h = series_step(J, code.function_slots[g], truncation, h, rounds, majorants)
    for section in range(code.sections.shape[1]):
        h = series_step(J, code.sections[mode, section], truncation, h, rounds, majorants)
    for i in range(code.groups[3], code.inputs):
        h = series_step(J, i, truncation, h, rounds, majorants)
    return h


@inlined
def is_cut_short(shorter, h):
    """Whether a step is so much shorter than `h` that rounding errors of functions may be the reason."""
    return shorter < ROUNDING_SUSPECT_SHARE * h


@inlined
def measured_function_step(system, truncation, mode, h, run, scratch):
    """As :func:`function_step`; rounding errors count if they may be the reason for a short step.

    A pole is passed by a step that the clock can just resolve, even if the step starts at the pole.
    """
    code, J, majorants, least = system.code, scratch.jets, scratch.values, CLOCK_RESOLUTION * run.times[NOW]
    shorter = function_step(code, truncation, mode, h, False, J, majorants)
    if is_cut_short(shorter, h) or shorter < least:
        majorant(code, system.magnitudes, mode, LAST_SIZE_TERM, run.state, J, majorants)
        shorter = function_step(code, truncation, mode, h, True, J, majorants)
        shorter = min(h, max(shorter, least))
        instant = CLOCK_RESOLUTION * run.times[END]
        if shorter > instant and leaves_pole(system, truncation.order, mode, instant, scratch):
            shorter = instant
    return shorter


@kernel
def leaves_pole(system, order, mode, s, scratch):
    """Whether a guard, section or integrand is not finite at the start of a step, and is a time `s` later."""
    code, J, values = system.code, scratch.jets, scratch.values
    states_at(J, order, s, scratch.states)
    mode_jets(code, system.numbers, mode, 0, scratch.states, values)
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if becomes_finite(J, values, code.function_slots[g]):
            return True
    for section in range(code.sections.shape[1]):
        if becomes_finite(J, values, code.sections[mode, section]):
            return True
    leaves = False
    for i in range(code.groups[3], code.inputs):
        leaves = leaves or becomes_finite(J, values, code.flow[mode, i])
    return leaves


@inlined
def becomes_finite(before, after, slot):
    """Whether the value of a slot is finite only later."""
    return not abs(before[slot, 0]) < math.inf and abs(after[slot, 0]) < math.inf


# Share of the sum of a base's absolute terms: what is less negative may be rounding.
BASE_ROUNDING_SHARE = 1e-6
MISSED_EVENT_SHARE = 64.0  # rounding errors by which a function may be beyond zero at its event
MIN_USEFUL_ORDER = 4  # a series of a lower order is not worth while
LOG2_LARGEST_COEFFICIENT = 960.0  # near the 1e290 beyond which a power counts as without a series (jets)


@kernel
def lacks_series(code, order, mode, J):
    """Whether the base of a power is zero, or too near to it for a series."""
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER and not has_series(J, code.ops[i, 1], order, order):
            return True
    return False


@kernel
def has_base_near_zero(code, order, mode, now, J):
    """Whether the base of a power is zero, or comes to zero before the clock can be advanced."""
    return lacks_series(code, order, mode, J) or time_to_zero_base(code, mode, J) <= CLOCK_RESOLUTION * now


@kernel
def usable_order(code, order, mode, J):
    """Order up to which the coefficients of all powers are finite; 0 where a base is zero."""
    few = order
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            a = code.ops[i, 1]
            base, rate, curvature = J[a, 0], abs(J[a, 1]), abs(J[a, 2])
            if not base > 0.0:
                return 0
            if not has_series(J, a, order, order):
                growth = max(log2(rate) - log2(base), 0.5 * (log2(curvature) - log2(base)))
                few = min(few, int(LOG2_LARGEST_COEFFICIENT / growth))
    return few


@kernel
def keep_rates_unless_convergent(J, states, order, h):
    """Make the states' terms after the rates zero, unless the last ones show that the series converges.

    A negative power near its pole counts as a constant that is so large that later terms explode.
    """
    rate = largest_coefficient(J, 0, states, 1)
    if not largest_coefficient(J, 0, states, order) * whole_power(h, order - 1) <= rate:
        J[:, 2:] = 0.0


@kernel
def truncate_series_near_zero(code, numbers, mode, order, z, h, J):
    """Jets for a step `h` near the zero of a base; returns their order, 0 if powers count as constant.

    On entry `J` holds the jets of the full order, in which powers without a series count as constant.  If a
    lower order is used, the coefficients above it are made zero.
    """
    passes = h > time_to_zero_base(code, mode, J)  # the step goes beyond the zero of a base
    few = 1 if passes else usable_order(code, order, mode, J)
    if few < MIN_USEFUL_ORDER and lacks_series(code, order, mode, J):
        keep_rates_unless_convergent(J, z.shape[0], order, h)
        return 0
    if few < order or lacks_series(code, order, mode, J):
        mode_jets(code, numbers, mode, few, z, J)
        J[:, few + 1 :] = 0.0
    return few


@kernel
def time_to_zero_base(code, mode, J):
    """Time in which the first base of a power would come to zero at its rate, or by its curvature."""
    shortest = math.inf
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            base = J[code.ops[i, 1]]
            if base[1] != 0.0:
                shortest = min(shortest, abs(base[0] / base[1]))
            if base[2] != 0.0:
                shortest = min(shortest, math.sqrt(abs(base[0] / base[2])))
    return shortest


@kernel
def has_negative_base(system, mode, z, values, bounds):
    """Whether the base of a power is negative at a state by more than rounding: it has no real value."""
    code, negative, first = system.code, False, system.code.mode_ops[mode]
    mode_jets(code, system.numbers, mode, 0, z, values)
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER and values[code.ops[i, 1], 0] < 0.0:
            negative = True
    if not negative:
        return False
    majorant(code, system.magnitudes, mode, 0, z, values, bounds)
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            base, size = values[code.ops[i, 1], 0], bounds[code.ops[i, 1], 0]
            if base < 0.0 and not base > -BASE_ROUNDING_SHARE * size:
                return True
    return False


@kernel
def unresolved_time(code, magnitudes, mode, z, J, bounds):
    """Time in which bases that are zero up to rounding stay so; 0 if there is no such base.

    A base may be negative by as much as an event may be missed.  Then it is the time in which it reaches
    zero.
    """
    majorant(code, magnitudes, mode, 0, z, J, bounds)
    longest = math.inf
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            a = code.ops[i, 1]
            error, short = MACHINE_EPSILON * bounds[a, 0], -J[a, 0]
            if abs(short) <= error or 0.0 < short <= MISSED_EVENT_SHARE * error:
                error = max(error, short)
                longest = min(longest, error / abs(J[a, 1]), math.sqrt(error / abs(J[a, 2])))
    return longest if longest < math.inf else 0.0


# Share of the time since the last event: a stop that is so near comes at the end of one step.
STOP_SHARE = 3e-10
STOP_INSTANTS = 4  # what the clock resolves, in which a stop is reached at once
LEAST_TANGENCY = 0.5  # 4 b0 b2/b1^2 of the square of a norm, which is 1 where that has a double zero ahead
SHARE_OF_STOP = 0.75  # of the time to a stop: other steps are shorter, as the norm has no series at its zero
SHARE_OF_TURN = 0.25  # of the time in which v_r changes by as much as it is: a step of fixed steps near zero


@inlined
def base_of_root(code, numbers, mode, slot):
    """The slot whose square root a slot is; -1 if it is none."""
    op = code.mode_ops[mode] + slot - code.inputs
    if slot < code.inputs or code.ops[op, 0] != POWER or numbers.constants[op] != 0.5:
        return -1
    return code.ops[op, 1]


@inlined
def time_to_zero_norm(code, numbers, mode, slot, J):
    """Time in which a norm, the root of a sum of squares, comes to zero; infinite for another function.

    A norm touches zero and rises again.  So does its square, but not the base of another root.
    """
    a = base_of_root(code, numbers, mode, slot)
    if a < 0 or not J[a, 1] < 0.0:
        return math.inf
    time = -2.0 * J[a, 0] / J[a, 1]
    tangency = -2.0 * J[a, 2] * time / J[a, 1]
    return time if tangency > LEAST_TANGENCY else math.inf


@kernel
def first_stop(code, numbers, mode, J):
    """Time in which the first of a mode's guards that are norms comes to zero, and the guard; infinite for
    none."""
    first, guard = math.inf, code.mode_guards[mode]
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        time = time_to_zero_norm(code, numbers, mode, code.function_slots[g], J)
        if time < first:
            first, guard = time, g
    return first, guard


@kernel
def time_to_stop(code, numbers, mode, J):
    """Time in which the first of a mode's guards that are norms comes to zero; infinite for none."""
    return first_stop(code, numbers, mode, J)[0]


@inlined
def time_near_stop(now, since):
    """The time in which one step of constant accelerations leads to a stop, by every method: v_r that passes
    zero at a greater distance does not stop.

    It is a share of the time `since` the last event, or what the clock resolves.
    """
    return max(STOP_SHARE * since, STOP_INSTANTS * CLOCK_RESOLUTION * now)


@inlined
def step_of_turn(code, numbers, mode, h, J):
    """A step up to `h` in which the vectors of a mode's guards that are norms hardly change their directions:
    the law's force turns with them."""
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        a = base_of_root(code, numbers, mode, code.function_slots[g])
        if a >= 0 and 4.0 * J[a, 0] * J[a, 2] > LEAST_TANGENCY * J[a, 1] * J[a, 1]:
            h = min(h, SHARE_OF_TURN * math.sqrt(J[a, 0] / J[a, 2]))
    return h


@kernel
def truncate_series_at_stop(code, numbers, mode, J):
    """Make accelerations constant for the step to a stop, where the states have no series, and norms linear.

    The velocity may turn in the step by some angle.  What this leaves out of the way is this angle times that
    of the step, which is some 1e-17 of the way since the last event.
    """
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        time = time_to_zero_norm(code, numbers, mode, slot, J)
        if time < math.inf:
            J[slot, 1], J[slot, 2] = -J[slot, 0] / time, 0.0
    J[:, 3:] = 0.0
