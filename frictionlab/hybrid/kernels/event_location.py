"""Event functions along a step: whether they stay positive, and the first that reaches zero.

A cheap lower bound shows that most stay positive.  For the others the roots of the function's polynomial on
[0, 1] are isolated in order, and none is missed.  Coefficients below their rounding error, bounded by the
majorant of the jets, count as zero.  In Bernstein form the number of sign changes of the coefficients bounds
the number of roots in the interval (Descartes' rule): none means no root, one means exactly one, which a
safeguarded Newton method computes.  Otherwise the interval is halved (de Casteljau).  Source: Rouillier &
Zimmermann, J. Comput. Appl. Math. 162 (2004) 33-50.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.arithmetic import COLUMNS, write_bernstein
from frictionlab.hybrid.kernels.jets import (
    MACHINE_EPSILON,
    majorant,
    mode_jets,
    polynomial_slope,
    series_change,
    series_range,
    states_at,
    value_and_slope,
)

MAX_DEPTH = 60  # nested halvings, so at most as many intervals wait
# Roots closer than this, relative to their place, cannot be told from a double root in double precision.
ROOT_RESOLUTION = 1e-8
# A step of Newton's method below this share of the root leaves an error of the order of its square.
LAST_NEWTON_STEP = 1e-10


class RootScratch(NamedTuple):
    """A polynomial on [0, 1], its roots, and the arrays used to find them."""

    stack: np.ndarray  # (MAX_DEPTH + 1, columns) Bernstein coefficients on the intervals that wait
    intervals: np.ndarray  # (MAX_DEPTH + 1, 2)
    scaled: np.ndarray  # (order + 1,) coefficients of the polynomial, lowest first
    monomials: np.ndarray  # (order + 1, columns) row k: Bernstein coefficients of x^k, then zeros
    places: np.ndarray  # (order + 2,) of its roots
    multiplicity: np.ndarray  # (order + 2,)


def new_root_scratch(order: int) -> RootScratch:
    """Scratch arrays for polynomials up to the degree `order`."""
    monomials = monomials_in_bernstein_form(order)
    return RootScratch(
        stack=np.zeros((MAX_DEPTH + 1, monomials.shape[1])),
        intervals=np.zeros((MAX_DEPTH + 1, 2)),
        scaled=np.zeros(order + 1),
        monomials=monomials,
        places=np.zeros(order + 2),
        multiplicity=np.zeros(order + 2, dtype=np.int64),
    )


@cache
def monomials_in_bernstein_form(order: int) -> np.ndarray:
    """Bernstein coefficients of degree `order` on [0, 1] of x^k, in row k: C(j, k) / C(order, k).

    The rows are filled up with zeros to a multiple of COLUMNS.
    """
    places = range(order + 1)
    table = np.zeros((order + 1, -(-(order + 1) // COLUMNS) * COLUMNS))
    table[:, : order + 1] = [[math.comb(j, k) / math.comb(order, k) for j in places] for k in places]
    table.flags.writeable = False
    return table


@kernel
def low_degree_to_bernstein(a, n, b):
    """Bernstein coefficients `b` on [0, 1] of the polynomial sum a[k] x^k of degree `n`, in few operations.

    At a low degree they are often free of rounding errors, so that double roots are seen as such.
    """
    binomial = 1.0
    for k in range(n + 1):
        b[k] = a[k] / binomial
        binomial = binomial * (n - k) / (k + 1)
    for i in range(1, n + 1):
        for j in range(n, i - 1, -1):
            b[j] += b[j - 1]


@kernel
def to_bernstein(a, n, monomials, b):
    """Bernstein coefficients `b` on [0, 1] of sum a[k] x^k, of degree `n`; returns their degree.

    This is the degree of the table `monomials`, unless that is 2 `n` or more.  A degree above `n` adds no
    sign changes.  `b` is as long as the rows of the table.
    """
    degree = monomials.shape[0] - 1
    if 2 * n <= degree:
        low_degree_to_bernstein(a, n, b)
        degree = n
    else:
        for first in range(0, monomials.shape[1], COLUMNS):
            write_bernstein(a, n, monomials, first, b)
    total = 0.0
    for k in range(n + 1):
        total += a[k]
    b[degree] = total  # the value at 1, without the rounding errors above
    return degree


@kernel
def sign_changes(b, n):
    """Number of sign changes in b[0..n], zeros left out."""
    changes = 0
    last = 0.0
    for j in range(n + 1):
        if b[j] != 0.0:
            if last * b[j] < 0.0:
                changes += 1
            last = 1.0 if b[j] > 0.0 else -1.0
    return changes


@kernel
def bisect_bernstein(b, n, left, right):
    """Split Bernstein coefficients at the middle (de Casteljau); `right` may be `b` itself."""
    for j in range(n + 1):
        right[j] = b[j]
    left[0] = right[0]
    for i in range(1, n + 1):
        for j in range(n - i + 1):
            right[j] = 0.5 * (right[j] + right[j + 1])
        left[i] = right[0]


@kernel
def control_polygon_root(b, n, lo, hi):
    """Where the polygon of Bernstein coefficients b[0..n] on (lo, hi) changes its sign: near the root."""
    last = 0
    for j in range(1, n + 1):
        if b[j] != 0.0:
            if b[last] * b[j] < 0.0:
                share = (last + (j - last) * (b[last] / (b[last] - b[j]))) / n
                return lo + (hi - lo) * share
            last = j
    return 0.5 * (lo + hi)


@kernel
def refine_root(a, n, x, lo, hi, falling):
    """The one root of sum a[k] x^k in (lo, hi), by Newton's method from `x` on.

    `falling` says that the polynomial goes from + to -.
    """
    if not (lo < x < hi):
        x = 0.5 * (lo + hi)
    for _ in range(100):
        value, slope = value_and_slope(a, n, x)
        if value == 0.0:
            return x
        if (value > 0.0) == falling:
            lo = x
        else:
            hi = x
        new = x - value / slope if slope != 0.0 else lo
        if abs(new - x) <= LAST_NEWTON_STEP * x:
            return min(max(new, lo), hi)
        x = new if lo < new < hi else 0.5 * (lo + hi)
    return x


@kernel
def trailing_zeros(b, n):
    """Multiplicity of the root at the right end; 0 where there is none or everything is zero."""
    for j in range(n + 1):
        if b[n - j] != 0.0:
            return j
    return 0


@kernel
def isolate_roots(n, limit, roots):
    """First `limit` roots in (0, 1], ascending, of the polynomial of degree `n` in ``roots.scaled``.

    Writes places and multiplicities, returns how many there are.  Roots that cannot be told apart
    count as one multiple root.
    """
    count = 0
    a, stack, bounds = roots.scaled, roots.stack, roots.intervals
    while n > 0 and a[n] == 0.0:
        n -= 1
    degree = to_bernstein(a, n, roots.monomials, stack[0])
    bounds[0, 0] = 0.0
    bounds[0, 1] = 1.0
    top = 0
    while top >= 0 and count < limit:
        b = stack[top]
        lo = bounds[top, 0]
        hi = bounds[top, 1]
        changes = sign_changes(b, degree)
        at_end = trailing_zeros(b, degree)
        place = -1.0
        order = changes
        if changes == 0:
            if at_end > 0:
                place = hi
                order = at_end
        elif changes == 1 and at_end == 0:
            start = control_polygon_root(b, degree, lo, hi)
            place = refine_root(a, n, start, lo, hi, b[degree] < 0.0)
        elif hi - lo <= ROOT_RESOLUTION * hi or top == MAX_DEPTH - 1:
            place = 0.5 * (lo + hi)
        else:
            middle = 0.5 * (lo + hi)
            bisect_bernstein(b, degree, stack[top + 1], b)
            bounds[top, 0] = middle
            bounds[top + 1, 0] = lo
            bounds[top + 1, 1] = middle
            top += 1
            continue
        top -= 1
        if place >= 0.0:
            roots.places[count] = place
            roots.multiplicity[count] = order
            count += 1
    return count


COEFFICIENT_ROUNDING = 64 * MACHINE_EPSILON
LOW_ORDER = 2  # orders that nearly always decide, examined first
SUSPECT_SHARE = 1e-9  # share of the terms; a smaller leading coefficient is compared with its rounding error
SAME_PLACE = 4 * MACHINE_EPSILON  # share of a step within which two zeros are at one instant
NEWTON_STEPS = 12  # most steps of Newton's method; at a tolerance of 1e-15 one is enough
NO_GUARD = -1


class GuardZero(NamedTuple):
    """The first zero of a guard in a step."""

    time: float  # from the start of the step
    guard: int  # NO_GUARD where no guard is zero; the time is that of the step's end then
    multiplicity: int


@kernel
def leading_order(c, bound, declared, order, share):
    """Number of the first Taylor coefficient that is not zero; `order + 1` where all are.

    The first `declared` coefficients are zero by construction.  Others count as zero below a `share` of their
    bounds.  The share is COEFFICIENT_ROUNDING if only rounding is to count as zero.
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
def rescale(c, m, n, h, a):
    """Write the coefficients of c[m] + c[m+1] s + ... in s/h into `a`; return their absolute sum."""
    power, total = 1.0, 0.0
    for k in range(m, n + 1):
        a[k - m] = c[k] * power
        total += abs(a[k - m])
        power *= h
    return total


