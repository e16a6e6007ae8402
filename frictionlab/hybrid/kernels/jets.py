"""Taylor coefficients of the slots of a tape: the innermost loop of the solver.

A jet array J has one row per slot and one column per order: slot(t + s) = sum_k J[slot, k] s^k.  Rows have
one length, JET_COLUMNS, for all orders: native code has it built in, and so serves all orders.
Gradients of the slots by the states are computed in the same way (forward mode). Recurrences: Jorba & Zou,
Experimental Mathematics 14 (2005) 99-117, section 2.
"""

from __future__ import annotations

import math

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.arithmetic import (
    PARTS,
    call_jets,
    exp2,
    sum_of_magnitudes,
    sum_of_series,
    write_panel,
    write_states,
)
from frictionlab.tape.elementary.exponentials import power
from frictionlab.tape.functions import AFFINE, POWER, PRODUCT, QUOTIENT, RATE, SQUARE, function_value
from frictionlab.tape.panels import ROWS
from frictionlab.tape.program import NOT_POLYNOMIAL

MAX_ORDER = 60  # highest order that may be asked for
JET_COLUMNS = MAX_ORDER + 1  # not a power of two, by which all rows would fall on few sets of the cache
LOG2_LEAST_RATIO = -963.0  # 2^963, some 1e290, is the largest coefficient that a power may have

# This times the majorant is taken for a bound of rounding errors.
MACHINE_EPSILON = 2.220446049250313e-16
# A divisor below this share of its bound counts as zero: half of that of other values, as it is a square.
DIVISOR_ROUNDING = 32 * MACHINE_EPSILON


@kernel
def convolution(J, a, b, k):
    """Sum of J[a, j] J[b, k - j] over 0 < j < k.

    Native code computes four orders at once, a block.  Products of coefficients from below the block come
    first, in four independent sums; then come those with a coefficient from the block.
    """
    known = (k - 1) // 4 * 4  # the orders of the block follow this one
    least = k - known
    one = two = three = four = 0.0
    j = known
    while j > 4:
        one += J[a, j] * J[b, k - j]
        two += J[a, j - 1] * J[b, k - j + 1]
        three += J[a, j - 2] * J[b, k - j + 2]
        four += J[a, j - 3] * J[b, k - j + 3]
        j -= 4
    if known > 0:
        one += J[a, 4] * J[b, k - 4]
        if least < 4:
            two += J[a, 3] * J[b, k - 3]
        if least < 3:
            three += J[a, 2] * J[b, k - 2]
        if least < 2:
            four += J[a, 1] * J[b, k - 1]
    total = (one + two) + (three + four)
    for j in range(known + 1, k):
        total += J[a, j] * J[b, k - j]
        if known > 0:
            total += J[a, k - j] * J[b, j]
    return total


@kernel
def convolution_with_last(J, a, b, k):
    """Sum of J[a, j] J[b, k - j] over 0 < j <= k."""
    return convolution(J, a, b, k) + J[a, k] * J[b, 0] if k > 0 else 0.0


@kernel
def product_coefficient(J, a, b, k):
    """Coefficient k of the product of two slots; the newest are added last, that of b after that of a."""
    if k == 0:
        return J[a, 0] * J[b, 0]
    return convolution_with_last(J, a, b, k) + J[a, 0] * J[b, k]


@kernel
def square_coefficient(J, a, k):
    """Coefficient k of the square of a slot."""
    if k == 0:
        return J[a, 0] * J[a, 0]
    return convolution(J, a, a, k) + 2.0 * J[a, 0] * J[a, k]


@kernel
def function_coefficient(kind, a, slope, out, k, sign, values, J):
    """Coefficient k of a function of slot a, its derivative s in `slope`: the sum of j a_j s_(k-j) / k."""
    if k > 0:
        return convolution_with_last(J, out - 1, slope, k) / k
    if sign > 0.0:  # a majorant: its own rounding error, and that of the argument
        return abs(values[out, 0]) + abs(values[slope, 0]) * J[a, 0]
    return function_value(kind, J[a, 0])


@kernel
def has_series(J, a, k, order):
    """Whether the Taylor coefficients up to `order` of a power of slot a are finite.

    From one to the next they grow by |a_1/a_0|, or by |a_2/a_0|^(1/2) if the base comes to zero tangentially.
    Coefficient `k` of the power is judged by those of its base up to k, which are known by then.
    """
    base, least = J[a, 0], exp2(LOG2_LEAST_RATIO / max(order, 1))
    if k > 1 and not base > least * least * abs(J[a, 2]):
        return False
    return base > least * abs(J[a, 1])


