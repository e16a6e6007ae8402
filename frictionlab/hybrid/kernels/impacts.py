"""Impacts at one instant: which of them comes first, which act together, and which is the last.

An event with a reset that closes a Zeno accumulation is an impact: its guard closes, and its reset turns the
guard's rate.  Impacts at one instant are a sequence, which goes on until no guard closes; time stands still
meanwhile.  So touching bodies do what bodies with small gaps do, where this does not depend on the gaps.

Where several guards close at once, the impact whose jump has the greatest kinetic energy comes first.  Those
that are equally great act together, by the impulses after which each guard has the rate that its own reset
gives it, if all these impulses push.  So the order in which guards are listed does not matter, symmetric
motions stay symmetric, and energy never grows: with closing rates g >= 0, impulses L >= 0 and restitution e
it changes by -L (1 - e) g / 2, summed over the impacts.

The energies are compared without masses.  With the compliances G and the impulse L_i of impact i alone, its
reset changes the rate of guard j by R_ji = G_ji L_i, and its jump has the energy L_i G_ii L_i / 2.  So
(R_ii R_ji) / (R_jj R_ij) is the ratio of the energies of impacts i and j.  If R_ij = 0 the order does not
matter.

The sequence may be infinite, as for a body between two others with e < 1.  Its limit is reached when closing
rates are rounding errors of the velocities.  Then the resets that close an accumulation end it.  They also
end an accumulation in time, in which a contact's own acceleration brings it back in flights shorter than a
limit.  Other impacts within that time, across small gaps, stay as they are.

Impacts of several contacts accumulate together: gaps, rates and time scale as L^2, L and L, so that all end
at one instant.  Then all contacts of this group are closed: those that the mode holds, and those in flight
whose gap and rate are explained by their accelerations in such short flights.  Which of them stay closed, the
next order decides.
"""

from __future__ import annotations

import math

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.jets import copy_vector, low_majorant, mode_jets
from frictionlab.hybrid.kernels.mode_selection import (
    add_zeros_by_construction,
    apply_event_reset,
    apply_reset,
    forget_zeros,
    is_impact,
    keep_regimes,
    set_zeros_by_construction,
)
from frictionlab.hybrid.kernels.run_state import (
    CLOCK_RESOLUTION,
    ENTERED,
    EVENTS,
    MODE,
    NOW,
    RESOLUTION,
    SHORT_DWELLS,
)
from frictionlab.hybrid.kernels.step_length import FUNCTION_TOL_FACTOR

EQUAL_SHARE = 1e-9  # share within which two impacts are equally great
COUPLED_SHARE = 1e-20  # squared cosine of the angle between two guards above which they are coupled
PIVOT_SHARE = 1e-9  # of impulses with the same effect, which have smaller pivots, one is enough
MAX_SWEEPS = 1000  # times that all contacts are closed in turn
SHORT_STAY = 64.0  # times what the clock resolves; rates after such stays are nearly rounding errors
FLIGHTS = 4.0  # a flight of one contact may consist of several stays, between events of others


@inlined
def has_several_impacts(code, mode):
    """Whether several guards of a mode have impacts."""
    count = 0
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if is_impact(code, g):
            count += 1
    return count > 1


@inlined
def stay_limit(run):
    """The time up to which a stay is taken for part of a Zeno accumulation: the clock hardly resolves it, or
    states do not, as series do."""
    return max(SHORT_STAY * CLOCK_RESOLUTION * run.times[NOW], run.times[RESOLUTION])


@inlined
def is_short(run):
    """Whether the stay that ends may be part of a Zeno accumulation."""
    return run.times[NOW] - run.times[ENTERED] <= stay_limit(run)


