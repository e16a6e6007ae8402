"""How long a Taylor step may be, from the last two terms of the series."""

from __future__ import annotations

import math

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels.arithmetic import exp2, log2

# What the tolerance of a function of the states is wider than theirs: the room for rounding.
FUNCTION_TOL_FACTOR, LOG2_FUNCTION_TOL_FACTOR = 64.0, 6.0
MIN_FUNCTION_STEP_SHARE = 0.02


@kernel
def log2_of_tolerance(tol):
    """The logarithm by which steps are chosen, for who is no kernel."""
    return log2(tol)


@inlined
def largest_coefficient(J, first, last, k):
    """Largest Taylor coefficient number `k` of the states [first, last); infinite where one is no number."""
    size = 0.0
    for i in range(first, last):
        c = abs(J[i, k])
        if not c <= size:
            size = c if c == c else math.inf
    return size


@kernel
def log2_step_from_later_terms(room, p, first, last, J):
    """The same by the first term that is not zero, where the first three are; infinite where none is."""
    for m in range(3, p):
        size = largest_coefficient(J, first, last, m)
        if size > 0.0:
            return (room + log2(size)) / (p - m)
    return math.inf


@inlined
def log2_group_step(code, order, log_tol, first, last, J):
    """Binary logarithm of the longest step that suits the states [first, last); -inf where none does."""
    size0 = largest_coefficient(J, first, last, 0)
    size1 = largest_coefficient(J, first, last, 1)
    size2 = largest_coefficient(J, first, last, 2)
    if not size1 < math.inf:  # rates that are no number, though all later terms may be zero
        return -math.inf
    start0, start1, start2 = log2(size0), log2(size1), log2(size2)
    best = math.inf
    for p in range(order - 1, order + 1):
        end = largest_coefficient(J, first, last, p)
        if not end < math.inf:
            return -math.inf
        if end > 0.0:
            room = log_tol - log2(end)
            if size0 > 0.0 or size1 > 0.0 or size2 > 0.0:
                longest = max((room + start0) / p, max((room + start1) / (p - 1), (room + start2) / (p - 2)))
            else:
                longest = log2_step_from_later_terms(room, p, first, last, J)
            best = min(best, longest)
    return best


@inlined
def step_length(code, order, tol, J):
    """Longest step for which the last two terms stay below `tol` times the size of their group of states.

    Jorba & Zou, Experimental Mathematics 14 (2005) 99-117, section 3.  The size of a group is the largest of
    its first three terms at the end of the step, so that no absolute tolerance is needed: a step h will do
    if, for one m of 0, 1, 2, |c_p| h^p <= tol |c_m| h^m; where those three are zero, for the next that is
    not.  Zero where a coefficient is no number.
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


@kernel
def series_step(c, order, tol, h):
    """Longest step up to `h` in which the last two terms of a series stay below `tol` times its largest."""
    for _ in range(20):
        size = 0.0
        power = 1.0
        for k in range(order - 1):
            size = max(size, abs(c[k]) * power)
            power *= h
        last = max(abs(c[order - 1]), abs(c[order]) * h) * power
        if size == 0.0 or not last > tol * size:
            break
        h *= max(0.1, exp2(log2(tol * size / last) / (order - 1)))
    return h


@inlined
def function_step(code, order, tol, mode, h, J):
    """Longest step up to `h` in which the series of guards, sections and integrals hold too.

    The states' series do not tell: a guard x^5 needs a fifth of the step that x does.  What would need
    less than a `MIN_FUNCTION_STEP_SHARE` of their step is rounding error.
    """
    tol *= FUNCTION_TOL_FACTOR
    shortest = MIN_FUNCTION_STEP_SHARE * h
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        h = series_step(J[code.function_slots[g]], order, tol, h)
    for section in range(code.sections.shape[1]):
        h = series_step(J[code.sections[mode, section]], order, tol, h)
    for i in range(code.groups[3], code.inputs):
        h = series_step(J[i], order, tol, h)
    return max(h, shortest)
