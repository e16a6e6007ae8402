"""The next mode: resets, and the first mode that is admissible at a state.

A mode can be entered if its flow has a value, its constraints hold, and it lasts: the first non-zero Taylor
coefficient of each of its event functions is positive.  A flow has no value where it divides by zero.  A
crank at its dead centre does not move the piston, so no force at the piston holds the crank.

Modes may be combinations of regimes.  These are far too many to list, and only some are derived.  Which one
follows is a complementarity problem: each contact has a regime, and conditions that are positive in it.  It
is solved by principal pivoting (Cottle, Pang & Stone, The Linear Complementarity Problem, 1992, ch. 4): each
trial gives all conditions of a mode, and those that fail say which regimes are to change.

The targets of the event are tried first.  Then the regimes of all conditions that fail are changed at once,
as long as fewer and fewer fail, else one at a time, the first of them first (Judice & Pires, Comput. Oper.
Res. 21 (1994) 587-596).  So k equal contacts that begin to slip at one instant take one more try, not 2^k.
No combination is tried twice: where all that a trial asks for has been tried, what an earlier one asked for
comes next.  A start has no event; there the first combination is that in the automaton's order which the
conditions of single regimes allow.  If the next combination is not derived, the kernel ends.  It is called
again once that mode is there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING, LOW_ORDER, leading_order
from frictionlab.hybrid.kernels.jets import (
    copy_vector,
    first_order_bounds,
    low_majorant,
    majorant,
    mode_jets,
    reset_values,
    widen_by_reset,
)
from frictionlab.hybrid.kernels.run_state import NO_REGIME

NO_MODE, MISSING = -1, -2
BY_VALUES = 0  # the order that stands for a choice by the values of conditions, without series
REFUSED, AT_ANOTHER_EVENT, UNDECIDED, ADMITTED = range(4)
JOINT_TRIALS = 3  # changes of all failed guards at once that need not make fewer of them fail


class Rounding(NamedTuple):
    """What counts as zero: coefficients below a `share` of their bounds, at states of these `sizes`."""

    sizes: np.ndarray
    share: float


class Selection(NamedTuple):
    """The mode to enter, or NO_MODE; and MISSING where one has to be derived first, else NO_MODE."""

    mode: int
    missing: int


@inlined
def has_modes_on_demand(code):
    """Whether modes are derived on demand, so that no event lists those that may follow it."""
    return code.targets.shape[1] == 0


@inlined
def is_impact(code, guard):
    """Whether the event of a guard has a reset of its own that closes a Zeno accumulation."""
    return code.resets[guard, 0] != code.resets[guard, 1]


@kernel
def apply_reset(system, reset, z, J):
    """Overwrite the state by its values after the reset number `reset`; -1 stands for no reset."""
    if reset >= 0:
        reset_values(system.code, system.numbers, reset, z, J)
        for i in range(z.shape[0]):
            z[i] = J[system.code.reset_out[reset, i], 0]


@inlined
def set_zeros_by_construction(code, guard, closing, scratch):
    """Note which functions vanish after an event's own reset, or after the `closing` one."""
    forget_zeros(scratch)
    add_zeros_by_construction(code, guard, closing, scratch)


@inlined
def add_zeros_by_construction(code, guard, closing, scratch):
    """As :func:`set_zeros_by_construction`, besides what vanishes after other resets."""
    row, zeros = 2 * guard + closing, scratch.structural_zeros
    for k in range(code.zeros[row], code.zeros[row + 1]):
        zeros[code.zero_classes[k]] = max(zeros[code.zero_classes[k]], code.zero_counts[k])


@inlined
def apply_event_reset(system, guard, closing, z, scratch):
    """Reset a state by an event's own reset or its `closing` one, and note which functions vanish then."""
    apply_reset(system, system.code.resets[guard, closing], z, scratch.jets)
    set_zeros_by_construction(system.code, guard, closing, scratch)


