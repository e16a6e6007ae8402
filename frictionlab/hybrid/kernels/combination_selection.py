"""The next mode where modes are combinations of regimes and only some are derived: far too many to list.

Tried are, in this order: the targets of the event; where other events keep one of these from being entered,
that with the changes of all of these at once, and then those with one of them each, as several contacts may
change at one instant; then all combinations that the conditions of single regimes allow, in the automaton's
order.  What comes to be tried and is not derived ends the kernel, which is called again once it is.

Changing all that fails at once is block pivoting, as for linear complementarity problems (Judice & Pires,
Comput. Oper. Res. 21 (1994) 587-596): k equal contacts that begin to slip at one
instant take one more try, not 2^k.
"""

from __future__ import annotations

from frictionlab.hybrid.compilation import kernel
from frictionlab.hybrid.kernels.event_location import leading_order
from frictionlab.hybrid.kernels.jets import copy_vector, majorant, mode_jets
from frictionlab.hybrid.kernels.mode_selection import (
    AT_ANOTHER_EVENT,
    BY_VALUES,
    MISSING,
    NO_MODE,
    Selection,
    enter_passed,
    try_mode,
    try_mode_by_values,
    zeros_by_construction,
)

UNKNOWN = -2  # a combination of which it is not known whether it is a mode


@kernel
def find_mode(demand, combination):
    """Number of the mode of a combination; NO_MODE where it is none, UNKNOWN where it is not yet derived."""
    for k in range(demand.combinations.shape[0]):
        same = True
        for i in range(combination.shape[0]):
            if demand.combinations[k, i] != combination[i]:
                same = False
                break
        if same:
            return demand.modes[k]
    return UNKNOWN


@kernel
def add_candidate(row, queue, count):
    """Put a combination at the end of the queue of `count`, unless it is there; returns the new count."""
    rows = queue.rows
    if count == rows.shape[0]:
        return count
    for k in range(count):
        same = True
        for i in range(row.shape[0]):
            if rows[k, i] != row[i]:
                same = False
                break
        if same:
            return count
    copy_vector(row, rows[count])
    return count + 1


@kernel
def add_targets(queue, guard, count):
    """Put the targets of a guard's event into the queue; returns the new count."""
    demand = queue.demand
    for k in range(demand.listed[guard], demand.listed[guard + 1]):
        count = add_candidate(demand.targets[k], queue, count)
    return count


@kernel
def has_failed(system, guard, rounding, order, scratch):
    """Whether the guard of a mode keeps it from being entered; its jets are at hand."""
    zeros, J = zeros_by_construction(system.code, scratch, guard), scratch.jets
    slot = system.code.function_slots[guard]
    k = leading_order(J[slot], scratch.bounds[slot], zeros, order, rounding.share)
    return k <= order and J[slot, k] < 0.0


@kernel
def add_change(demand, guard, row, joint):
    """Change in `joint` what the first target of a guard's event changes in the combination `row`."""
    if demand.listed[guard] < demand.listed[guard + 1]:
        target = demand.targets[demand.listed[guard]]
        for i in range(row.shape[0]):
            if target[i] != row[i]:
                joint[i] = target[i]


@kernel
def put_next(queue, tried, row, count):
    """Put a combination next into the queue of `count`, unless it is there; returns the new count."""
    longer = add_candidate(row, queue, count)
    if longer > count:
        for k in range(count, tried, -1):
            copy_vector(queue.rows[k - 1], queue.rows[k])
        copy_vector(row, queue.rows[tried])
    return longer


@kernel
def add_targets_of_failed_guards(system, queue, mode, tried, rounding, order, scratch, count):
    """Put the targets of all events into the queue that keep the last tried mode from being entered, first
    that of all at once; the new count."""
    code, row, joint = system.code, queue.rows[tried - 1], queue.missing
    copy_vector(row, joint)
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if has_failed(system, g, rounding, order, scratch):
            add_change(queue.demand, g, row, joint)
    count = put_next(queue, tried, joint, count)
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if has_failed(system, g, rounding, order, scratch):
            count = add_targets(queue, g, count)
    return count


