"""Steps where a power has no Taylor series of full order: its base is zero, or nearly so.

The force penetration^1.5 of two spheres is such a power, at the onset and at the end of their contact.  Its
coefficients grow like (rate/base)^k, beyond the largest number where the base is small.  Then the series ends
earlier, which is enough: so near to zero little of the motion is at stake.  At zero itself the power counts
as constant for a step.
"""

from __future__ import annotations

import math

from frictionlab.hybrid.compilation import kernel
from frictionlab.hybrid.kernels.arithmetic import exp2, log2
from frictionlab.hybrid.kernels.jets import has_series, majorant, mode_jets, polynomial_slope, states_at
from frictionlab.hybrid.kernels.step_length import largest_coefficient
from frictionlab.hybrid.tape.operations import POWER

ONSET_TRIES = 100
MIN_USEFUL_ORDER = 4  # orders below which a series is not worth while
INSTANT = (
    1e-11  # s: errors within so short a time are measured by what moves in it, not by what has moved yet
)
ROUNDING = 2.220446049250313e-16  # of a base, as a share of its terms
LOG2_LARGEST_COEFFICIENT = 960.0  # near the 1e290 beyond which a power counts as without a series (jets)


@kernel
def lacks_series(code, order, mode, J):
    """Whether the base of a power is zero, or too near to it."""
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            base = J[code.ops[i, 1]]
            if not has_series(base[0], base[1], order):
                return True
    return False


@kernel
def has_base_near_zero(code, order, mode, J):
    """Whether the base of a power is zero, or comes to zero within an instant."""
    return lacks_series(code, order, mode, J) or time_to_zero_base(code, mode, J) < INSTANT


@kernel
def usable_order(code, order, mode, J):
    """Number of orders up to which the coefficients of all powers are numbers; 0 at a base of zero."""
    few = order
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            base, rate = J[code.ops[i, 1], 0], abs(J[code.ops[i, 1], 1])
            if not base > 0.0:
                return 0
            if not has_series(base, rate, order):
                few = min(few, int(LOG2_LARGEST_COEFFICIENT / (log2(rate) - log2(base))))
    return few


@kernel
def truncate_series_near_zero(code, numbers, mode, order, z, passes, J):
    """Jets where a base is nearly zero; returns the order of the series, 0 where powers count as constant.

    `passes` says whether the step goes beyond the zero of the base.  The jets `J` at hand are those of the
    full order, for which powers without a series count as constant; what is above the order is made zero.
    """
    few = 1 if passes else usable_order(code, order, mode, J)
    if few < MIN_USEFUL_ORDER and lacks_series(code, order, mode, J):
        return 0
    if few < order or lacks_series(code, order, mode, J):
        mode_jets(code, numbers, mode, few, z, J)
        J[:, few + 1 :] = 0.0
    return few


@kernel
def time_to_zero_base(code, mode, J):
    """Time in which the first base of a power would come to zero at its rate."""
    shortest = math.inf
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            base = J[code.ops[i, 1]]
            if base[1] != 0.0:
                shortest = min(shortest, abs(base[0] / base[1]))
    return shortest


@kernel
def unresolved_time(code, magnitudes, mode, z, J, bounds):
    """Time in which no base that is within its rounding error moves by more than that; 0 where none is."""
    majorant(code, magnitudes, mode, 0, z, J, bounds)
    longest = math.inf
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        if code.ops[i, 0] == POWER:
            a = code.ops[i, 1]
            error = ROUNDING * bounds[a, 0]
            if abs(J[a, 0]) <= error:
                longest = min(longest, error / abs(J[a, 1]), math.sqrt(error / abs(J[a, 2])))
    return longest if longest < math.inf else 0.0


@kernel
def onset_step(system, truncation, mode, h, scratch):
    """Longest step up to `h` in which powers whose base is nearly zero may count as constant.

    Then the states' rates at its end, with the powers there, are those of the polynomials but for
    an error that changes no state by more than `tol` of its size.
    """
    code, order = system.code, truncation.order
    J, values, z = scratch.jets, scratch.bounds, scratch.states
    for _ in range(ONSET_TRIES):
        states_at(J, order, h, z)
        mode_jets(code, system.numbers, mode, 0, z, values)
        share = 0.0
        for group in range(3):
            first, last = code.groups[group], code.groups[group + 1]
            size = max(
                largest_coefficient(J, first, last, 0),
                largest_coefficient(J, first, last, 1) * max(h, INSTANT),
            )
            for i in range(first, last):
                error = h * abs(values[code.flow[mode, i], 0] - polynomial_slope(J[i], order, h))
                if error > 0.0:
                    share = max(share, error / (truncation.tol * size))
        if not share > 1.0:
            break
        h *= max(0.1, 0.9 * exp2(-0.4 * log2(share)))
    return h