@kernel
def linearise_guards(system, run, scratch):
    """Rates and accelerations of the guards at the event, and the bounds of their rounding errors.

    These are relative to the velocities of all impacts at this instant.
    """
    mode, J = run.counts[MODE], scratch.jets
    for i in range(run.state.shape[0]):
        run.sizes[i] = max(run.sizes[i], abs(run.state[i]))
    mode_jets(system.code, system.numbers, mode, 2, run.state, J)
    magnitudes, sizes = system.magnitudes, scratch.impacts.total
    low_majorant(system.code, magnitudes, mode, (0, 2), run.sizes, sizes, J, scratch.bounds)


@kernel
def note_resolution(system, guard, run, scratch):
    """Note the shortest flight that states resolve before an impact, 0 before another event.

    In a shorter one the distance falls by less than its rounding error, so that flights in an accumulation
    are no shorter.
    """
    resolution = 0.0
    if is_impact(system.code, guard):
        linearise_guards(system, run, scratch)
        slot = system.code.function_slots[guard]
        fall = -scratch.jets[slot, 2]
        if fall > 0.0:
            resolution = math.sqrt(COEFFICIENT_ROUNDING * scratch.bounds[slot, 0] / fall)
    run.times[RESOLUTION] = resolution


@inlined
def is_rounding(code, guard, scratch):
    """Whether the closing rate of an impact is a rounding error."""
    slot = code.function_slots[guard]
    return abs(scratch.jets[slot, 1]) <= COEFFICIENT_ROUNDING * scratch.bounds[slot, 1]


@inlined
def ends_short_flight(code, guard, run, scratch):
    """Whether the guard's own acceleration explains the closing rate, in a flight as short as the limit."""
    c = scratch.jets[code.function_slots[guard]]
    return -c[1] <= -FLIGHTS * c[2] * stay_limit(run)


@kernel
def write_closing(count, run, code, scratch):
    """Write which impacts close an accumulation.

    The stay before them was short.  Besides, their rate is a rounding error, or it is that of a short flight
    and so was the rate of the impact before.
    """
    impacts, counts = scratch.impacts, run.counts
    short = is_short(run)
    again = counts[SHORT_DWELLS] > 0
    if not short:
        counts[SHORT_DWELLS] = 0
    for i in range(count):
        guard, impacts.closing[i] = impacts.guards[i], 0
        if short and ends_short_flight(code, guard, run, scratch):
            counts[SHORT_DWELLS] = 1
            impacts.closing[i] = again
        if short and is_rounding(code, guard, scratch):
            impacts.closing[i] = 1
    for i in range(count):
        if impacts.closing[i]:
            counts[SHORT_DWELLS] = 0


@inlined
def is_zero(code, guard, tol, scratch):
    """Whether a guard is zero up to rounding, or up to the remainder of the step."""
    slot, share = code.function_slots[guard], max(COEFFICIENT_ROUNDING, FUNCTION_TOL_FACTOR * tol)
    return abs(scratch.jets[slot, 0]) <= share * scratch.bounds[slot, 0]


@kernel
def write_closing_guards(system, guard, tol, run, scratch):
    """Write the guards whose impacts are at this instant, first that of the event; returns how many."""
    code, mode, guards, count = system.code, run.counts[MODE], scratch.impacts.guards, 1
    guards[0] = guard
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        closes = scratch.jets[slot, 1] < -COEFFICIENT_ROUNDING * scratch.bounds[slot, 1]
        if g != guard and is_impact(code, g) and closes and is_zero(code, g, tol, scratch):
            guards[count] = g
            count += 1
    return count


@kernel
def write_rate_changes(system, count, run, scratch):
    """Write in ``rates[j, i]`` by how much the impact i alone changes the rate of guard j."""
    code, J, z, impacts = system.code, scratch.jets, scratch.states, scratch.impacts
    guards, rates = impacts.guards, impacts.rates
    for j in range(count):
        rates[j, count] = J[code.function_slots[guards[j]], 1]
    for i in range(count):
        copy_vector(run.state, z)
        apply_reset(system, code.resets[guards[i], impacts.closing[i]], z, J)
        mode_jets(code, system.numbers, run.counts[MODE], 1, z, J)
        for j in range(count):
            rates[j, i] = J[code.function_slots[guards[j]], 1] - rates[j, count]


