"""Steps where a power has no Taylor series: its base is zero, or nearly so.

The force gap^1.5 of two spheres is such a power, at the onset and at the end of their contact.
"""

from __future__ import annotations

from frictionlab.hybrid.compiled import kernel
from frictionlab.hybrid.jets import POWER, has_series, mode_jets, states_at
from frictionlab.hybrid.step_length import largest

TRIES = 100


@kernel
def without_series(code, order, mode, J):
    """Whether the base of a power is zero, or too near to it."""
    first = code.mode_ops[mode]
    for i in range(first, code.mode_ops[mode + 1]):
        base = J[code.ops[i, 1]]
        if code.ops[i, 0] == POWER and not has_series(base[0], base[1], order):
            return True
    return False


@kernel
def onset_step(code, numbers, order, tol, mode, h, J, work):
    """Longest step up to `h` in which powers whose base is nearly zero may count as constant.

    Then the states' rates at its end, with the powers there, are those of the polynomials but for
    an error that changes no state by more than `tol` of its size.
    """
    for _ in range(TRIES):
        states_at(J, order, h, work.before)
        mode_jets(code, numbers, mode, 0, work.before, work.bounds)
        share = 0.0
        for group in range(3):
            first, last = code.groups[group], code.groups[group + 1]
            size = max(largest(J, first, last, 0), largest(J, first, last, 1) * h)
            for i in range(first, last):
                error = h * abs(work.bounds[code.flow[mode, i], 0] - slope(J[i], order, h))
                if error > 0.0:
                    share = max(share, error / (tol * size))
        if not share > 1.0:
            break
        h *= max(0.1, 0.9 / share**0.4)
    return h


@kernel
def slope(c, n, s):
    """Derivative at `s` of the polynomial with coefficients c[0..n]."""
    total = n * c[n]
    for k in range(n - 1, 0, -1):
        total = total * s + k * c[k]
    return total