@kernel
def keep_held_at_zero(system, mode, reset, before, z, sizes, scratch):
    """Count the constraints of the mode that ends as zero if a reset changed them by rounding only.

    One contact may come to rest while another sticks.  The impulse that stops it may move the other by a
    rounding error.  If everything comes to rest at once, this error is not small beside the state at that
    instant.  It is small beside the state in the step before, `sizes`, and beside the terms that the reset
    adds.
    """
    code, J, earlier, bounds = system.code, scratch.jets, scratch.values, scratch.bounds
    first, last = code.mode_constraints[mode], code.mode_constraints[mode + 1]
    if first == last:
        return
    widen_by_reset(system, reset, before, sizes, J, bounds)
    mode_jets(code, system.numbers, mode, 0, before, earlier)
    mode_jets(code, system.numbers, mode, 0, z, J)
    majorant(code, system.magnitudes, mode, 0, sizes, J, bounds)
    for f in range(first, last):
        slot, function = code.function_slots[f], code.function_classes[f]
        if abs(J[slot, 0] - earlier[slot, 0]) <= COEFFICIENT_ROUNDING * bounds[slot, 0]:
            scratch.structural_zeros[function] = max(1, scratch.structural_zeros[function])


@kernel
def count_negative_as_zero(system, mode, before, scratch):
    """Count the guards of the mode that ends as zero if they were negative before the event: by rounding.

    Bodies that touch may do so for long, at distances that grow by the rounding errors of their velocities.
    """
    code, J = system.code, scratch.values
    mode_jets(code, system.numbers, mode, 0, before, J)
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if J[code.function_slots[g], 0] < 0.0:
            function = code.function_classes[g]
            scratch.structural_zeros[function] = max(1, scratch.structural_zeros[function])


@inlined
def forget_zeros(scratch):
    """Note that no function vanishes by construction."""
    for i in range(scratch.structural_zeros.shape[0]):
        scratch.structural_zeros[i] = 0
    scratch.ended[0] = NO_MODE


@inlined
def zeros_by_construction(code, scratch, f):
    """How many leading coefficients of a function vanish after the last reset."""
    zeros = scratch.structural_zeros[code.function_classes[f]]
    return max(zeros, scratch.ended[1]) if f == scratch.ended[0] else zeros


@inlined
def admissibility(system, mode, rounding, orders, scratch):
    """Whether a mode can be entered, judged by its Taylor coefficients in `scratch` up to the highest of
    `orders`; below the lowest, the bounds of the coefficients are known.

    Its flow must have a value, its constraints must be met up to rounding, and the first non-zero coefficient
    of every guard must be positive.  If a guard has none up to `order`, the matter is undecided.

    A guard that is zero and falls is at another event.  If it is zero by construction after the last event,
    the mode is refused instead.  There is one exception: an impact may close a contact that was at rest,
    which then has an impact of its own.  Writes how many leading coefficients of each guard are zero.
    """
    code, J, bounds = system.code, scratch.jets, scratch.bounds
    lowest, order = orders
    if code.quotients[mode]:  # the bounds of values, column 0, were made sharper since
        lowest = 0
    sizes = scratch.impacts.total
    low_majorant(code, system.magnitudes, mode, (lowest, order), rounding.sizes, sizes, J, bounds)
    if first_order_bounds(code, system.magnitudes, mode, J, bounds):
        return REFUSED
    for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
        slot, zeros = code.function_slots[f], zeros_by_construction(code, scratch, f)
        if zeros == 0 and leading_order(J[slot], bounds[slot], 0, order, rounding.share) == 0:
            return REFUSED
    verdict = ADMITTED
    first = code.mode_guards[mode]
    for g in range(first, code.mode_guards[mode + 1]):
        slot, zeros = code.function_slots[g], zeros_by_construction(code, scratch, g)
        k = leading_order(J[slot], bounds[slot], zeros, order, rounding.share)
        scratch.leading_zeros[g - first] = k
        if k > order:
            verdict = min(verdict, UNDECIDED)
        elif J[slot, k] < 0.0:
            if k == 0 or (zeros > 0 and not (k == 1 and is_impact(code, g))):
                return REFUSED
            verdict = AT_ANOTHER_EVENT
    return verdict