@inlined
def is_greater(rates, count, j, i):
    """Whether impact j is coupled with impact i, and its jump has the greater energy.

    What impact i does to the rate of guard j may be lost in the rounding of that rate, where impact j is far
    greater.  It is no more than that rounding then.
    """
    change = abs(rates[j, i]) + COEFFICIENT_ROUNDING * abs(rates[j, count])
    one, other = abs(rates[i, i]) * change, abs(rates[j, j] * rates[i, j])
    coupled = abs(rates[i, j]) * change > COUPLED_SHARE * abs(rates[i, i] * rates[j, j])
    return coupled and other > (1.0 + EQUAL_SHARE) * one


@kernel
def choose_greatest(count, impacts):
    """Leave out the impacts that are coupled with a greater one; returns how many are left."""
    rates, places, left = impacts.rates, impacts.places, 0
    for i in range(count):
        beaten = False
        for j in range(count):
            beaten = beaten or is_greater(rates, count, j, i)
        if not beaten:
            places[left] = i
            left += 1
    for i in range(left):  # rows and columns move up
        impacts.guards[i] = impacts.guards[places[i]]
        impacts.closing[i] = impacts.closing[places[i]]
        for j in range(left):
            rates[i, j] = rates[places[i], places[j]]
    return left


@kernel
def eliminate(k, count, impacts):
    """Gauss's elimination of unknown `k` from the equations below; False where it has no pivot."""
    rates, shares, place = impacts.rates, impacts.shares, k
    for i in range(k + 1, count):
        if abs(rates[i, k]) > abs(rates[place, k]):
            place = i
    if not abs(rates[place, k]) > PIVOT_SHARE * rates[k, count]:
        return False
    shares[k], shares[place] = shares[place], shares[k]
    for j in range(count):
        rates[k, j], rates[place, j] = rates[place, j], rates[k, j]
    for i in range(k + 1, count):
        factor = rates[i, k] / rates[k, k]
        shares[i] -= factor * shares[k]
        for j in range(k, count):
            rates[i, j] -= factor * rates[k, j]
    return True


@kernel
def solve_impulses(count, impacts):
    """Write the shares of their own impulses by which impacts act together; False where one would pull.

    Each guard then has the rate that its own reset gives it.  An impulse with the effect of others is left
    out.
    """
    rates, shares, places = impacts.rates, impacts.shares, impacts.places
    for j in range(count):
        shares[j] = rates[j, j]
        rates[j, count] = abs(rates[j, j])
    for k in range(count):
        places[k] = eliminate(k, count, impacts)
    pushes = True
    for k in range(count - 1, -1, -1):
        for j in range(k + 1, count):
            shares[k] -= rates[k, j] * shares[j]
        shares[k] = shares[k] / rates[k, k] if places[k] else 0.0
        pushes = pushes and shares[k] >= 0.0
    return pushes


@kernel
def set_common_zeros(code, count, scratch):
    """Note which functions vanish after several impacts: each guard, and what all of them leave at zero."""
    guards, closing, zeros = scratch.impacts.guards, scratch.impacts.closing, scratch.structural_zeros
    set_zeros_by_construction(code, guards[0], closing[0], scratch)
    for c in range(zeros.shape[0]):
        for i in range(count):
            row, zero = 2 * guards[i] + closing[i], 0
            for k in range(code.zeros[row], code.zeros[row + 1]):
                if code.zero_classes[k] == c:
                    zero = code.zero_counts[k]
            if code.function_classes[guards[i]] == c:
                zeros[c] = zero
                break
            zeros[c] = min(zeros[c], zero)