@kernel
def power_coefficient(exponent, a, out, k, order, sign, values, J):
    """Coefficient k of a power of slot a, which is not negative.

    Where a is zero or nearly so, as at the onset of contact with a force penetration^1.5, there is no series.
    Then the power counts as constant, and :mod:`frictionlab.hybrid.kernels.step_length` finds a step that is
    short enough for this.
    """
    base = values[a, 0]
    if not base > 0.0:
        return math.inf if exponent < 0.0 else 0.0
    if k > 0 and not has_series(values, a, k, order):
        return 0.0
    if k == 0 and sign > 0.0:
        return abs(values[out, 0]) * (1.0 + abs(exponent) * J[a, 0] / base)
    if k == 0:
        return power(base, exponent)
    total = (exponent + 1.0) * convolution_with_last(J, out - 1, out, k)
    total += sign * k * convolution_with_last(J, a, out, k)
    if sign > 0.0:
        total += k * J[a, 0] * abs(values[out, k])
    return total / (k * base)


@inlined
def term_step(code, a):
    """By how much the numbers of the terms of one sum go up, from number `a` on."""
    return ROWS if a >= code.shared else 1


@inlined
def term_slot(code, j):
    """The slot of term number `j`."""
    shared = code.shared
    return code.term_slots[j if j < shared else shared + (j - shared) // ROWS]


@kernel
def row_without_zeros(terms, slots, first, column, count, k, J):
    """As :func:`write_panel`, of one row, whose zeros are left out: zero times infinity is no term."""
    total = 0.0
    for t in range(count):
        if terms[first + ROWS * t] != 0.0:
            total += terms[first + ROWS * t] * J[slots[column + t], k]
    return total


@inlined
def panel_coefficients(code, numbers, op, last, k, out, J):
    """Compute coefficient k of the rows of a panel, of which `op` is the first; returns their number."""
    ops, terms, slots, rows = code.ops, numbers.terms, code.term_slots, 1
    a, b = np.int64(ops[op, 1]), np.int64(ops[op, 2])
    while rows < ROWS and op + rows < last and ops[op + rows, 0] == AFFINE and ops[op + rows, 1] == a + rows:
        rows += 1
    column, count = code.shared + (a - code.shared) // ROWS, (b - a) // ROWS
    write_panel(terms, slots, a, column, count, k, J, out, rows)
    for row in range(rows):
        if J[out + row, k] != J[out + row, k]:  # NaN, maybe of a zero and an infinite coefficient
            J[out + row, k] = row_without_zeros(terms, slots, a + row, column, count, k, J)
    return rows


@kernel
def run_tape(code, numbers, operations, orders, flow, sign, values, J):
    """Compute Taylor coefficients, of the `orders` (lowest, highest), of the slots that `operations` write.

    Column 0 of the states is given, and so are the columns below the lowest order.  ``flow[i]`` is the slot
    that holds the derivative of state i.  For the jets `sign` is -1 and `values` is `J`.  With +1, absolute
    values for numbers and states, and the jets themselves as `values`, the recurrences give a majorant of the
    jets, which times the machine epsilon bounds their rounding errors.
    """
    ops, slots, constants, terms = code.ops, code.term_slots, numbers.constants, numbers.terms
    inputs = code.inputs
    first, last = operations
    lowest, order = orders
    for k in range(lowest, order + 1):
        if k > 0:
            share = 1.0 / k
            for i in range(inputs):
                J[i, k] = J[flow[i], k - 1] * share
        i = first
        while i < last:
            kind = ops[i, 0]
            a = ops[i, 1]
            b = ops[i, 2]
            out = inputs + i - first
            total = 0.0
            if kind == AFFINE:
                if code.shared <= a < b:
                    i += panel_coefficients(code, numbers, i, last, k, out, J)
                    continue
                if k == 0:
                    total = constants[i]
                for j in range(a, b):
                    total += terms[j] * J[slots[j], k]
            elif kind == PRODUCT:
                total = product_coefficient(J, a, b, k)
            elif kind == SQUARE:
                total = square_coefficient(J, a, k)
            elif kind == RATE:
                total = k * J[a, k]
            elif kind == POWER:
                total = power_coefficient(constants[i], a, out, k, order, sign, values, J)
            elif kind > POWER:
                total = function_coefficient(kind, a, b, out, k, sign, values, J)
            else:
                total = J[a, k] + sign * convolution_with_last(J, b, out, k)
                divisor = values[b, 0]  # the majorant's own value would be too large where terms cancel
                if sign > 0.0:
                    total += J[b, 0] * abs(values[out, k])  # the divisor's rounding error
                    divisor = abs(divisor)
                total /= divisor
            J[out, k] = total
            i += 1


@inlined
def mode_operations(code, mode):
    """Range of a mode's operations, (first, last + 1)."""
    return code.mode_ops[mode], code.mode_ops[mode + 1]


@inlined
def has_native_jets(code, mode, J):
    """Whether there is native code for a mode's jets, and the rows of `J` have the length built into it."""
    return code.native[mode] != 0 and J.shape[1] == JET_COLUMNS


@inlined
def mode_jets(code, numbers, mode, order, z, J):
    """Taylor coefficients up to `order` of a mode's slots at the state `z`.

    Native code leaves out intermediate results whose series nothing reads; of such rates it keeps the values.
    """
    if has_native_jets(code, mode, J):
        call_jets(code.native[mode], z, numbers.constants, numbers.terms, J, order)
        return
    for i in range(z.shape[0]):
        J[i, 0] = z[i]
    run_tape(code, numbers, mode_operations(code, mode), (0, order), code.flow[mode], -1.0, J, J)


@kernel
def majorant(code, magnitudes, mode, order, z, jets, J):
    """Majorant of the `jets` at `z`; `magnitudes` are the absolute values of the tape's numbers."""
    majorant_of_orders(code, magnitudes, mode, (0, order), z, jets, J)


@kernel
def majorant_of_orders(code, magnitudes, mode, orders, z, jets, J):
    """As :func:`majorant`, of the `orders` (lowest, highest); the lower ones are in `J`."""
    for i in range(z.shape[0]):
        J[i, 0] = abs(z[i])
    run_tape(code, magnitudes, mode_operations(code, mode), orders, code.flow[mode], 1.0, jets, J)


@inlined
def low_majorant(code, magnitudes, mode, orders, z, sizes, jets, J):
    """As :func:`majorant_of_orders`; for few orders by native code where all operations are polynomials.

    With absolute values of numbers and states their jets are their majorant.  `sizes` is scratch.
    """
    many = orders[1] > PARTS
    if many or code.degrees[mode] == NOT_POLYNOMIAL or not has_native_jets(code, mode, J):
        majorant_of_orders(code, magnitudes, mode, orders, z, jets, J)
        return
    for i in range(z.shape[0]):
        sizes[i] = abs(z[i])
    call_jets(code.native[mode], sizes, magnitudes.constants, magnitudes.terms, J, orders[1])


@kernel
def first_order_bounds(code, magnitudes, mode, jets, J):
    """Write sharper bounds of values into column 0 of the majorant; returns whether a divisor may be zero.

    This is for modes that divide by functions of the state.  If two factors are nearly zero, the product of
    their majorants is far more than what rounding does to their product.  A quotient shows this.
    """
    ops, inputs = code.ops, code.inputs
    first, last = mode_operations(code, mode)
    if not code.quotients[mode]:
        return False
    vanishes = False
    for i in range(first, last):
        kind, a, b, out = ops[i, 0], ops[i, 1], ops[i, 2], inputs + i - first
        if kind == AFFINE:
            total = magnitudes.constants[i]
            for j in range(a, b, term_step(code, a)):
                if magnitudes.terms[j] != 0.0:
                    total += magnitudes.terms[j] * J[term_slot(code, j), 0]
            J[out, 0] = total
        elif kind == PRODUCT:
            J[out, 0] = abs(jets[a, 0]) * J[b, 0] + J[a, 0] * abs(jets[b, 0])
        elif kind == SQUARE:
            J[out, 0] = 2.0 * abs(jets[a, 0]) * J[a, 0]
        elif kind == QUOTIENT:
            J[out, 0] = (J[a, 0] + J[b, 0] * abs(jets[out, 0])) / abs(jets[b, 0])
            if not abs(jets[b, 0]) > DIVISOR_ROUNDING * J[b, 0]:
                vanishes = True
        elif kind == POWER:
            J[out, 0] = power_coefficient(magnitudes.constants[i], a, out, 0, 0, 1.0, jets, J)
        elif kind > POWER:
            J[out, 0] = function_coefficient(kind, a, b, out, 0, 1.0, jets, J)
    return vanishes


@kernel
def reset_values(code, numbers, reset, z, J):
    """Values, in column 0 of `J`, of the slots of a reset at the state `z`."""
    for i in range(z.shape[0]):
        J[i, 0] = z[i]
    operations = code.reset_ops[reset], code.reset_ops[reset + 1]
    run_tape(code, numbers, operations, (0, 0), code.reset_out[reset], -1.0, J, J)


@kernel
def widen_by_reset(system, reset, z, sizes, jets, J):
    """Enlarge the `sizes` of the states to those of the terms that a reset adds up at `z`, by its `jets`."""
    code = system.code
    for i in range(z.shape[0]):
        J[i, 0] = abs(z[i])
    operations = code.reset_ops[reset], code.reset_ops[reset + 1]
    run_tape(code, system.magnitudes, operations, (0, 0), code.reset_out[reset], 1.0, jets, J)
    for i in range(z.shape[0]):
        sizes[i] = max(sizes[i], J[code.reset_out[reset, i], 0])


@inlined
def polynomial_value(c, n, s):
    """Value at `s` of the polynomial with coefficients c[0..n]."""
    total = c[n]
    for k in range(n - 1, -1, -1):
        total = total * s + c[k]
    return total


@kernel
def polynomial_slope(c, n, s):
    """Derivative at `s` of the polynomial with coefficients c[0..n]."""
    total = n * c[n]
    for k in range(n - 1, 0, -1):
        total = total * s + k * c[k]
    return total


@inlined
def value_and_slope(a, n, x):
    """Value and slope of sum a[k] x^k; even and odd powers are summed independently."""
    y = x * x
    last = n // 2
    even, even_slope = a[2 * last], 0.0
    odd, odd_slope = a[n] if n % 2 == 1 else 0.0, 0.0
    for i in range(last - 1, -1, -1):
        even_slope = even_slope * y + even
        even = even * y + a[2 * i]
        odd_slope = odd_slope * y + odd
        odd = odd * y + a[2 * i + 1]
    return even + x * odd, (odd + 2.0 * y * odd_slope) + 2.0 * x * even_slope


@inlined
def copy_vector(source, target):
    """Copy a vector; numba compiles a loop much faster than an assignment to a slice."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@inlined
def series_change(J, slot, order, s):
    """Change of a slot in a time `s` after the expansion point: its polynomial without the first term.

    Adding it to the first term then rounds the value only once.
    """
    groups = order // PARTS
    last = 0.0
    for k in range(order, PARTS * groups, -1):
        last = last * s + J[slot, k]
    return sum_of_series(J, slot, groups, last, s)


@inlined
def series_range(J, slot, order, radius):
    """Bound of how far a slot's polynomial goes from its first term on the disc of a radius."""
    groups = order // PARTS
    last = 0.0
    for k in range(order, PARTS * groups, -1):
        last = last * radius + abs(J[slot, k])
    return sum_of_magnitudes(J, slot, groups, last, radius)


@inlined
def states_at(J, order, s, z):
    """Write the states at time `s` after the expansion point into `z`; `J` must be contiguous."""
    fours = z.shape[0] - z.shape[0] % PARTS
    for first in range(0, fours, PARTS):
        write_states(J, first, order, s, z)
    for i in range(fours, z.shape[0]):
        z[i] = J[i, 0] + series_change(J, i, order, s)


@inlined
def state_rates(code, numbers, mode, z, J, dz):
    """Time derivative of the states; leaves the values of all slots in column 0 of `J`."""
    mode_jets(code, numbers, mode, 0, z, J)
    for i in range(z.shape[0]):
        dz[i] = J[code.flow[mode, i], 0]


@kernel
def slot_gradients(code, numbers, mode, z, J, T):
    """Forward mode through a mode's tape at `z`: T[slot, i] is the slot's derivative by state i."""
    inputs, (first, last) = code.inputs, mode_operations(code, mode)
    T[:inputs] = 0.0
    for i in range(inputs):
        J[i, 0] = z[i]
        T[i, i] = 1.0
    run_tape(code, numbers, (first, last), (0, 0), code.flow[mode], -1.0, J, J)
    for op in range(first, last):
        kind, a, b, out = code.ops[op, 0], code.ops[op, 1], code.ops[op, 2], inputs + op - first
        for i in range(inputs):
            if kind == AFFINE:
                T[out, i] = 0.0
                for j in range(a, b, term_step(code, a)):
                    if numbers.terms[j] != 0.0:
                        T[out, i] += numbers.terms[j] * T[term_slot(code, j), i]
            elif kind == PRODUCT:
                T[out, i] = J[a, 0] * T[b, i] + J[b, 0] * T[a, i]
            elif kind == SQUARE:
                T[out, i] = 2.0 * J[a, 0] * T[a, i]
            elif kind == RATE:
                T[out, i] = 0.0
            elif kind == POWER:
                slope = numbers.constants[op] * J[out, 0] / J[a, 0] if J[a, 0] > 0.0 else 0.0
                T[out, i] = slope * T[a, i]
            elif kind > POWER:
                T[out, i] = J[b, 0] * T[a, i]
            else:
                T[out, i] = (T[a, i] - J[out, 0] * T[b, i]) / J[b, 0]