@kernel
def try_mode(system, mode, z, rounding, likely, order, scratch):
    """Whether a mode can be entered at `z`; if so, leaves all its jets in `scratch`.

    Values alone refuse most modes, and a low order decides nearly all others; if the mode is the `likely`
    one, it is examined at once.  Jets of all orders take ten times as long.  They are computed only for a
    mode that a low order admits or leaves undecided.
    """
    verdict, at_hand, examined = UNDECIDED, -1, -1
    code, J, low = system.code, scratch.jets, min(LOW_ORDER, order)
    for upto in (low if likely else 0, low, order):
        if upto > at_hand:
            at_hand = order if verdict == ADMITTED else upto
            mode_jets(code, system.numbers, mode, at_hand, z, J)
        if verdict == UNDECIDED:
            verdict = admissibility(system, mode, rounding, (examined + 1, upto), scratch)
            examined = upto
        if verdict < UNDECIDED:
            break
    return verdict


@kernel
def try_mode_by_values(system, mode, z, rounding, scratch):
    """Whether the conditions of a mode hold at `z` by their values; those that the event made zero do.

    But a distance that an impact made zero falls at once where its rate or its acceleration says so.
    """
    code, J = system.code, scratch.jets
    mode_jets(code, system.numbers, mode, LOW_ORDER, z, J)
    majorant(code, system.magnitudes, mode, LOW_ORDER, rounding.sizes, J, scratch.bounds)
    if first_order_bounds(code, system.magnitudes, mode, J, scratch.bounds):
        return REFUSED
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        zeros = zeros_by_construction(code, scratch, g)
        if zeros == 0 and J[code.function_slots[g], 0] < 0.0:
            return REFUSED
        if zeros > 0 and is_impact(code, g) and has_failed(system, g, rounding, LOW_ORDER, scratch):
            return REFUSED
    for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
        slot, zeros = code.function_slots[f], zeros_by_construction(code, scratch, f)
        if zeros == 0 and abs(J[slot, 0]) > rounding.share * scratch.bounds[slot, 0]:
            return REFUSED
    return ADMITTED


@kernel
def select_mode(system, candidates, z, rounding, order, scratch):
    """First admissible mode of `candidates` at `z`, a :class:`Selection`; leaves its jets in `scratch`.

    A guard that vanishes identically stays zero, so it does not end the mode.  If several events fall on one
    instant, there may be no admissible mode after the first of them.  Then the first mode that is at another
    event is entered, and that event ends it at once.
    """
    passed = NO_MODE
    for i in range(candidates.shape[0]):
        mode = candidates[i]
        verdict = try_mode(system, mode, z, rounding, i == 0, order, scratch)
        if verdict > AT_ANOTHER_EVENT:
            return Selection(mode, NO_MODE)
        if verdict == AT_ANOTHER_EVENT and passed == NO_MODE:
            passed = mode
    return enter_passed(system, passed, z, rounding, order, scratch)


@inlined
def enter_passed(system, passed, z, rounding, order, scratch):
    """Select a mode that is at another event, if there is one; leaves its jets in `scratch`."""
    if passed != NO_MODE:
        mode_jets(system.code, system.numbers, passed, order, z, scratch.jets)
        admissibility(system, passed, rounding, (0, order), scratch)
    return Selection(passed, NO_MODE)


UNKNOWN = -(2**31)  # a combination that is not derived, so that it is not known whether it is a mode