@kernel
def apply_impacts(system, count, run, record, scratch):
    """Apply several impacts at once, each by its share; the state between any two of them is recorded.

    Coordinates have no share in an impulse: resets only take rounding errors of the distances out of them.
    """
    code, z, impacts, first = system.code, scratch.states, scratch.impacts, run.counts[EVENTS]
    total = impacts.total
    copy_vector(run.state, total)
    for i in range(count):
        copy_vector(total, record.event_states[first + i, 0])
        copy_vector(run.state, z)
        apply_reset(system, code.resets[impacts.guards[i], impacts.closing[i]], z, scratch.jets)
        for k in range(z.shape[0]):
            share = 1.0 if k < code.groups[1] else impacts.shares[i]
            total[k] += share * (z[k] - run.state[k])
        copy_vector(total, record.event_states[first + i, 1])
    copy_vector(total, run.state)
    set_common_zeros(code, count, scratch)


@kernel
def write_group(system, tol, run, scratch):
    """Write the contacts whose accumulation ends with that of the first guard; returns how many.

    Writes a guard of each, whose reset closes it, and in ``places`` the function that is its distance in the
    mode.  A contact that is held belongs to the group, and so does one in flight that may come back within
    the time in which this accumulation ends.
    """
    code, mode, impacts, count = system.code, run.counts[MODE], scratch.impacts, 1
    impacts.places[0] = impacts.guards[0]
    copy_vector(run.state, scratch.states)
    apply_reset(system, code.resets[impacts.guards[0], 1], scratch.states, scratch.values)
    mode_jets(code, system.numbers, mode, 1, scratch.states, scratch.values)
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if g != impacts.guards[0] and is_impact(code, g) and comes_back(code, g, tol, run, scratch):
            impacts.guards[count] = impacts.places[count] = g
            count += 1
    for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
        for g in range(code.resets.shape[0]):  # its impact is in other modes
            if code.function_classes[g] == code.function_classes[f] and is_impact(code, g):
                impacts.guards[count], impacts.places[count] = g, f
                count += 1
                break
    return count


@inlined
def comes_back(code, g, tol, run, scratch):
    """Whether a contact at rest, or in a flight that may be no longer than the limit, is at an accumulation.

    Its acceleration may be its own, or come from the impacts of the first guard: if they hold this at zero,
    they accelerate the other by the ratio of the rate changes, which are in ``scratch.values``.
    """
    J, values, first = scratch.jets, scratch.values, code.function_slots[scratch.impacts.guards[0]]
    slot, time = code.function_slots[g], FLIGHTS * stay_limit(run)
    acceleration = abs(J[slot, 2])
    if J[first, 1] != 0.0:
        acceleration += abs((values[slot, 1] - J[slot, 1]) / J[first, 1] * J[first, 2])
    rate = max(COEFFICIENT_ROUNDING * scratch.bounds[slot, 1], time * acceleration)
    near = J[slot, 0] <= time * time * acceleration or is_zero(code, g, tol, scratch)
    return near and abs(J[slot, 1]) <= rate


@kernel
def close_accumulation(system, tol, run, scratch):
    """Apply the reset that closes an accumulation, in turn with those of all contacts of its group.

    The rates of all of them are zero then.  Each reset changes the state by no more than the one before.
    """
    code, mode, J, impacts = system.code, run.counts[MODE], scratch.jets, scratch.impacts
    count = write_group(system, tol, run, scratch)
    for sweep in range(MAX_SWEEPS if count > 1 else 1):
        closed = False
        for i in range(count):
            if sweep > 0 or i > 0:
                mode_jets(code, system.numbers, mode, 1, run.state, J)
            if sweep == i == 0 or J[code.function_slots[impacts.places[i]], 1] != 0.0:
                apply_reset(system, code.resets[impacts.guards[i], 1], run.state, J)
                closed = True
        if not closed:
            break
    forget_zeros(scratch)
    for i in range(count):
        add_zeros_by_construction(code, impacts.guards[i], 1, scratch)


@inlined
def spread_rounding(code, reset, run):
    """Note that the coordinates which an impact may move share one rounding error.

    They do not jump.  An impact only sets the distance between them to zero, which was a rounding error.
    """
    sizes, largest = run.sizes, 0.0
    if reset >= 0:
        for i in range(code.groups[1]):
            if code.reset_out[reset, i] != i:
                largest = max(largest, sizes[i])
        for i in range(code.groups[1]):
            if code.reset_out[reset, i] != i:
                sizes[i] = max(sizes[i], largest)


