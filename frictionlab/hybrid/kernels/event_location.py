"""Event functions along a step: whether they stay positive, and the first that reaches zero.

A cheap lower bound dismisses most; otherwise the roots of the function's polynomial are isolated.
Coefficients below their rounding error, bounded by the majorant of the jets, count as zero.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON, majorant, mode_jets, polynomial_slope, states_at
from frictionlab.hybrid.kernels.roots import isolate_roots

COEFFICIENT_ROUNDING = 64 * MACHINE_EPSILON
GUARD_ROUNDING = 8 * MACHINE_EPSILON  # a guard below this share of its terms is at its zero
LOW_ORDER = 2  # orders that nearly always decide, examined first
SUSPECT_SHARE = (
    1e-9  # below this share of its terms, a leading coefficient is compared with its rounding error
)
NEWTON_STEPS = 12  # steps of Newton's method; one does where the tolerance is 1e-15
NO_GUARD = -1


class GuardZero(NamedTuple):
    """The first zero of a guard in a step."""

    time: float  # from the start of the step
    guard: int  # NO_GUARD where no guard is zero; the time is that of the step's end then
    multiplicity: int


@kernel
def leading_order(c, bound, declared, order, share):
    """First Taylor coefficient that is not zero; `order + 1` where all are.

    The first `declared` coefficients are zero by construction, others where they are below a share of their
    bounds: COEFFICIENT_ROUNDING where rounding explains them.
    """
    for k in range(declared, order + 1):
        if abs(c[k]) > share * bound[k]:
            return k
    return order + 1


@kernel
def leading_order_of_slot(system, mode, slot, declared, z, order, J, bounds):
    """:func:`leading_order` of a slot; computes as much of the majorant `bounds` as it needs."""
    code, magnitudes = system.code, system.magnitudes
    low = min(order, max(LOW_ORDER, declared))
    majorant(code, magnitudes, mode, low, z, J, bounds)
    k = leading_order(J[slot], bounds[slot], declared, low, COEFFICIENT_ROUNDING)
    if k > low and low < order:
        majorant(code, magnitudes, mode, order, z, J, bounds)
        k = leading_order(J[slot], bounds[slot], declared, order, COEFFICIENT_ROUNDING)
    return k


@kernel
def lower_bound(c, m, n, h):
    """Lower bound of c[m] + c[m+1] s + ... + c[n] s^(n-m) on [0, h]."""
    total = c[m]
    power = 1.0
    for k in range(m + 1, n + 1):
        power *= h
        if c[k] < 0.0:
            total += c[k] * power
    return total


@kernel
def absolute_sum(c, m, n, h):
    """Sum of the absolute terms of c[m] + c[m+1] s + ... at s = h."""
    total = 0.0
    power = 1.0
    for k in range(m, n + 1):
        total += abs(c[k]) * power
        power *= h
    return total


@kernel
def rescale(c, m, n, h, a):
    """Write the coefficients of c[m] + c[m+1] s + ... in s/h into `a`; return their number minus one."""
    power = 1.0
    for k in range(m, n + 1):
        a[k - m] = c[k] * power
        power *= h
    return n - m


@inlined
def first_event(system, mode, z, order, h, scratch):
    """First zero of the mode's guards in [0, h], along the jets in `scratch`.

    ``scratch.leading_zeros[g]`` leading coefficients of guard g count as zero at the start.
    """
    code, J, roots = system.code, scratch.jets, scratch.roots
    first = code.mode_guards[mode]
    hit = NO_GUARD
    order_of_hit = 1
    for g in range(first, code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        c = J[slot]
        m = scratch.leading_zeros[g - first]
        if m > order or lower_bound(c, m, order, h) > 0.0:
            continue
        if c[m] <= SUSPECT_SHARE * absolute_sum(c, m, order, h):
            m = leading_order_of_slot(system, mode, slot, m, z, order, J, scratch.bounds)
            if m > order:
                continue
            if c[m] < 0.0:
                return GuardZero(0.0, g, 1)
        n = rescale(c, m, order, h, roots.scaled)
        found = isolate_roots(n, 1, roots)
        # Of two at once the first in the mode's order.
        if found and (hit == NO_GUARD or roots.places[0] < 1.0):
            h *= roots.places[0]
            hit = g
            order_of_hit = roots.multiplicity[0]
    return GuardZero(h, hit, order_of_hit)


@inlined
def is_guard_truncated(code, guard, mode, order, s, J):
    """Whether a guard's polynomial may differ from the guard at `s`; that of an affine one does not."""
    if code.guard_degrees[guard] < 2 or s == 0.0:
        return False
    return code.degrees[mode] >= order or has_significant_tail(J[code.function_slots[guard]], order, s)


@inlined
def has_significant_tail(c, order, s):
    """Whether the last terms of a polynomial are above the rounding errors of its largest."""
    before = last = largest = 0.0
    power = 1.0
    for k in range(order + 1):
        before, last = last, abs(c[k]) * power
        largest = max(largest, last)
        power *= s
    return before + last > MACHINE_EPSILON * largest


@kernel
def refine_event_time(system, mode, guard, order, s, scratch):
    """Time of a guard's simple zero along the states' polynomials, near the zero `s` of its own.

    The guard's polynomial is truncated.  Where a run stops at its zero the guard itself is of the size of the
    tolerance, of either sign, and so is what vanishes with it: with mu_s = mu_k the acceleration after
    stick.  Newton's method makes it zero up to rounding.
    """
    code, z, values, bounds = system.code, scratch.states, scratch.values, scratch.bounds
    slot = code.function_slots[guard]
    time, best, least = s, s, math.inf
    for _ in range(NEWTON_STEPS):
        states_at(scratch.jets, order, time, z)
        mode_jets(code, system.numbers, mode, 0, z, values)
        value = abs(values[slot, 0])
        if value < least:
            best = time
        if not value < 0.5 * least:  # what is left is rounding, or Newton's method does not converge
            break
        majorant(code, system.magnitudes, mode, 0, z, values, bounds)
        if value <= GUARD_ROUNDING * bounds[slot, 0]:
            break
        least = value
        time -= values[slot, 0] / polynomial_slope(scratch.jets[slot], order, time)
        if not time >= 0.0:
            break
    return best