@kernel
def find_mode(demand, combination):
    """Number of the mode of a combination; UNKNOWN where it is not yet derived.

    Where it is none, minus the number of its leading regimes that exclude each other.
    """
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
def insert_candidate(queue, place, row, count):
    """Put a combination at a place in the queue of `count`, or move it there from further back.

    Returns the new count.  Where no room is left the last one is dropped.
    """
    rows, at = queue.rows, 0
    while at < count:
        same = True
        for i in range(row.shape[0]):
            if rows[at, i] != row[i]:
                same = False
                break
        if same:
            break
        at += 1
    if at < place or place == rows.shape[0]:
        return count
    at = min(at, rows.shape[0] - 1)
    for k in range(at, place, -1):
        copy_vector(rows[k - 1], rows[k])
    copy_vector(row, rows[place])
    return max(count, at + 1)


@kernel
def insert_targets(queue, place, guard, count):
    """Put the targets of a guard's event at a place in the queue of `count`; the new count."""
    demand = queue.demand
    for k in range(demand.listed[guard + 1] - 1, demand.listed[guard] - 1, -1):
        count = insert_candidate(queue, place, demand.targets[k], count)
    return count


@kernel
def has_failed(system, guard, rounding, order, scratch):
    """Whether a guard keeps its mode, whose jets are in `scratch`, from being entered."""
    zeros, J = zeros_by_construction(system.code, scratch, guard), scratch.jets
    slot = system.code.function_slots[guard]
    k = leading_order(J[slot], scratch.bounds[slot], zeros, order, rounding.share)
    return k <= order and J[slot, k] < 0.0


@kernel
def is_at_zero(code, guard, rounding, scratch):
    """Whether a guard is zero up to rounding at this instant."""
    slot = code.function_slots[guard]
    return leading_order(scratch.jets[slot], scratch.bounds[slot], 0, 0, rounding.share) > 0


@kernel
def is_allowed(queue, combination):
    """Whether the conditions of all regimes of a combination allow it."""
    refused = 0
    for i in range(combination.shape[0]):
        if queue.allowed[queue.demand.regimes[i] + combination[i]] == 0:
            refused += 1
    return refused == 0


@kernel
def add_change(queue, guard, row, joint):
    """Make in `joint` the changes to the combination `row` by the event of a guard: those of its first target
    that the conditions of all regimes allow."""
    demand = queue.demand
    for k in range(demand.listed[guard], demand.listed[guard + 1]):
        target = demand.targets[k]
        if is_allowed(queue, target):
            for i in range(row.shape[0]):
                if target[i] != row[i]:
                    joint[i] = target[i]
            break


@kernel
def changes_all(queue, failed):
    """Whether to make the changes of all `failed` guards at once: fewer fail, or may soon do so."""
    progress = queue.progress
    if failed < progress[0]:
        progress[0], progress[1] = failed, JOINT_TRIALS
    elif progress[1] > 0:
        progress[1] -= 1
    else:
        return False
    return True


@kernel
def insert_pivots(system, queue, mode, tried, own, rounding, order, scratch, count):
    """Queue the targets of the events that keep the mode tried last from being entered; the new count.

    The combination with the changes of all these events comes next, then those with the change of one.  The
    first `own` combinations are the targets of the event itself.  They are tried before all these, as another
    contact leaves stick only if it has to, unless another event falls on this instant.
    """
    code, row, joint = system.code, queue.rows[tried - 1], queue.missing
    copy_vector(row, joint)
    place, failed, first, last = max(tried, own), 0, code.mode_guards[mode], code.mode_guards[mode + 1]
    for g in range(first, last):
        if has_failed(system, g, rounding, order, scratch):
            failed += 1
            add_change(queue, g, row, joint)
            if zeros_by_construction(code, scratch, g) == 0 and is_at_zero(code, g, rounding, scratch):
                place = tried
    for i in range(row.shape[0]):
        if tried < own and joint[i] != row[i] and queue.rows[tried, i] != row[i]:
            place = own
    for g in range(last - 1, first - 1, -1):
        if has_failed(system, g, rounding, order, scratch):
            count = insert_targets(queue, max(tried, own), g, count)
    if failed > 0 and (tried <= own or changes_all(queue, failed)):
        count = insert_candidate(queue, place, joint, count)
    return count