@inlined
def note_touching(code, run, scratch):
    """Note which guards with impacts are zero by construction after an earlier event at this instant."""
    mode, touching, count = run.counts[MODE], scratch.impacts.touching, 0
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if is_impact(code, g):
            zero = scratch.structural_zeros[code.function_classes[g]] > 0
            touching[count] = zero and run.times[NOW] == run.times[ENTERED]
            count += 1


@inlined
def keep_touching(code, run, scratch):
    """Note that these guards are still zero: impacts move no coordinates."""
    mode, touching, count = run.counts[MODE], scratch.impacts.touching, 0
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if is_impact(code, g):
            c = code.function_classes[g]
            scratch.structural_zeros[c] = max(scratch.structural_zeros[c], touching[count])
            count += 1


@inlined
def has_acted(guard, count, impacts):
    """Whether the impact of a guard is one of those that acted last."""
    acted = False
    for i in range(count):
        acted = acted or impacts.guards[i] == guard
    return acted


@kernel
def keep_regimes_until_impacts(system, queue, tol, count, run, scratch):
    """Note which other impacts are still to come after `count` impacts, or another event, at this instant.

    Their guards are zero, or negative by rounding, and close.  The regimes that they end are kept until then:
    else the contact would close by its spring, without its impact.
    """
    code, mode, J, linearised = system.code, run.counts[MODE], scratch.jets, False
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        slot, c = code.function_slots[g], code.function_classes[g]
        if c == 0 or not is_impact(code, g) or has_acted(g, count, scratch.impacts):
            continue
        if not linearised:
            linearise_guards(system, run, scratch)
            linearised = True
        at_zero = is_zero(code, g, tol, scratch) or J[slot, 0] < 0.0
        if at_zero and not is_rounding(code, g, scratch):
            scratch.structural_zeros[c] = max(1, scratch.structural_zeros[c])
            if J[slot, 1] < 0.0:
                keep_regimes(queue, mode, g)


@inlined
def impact(system, truncation, guard, run, record, scratch):
    """Apply the greatest of the impacts at the instant of an event, or several that are equally great.

    Writes their guards into ``scratch.impacts``, and whether each closes a Zeno accumulation; returns how
    many they are.  Most impacts are alone.
    """
    code = system.code
    if is_short(run) or has_several_impacts(code, run.counts[MODE]):
        return impacts_at_instant(system, truncation, guard, run, record, scratch)
    run.counts[SHORT_DWELLS] = 0
    scratch.impacts.guards[0], scratch.impacts.closing[0] = guard, 0
    apply_event_reset(system, guard, 0, run.state, scratch)
    spread_rounding(code, code.resets[guard, 0], run)
    return 1


@kernel
def impacts_at_instant(system, truncation, guard, run, record, scratch):
    """As :func:`impact`, if there may be another impact at this instant or just before it."""
    code, impacts, count = system.code, scratch.impacts, 1
    several = has_several_impacts(code, run.counts[MODE])
    impacts.guards[0] = guard
    note_touching(code, run, scratch)
    linearise_guards(system, run, scratch)
    if several:
        count = write_closing_guards(system, guard, truncation.tol, run, scratch)
    write_closing(count, run, code, scratch)
    if count > 1:
        write_rate_changes(system, count, run, scratch)
        count = choose_greatest(count, impacts)
    if count > 1 and solve_impulses(count, impacts):
        apply_impacts(system, count, run, record, scratch)
    elif impacts.closing[0]:
        count = 1
        close_accumulation(system, truncation.tol, run, scratch)
    else:
        count = 1
        apply_event_reset(system, impacts.guards[0], 0, run.state, scratch)
    keep_touching(code, run, scratch)
    for i in range(count):
        spread_rounding(code, code.resets[impacts.guards[i], impacts.closing[i]], run)
    return count