@kernel
def mark_regimes(system, queue, z, rounding, scratch):
    """Note for each regime of each part whether its conditions allow to enter a mode with it at `z`."""
    code, J, bounds, allowed = system.code, scratch.jets, scratch.bounds, queue.allowed
    mode = code.built.shape[0] - 1  # the last stands for the conditions of all regimes
    mode_jets(code, system.numbers, mode, 0, z, J)
    majorant(code, system.magnitudes, mode, 0, rounding.sizes, J, bounds)
    first, conditions = code.mode_constraints[mode], queue.demand.conditions
    for r in range(allowed.shape[0]):
        allowed[r] = 1
        for f in range(first + conditions[r], first + conditions[r + 1]):
            slot, zeros = code.function_slots[f], zeros_by_construction(code, scratch, f)
            if leading_order(J[slot], bounds[slot], zeros, 0, rounding.share) == 0 and J[slot, 0] < 0.0:
                allowed[r] = 0


@kernel
def is_allowed(queue, combination):
    """Whether the conditions of all regimes of a combination allow it."""
    refused = 0
    for i in range(combination.shape[0]):
        if queue.allowed[queue.demand.regimes[i] + combination[i]] == 0:
            refused += 1
    return refused == 0


@kernel
def next_allowed(queue, begins):
    """Go on to the next allowed combination, the first where it `begins`; whether there is one."""
    place, allowed, regimes = queue.place, queue.allowed, queue.demand.regimes
    i = 0 if begins else place.shape[0] - 1
    if begins:
        place[:] = -1
    while 0 <= i < place.shape[0]:
        count = regimes[i + 1] - regimes[i]
        place[i] += 1
        while place[i] < count and allowed[regimes[i] + place[i]] == 0:
            place[i] += 1
        if place[i] < count:
            i += 1
        else:
            place[i] = -1
            i -= 1
    return i == place.shape[0]


@kernel
def try_candidate(system, mode, z, rounding, order, scratch):
    """Whether a mode can be entered, by its series up to `order` or by the values of its conditions."""
    if order == BY_VALUES:
        return try_mode_by_values(system, mode, z, scratch)
    return try_mode(system, mode, z, rounding, order, scratch)


@kernel
def select_combination(system, queue, guard, z, rounding, order, scratch):
    """First admissible mode after the event of a guard, at the start for NO_MODE: a :class:`Selection`.

    As :func:`select_mode`.  Where a mode is missing its combination is left in ``queue.missing``.
    """
    rows, marked, begins, passed = queue.rows, False, True, NO_MODE
    count = 0 if guard == NO_MODE else add_targets(queue, guard, 0)
    tried = 0
    while True:
        while tried == count:
            if not marked:
                mark_regimes(system, queue, z, rounding, scratch)
                marked = True
            if count == rows.shape[0] or not next_allowed(queue, begins):
                return enter_passed(system, passed, z, rounding, order, scratch)
            begins = False
            count = add_candidate(queue.place, queue, count)
        mode = find_mode(queue.demand, rows[tried])
        tried += 1
        if mode == UNKNOWN:
            if not marked:
                mark_regimes(system, queue, z, rounding, scratch)
                marked = True
            if is_allowed(queue, rows[tried - 1]):
                copy_vector(rows[tried - 1], queue.missing)
                return Selection(NO_MODE, MISSING)
        if mode < 0:
            continue
        verdict = try_candidate(system, mode, z, rounding, order, scratch)
        if verdict > AT_ANOTHER_EVENT:
            return Selection(mode, NO_MODE)
        if verdict == AT_ANOTHER_EVENT and passed == NO_MODE:
            passed = mode
        mode_jets(system.code, system.numbers, mode, order, z, scratch.jets)
        majorant(system.code, system.magnitudes, mode, order, rounding.sizes, scratch.jets, scratch.bounds)
        count = add_targets_of_failed_guards(system, queue, mode, tried, rounding, order, scratch, count)