@kernel
def mark_regimes(system, queue, z, rounding, scratch):
    """Note for each regime of each part whether its conditions allow a mode with it at `z`."""
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
    regimes, kept = queue.demand.regimes, queue.kept
    for i in range(kept.shape[0]):
        for r in range(regimes[i], regimes[i + 1]):
            if kept[i] != NO_REGIME and r != regimes[i] + kept[i]:
                allowed[r] = 0


@kernel
def keep_regimes(queue, mode, guard):
    """Note that the regimes of a mode which the event of a guard changes are kept until then."""
    demand = queue.demand
    for k in range(demand.modes.shape[0]):
        if demand.modes[k] == mode:
            row = demand.combinations[k]
            for t in range(demand.listed[guard], demand.listed[guard + 1]):
                for i in range(row.shape[0]):
                    if demand.targets[t, i] != row[i]:
                        queue.kept[i] = row[i]


@inlined
def awaits_impact(queue):
    """Whether an impact is still to come at this instant."""
    awaits = False
    for i in range(queue.kept.shape[0]):
        awaits = awaits or queue.kept[i] != NO_REGIME
    return awaits


@kernel
def next_allowed(queue, leading):
    """Move ``queue.place`` to the next allowed combination in which one of the `leading` regimes differs.

    To the first where `leading` is 0.  Returns False where there is none.
    """
    place, allowed, regimes = queue.place, queue.allowed, queue.demand.regimes
    i = max(leading - 1, 0)
    place[leading:] = -1
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
        return try_mode_by_values(system, mode, z, rounding, scratch)
    return try_mode(system, mode, z, rounding, False, order, scratch)


@kernel
def select_combination(system, queue, guard, z, rounding, order, scratch):
    """First admissible mode after the event of a guard, or at a start (NO_MODE): a :class:`Selection`.

    Otherwise as :func:`select_mode`.  The combination of a missing mode is left in ``queue.missing``.  Where
    an impact is still to come at this instant, the first mode is entered that this impact ends at once.
    """
    rows, parts, leading, passed = queue.rows, queue.place.shape[0], 0, NO_MODE
    own = 0 if guard == NO_MODE else insert_targets(queue, 0, guard, 0)
    count, tried, awaits = own, 0, awaits_impact(queue)
    marked = awaits
    if awaits:
        mark_regimes(system, queue, z, rounding, scratch)
    queue.progress[0], queue.progress[1] = rows.shape[0], 0
    while tried < rows.shape[0]:
        mode = find_mode(queue.demand, rows[tried]) if tried < count else UNKNOWN
        if mode == UNKNOWN and not marked:
            mark_regimes(system, queue, z, rounding, scratch)
            marked = True
        while tried == count:
            if not next_allowed(queue, leading):
                return enter_passed(system, passed, z, rounding, order, scratch)
            mode = find_mode(queue.demand, queue.place)
            leading = -mode if UNKNOWN < mode < 0 else parts
            if leading == parts:
                count = insert_candidate(queue, count, queue.place, count)
        tried += 1
        if mode == UNKNOWN and is_allowed(queue, rows[tried - 1]):
            copy_vector(rows[tried - 1], queue.missing)
            return Selection(NO_MODE, MISSING)
        if mode < 0 or (awaits and not is_allowed(queue, rows[tried - 1])):
            continue
        verdict = try_candidate(system, mode, z, rounding, order, scratch)
        if verdict > AT_ANOTHER_EVENT:
            return Selection(mode, NO_MODE)
        if verdict == AT_ANOTHER_EVENT and passed == NO_MODE:
            passed = mode
            if awaits:
                break
        if not marked:
            mark_regimes(system, queue, z, rounding, scratch)
            marked = True
        mode_jets(system.code, system.numbers, mode, order, z, scratch.jets)
        majorant(system.code, system.magnitudes, mode, order, rounding.sizes, scratch.jets, scratch.bounds)
        count = insert_pivots(system, queue, mode, tried, own, rounding, order, scratch, count)
    return enter_passed(system, passed, z, rounding, order, scratch)