@inlined
def lower_bound_of_guard(J, slot, m, order, h):
    """Lower bound on [0, h] of a guard whose `m` leading coefficients are zero, divided by s^m."""
    if m > 0:
        return lower_bound(J[slot], m, order, h)
    falls = series_range(J, slot, order, h) - series_change(J, slot, order, h)
    return J[slot, 0] - 0.5 * falls


@inlined
def first_event(system, mode, z, order, h, tried, scratch):
    """First zero of the mode's guards in [0, h], along the jets in `scratch`.

    ``scratch.leading_zeros[g]`` leading coefficients of guard g count as zero at the start.  If the lower
    bounds on [0, h] have been `tried`, all coefficients of guards that stay positive count as zero.
    """
    code, J, roots = system.code, scratch.jets, scratch.roots
    first = code.mode_guards[mode]
    hit = NO_GUARD
    order_of_hit = 1
    for g in range(first, code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        c = J[slot]
        m = scratch.leading_zeros[g - first]
        if m > order:
            continue
        if (not tried or hit != NO_GUARD) and lower_bound_of_guard(J, slot, m, order, h) > 0.0:
            continue
        size = rescale(c, m, order, h, roots.scaled)
        if c[m] <= SUSPECT_SHARE * size:
            m = leading_order_of_slot(system, mode, slot, m, z, order, J, scratch.bounds)
            if m > order:
                continue
            rescale(c, m, order, h, roots.scaled)
            if c[m] < 0.0:
                return GuardZero(0.0, g, 1)
        if not size < math.inf:  # so near to a pole its polynomial has no meaning
            continue
        found = isolate_roots(order - m, 1, roots)
        # Of two at one instant the first in the mode's order counts.
        if found and (hit == NO_GUARD or roots.places[0] < 1.0 - SAME_PLACE):
            h *= roots.places[0]
            hit = g
            order_of_hit = roots.multiplicity[0]
    return GuardZero(h, hit, order_of_hit)


@inlined
def is_guard_truncated(code, guard, mode, order, s, J):
    """Whether a guard's polynomial may differ from the guard at `s`; that of an affine guard does not."""
    if code.guard_degrees[guard] < 2 or s == 0.0:
        return False
    return code.degrees[mode] >= order or has_significant_tail(J[code.function_slots[guard]], order, s)


@inlined
def has_significant_tail(c, order, s):
    """Whether the last two terms of a polynomial are above the rounding error of its largest term."""
    before = last = largest = 0.0
    power = 1.0
    for k in range(order + 1):
        before, last = last, abs(c[k]) * power
        largest = max(largest, last)
        power *= s
    return before + last > MACHINE_EPSILON * largest


@kernel
def refine_event_time(system, mode, guard, order, s, scratch):
    """Time of a guard's simple zero along the states' polynomials, near the zero `s` of its own polynomial.

    The guard's own polynomial is truncated.  At its zero the guard itself may therefore be of the size of the
    tolerance, and of either sign.  So may be what vanishes with it, such as the acceleration after stick if
    mu_s = mu_k.  Newton's method makes the guard zero up to rounding: until its size is no longer halved.
    """
    code, z, values = system.code, scratch.states, scratch.values
    slot = code.function_slots[guard]
    time, best, least = s, s, math.inf
    for _ in range(NEWTON_STEPS):
        states_at(scratch.jets, order, time, z)
        mode_jets(code, system.numbers, mode, 0, z, values)
        value = abs(values[slot, 0])
        if not value < 0.5 * least:  # what is left is rounding, or Newton's method does not converge
            break
        best, least = time, value
        time -= values[slot, 0] / polynomial_slope(scratch.jets[slot], order, time)
        if not time >= 0.0:
            break
    return best


@inlined
def is_zero_truncated(code, zero, mode, order, J):
    """Whether a zero is a simple one of a guard whose polynomial may differ from the guard there."""
    return (
        zero.guard != NO_GUARD
        and zero.multiplicity == 1
        and is_guard_truncated(code, zero.guard, mode, order, zero.time, J)
    )


@kernel
def refine_zero(system, mode, zero, left, order, scratch):
    """The zero of the guard itself near that of its polynomial; none where it is after the time `left`."""
    time = refine_event_time(system, mode, zero.guard, order, zero.time, scratch)
    if time > left:  # beyond the end of this run
        return GuardZero(left, NO_GUARD, zero.multiplicity)
    return GuardZero(time, zero.guard, zero.multiplicity)
