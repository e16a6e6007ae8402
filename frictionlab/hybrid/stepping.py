"""The solver's loop: step by Taylor polynomial, event, reset, next mode; all in one kernel.

It runs until the end, an end that is an error, or a full buffer, after which it can be called again.
"""

from __future__ import annotations

from frictionlab.hybrid.bookkeeping import (
    END,
    EVENTS,
    FINISHED,
    MODE,
    NOT_FINITE,
    NOW,
    POINTS,
    READY,
    RUNNING,
    STEPS,
    pass_time,
    time_left,
)
from frictionlab.hybrid.compiled import inlined, kernel
from frictionlab.hybrid.guards import NO_GUARD, at_zero, first_event, is_inexact
from frictionlab.hybrid.handling import handle_event, repeated
from frictionlab.hybrid.jets import copy, mode_jets, states_at
from frictionlab.hybrid.powers import (
    FEWEST,
    is_near_zero,
    onset_step,
    scale_of_powers,
    series_near_zero,
    unresolved_time,
    without_series,
)
from frictionlab.hybrid.remainder import is_blind, polynomials_visible, remainder_step
from frictionlab.hybrid.riders import record_sections
from frictionlab.hybrid.step_length import function_step, step_length


@inlined
def note_sizes(start, cursor):
    """Note what the state's rounding errors are relative to, after a step from `start`."""
    for i in range(start.shape[0]):
        cursor.sizes[i] = max(abs(start[i]), abs(cursor.state[i]))


CLOCK = 1e-15  # share of the time that the clock shows as some of its last digits


@kernel
def step_near_zero(code, numbers, absolute, order, tol, mode, left, cursor, work):
    """Length of a step in which the base of a power is nearly zero; may change the jets."""
    J, z = work.jets, cursor.state
    scale = scale_of_powers(code, mode, J)
    onset = 0.0
    if without_series(code, order, mode, J):
        onset = onset_step(code, numbers, order, tol, mode, left, J, work)
    unresolved = unresolved_time(code, absolute, mode, z, J, work.bounds)
    h = min(left, max(onset, unresolved, CLOCK * cursor.times[NOW]))
    few = series_near_zero(code, numbers, mode, order, z, h > scale, J)
    if few < FEWEST:
        return h
    return remainder_step(code, numbers, absolute, few, tol, mode, min(left, scale), False, J, work.bounds)


@inlined
def take_step(code, numbers, absolute, order, tol, cursor, record, work):
    """One step, up to an event if there is one; returns how the run goes on."""
    times, counts, J = cursor.times, cursor.counts, work.jets
    mode = counts[MODE]
    if counts[READY] == 0:
        mode_jets(code, numbers, mode, order, cursor.state, J)
        for g in range(work.zeros.shape[0]):
            work.zeros[g] = 0
    counts[READY] = 0
    left = time_left(times)
    h = step_length(code, order, tol, J)
    if not h > 0.0:
        return NOT_FINITE
    h = function_step(code, order, tol, mode, min(h, left), J)
    if code.powers[mode] and is_near_zero(code, order, mode, J):
        h = step_near_zero(code, numbers, absolute, order, tol, mode, left, cursor, work)
    elif is_blind(code, order, mode, h, left):
        visible = polynomials_visible(code, order, mode, h, left)
        h = remainder_step(code, numbers, absolute, order, tol, mode, h, visible, J, work.bounds)
    goes_on = False
    h, guard, multiplicity = first_event(code, absolute, mode, cursor.state, order, J, work.zeros, h, work)
    if guard != NO_GUARD and multiplicity == 1 and is_inexact(code, guard, mode, order, h, J):
        h = at_zero(code, numbers, absolute, mode, guard, order, h, work)
        if h > left:  # not within this run
            h, guard = left, NO_GUARD
    if h > 0.0:
        row = counts[STEPS]
        record.step_times[row, 0] = times[NOW]
        record.step_times[row, 1] = h
        record.step_modes[row] = mode
        copy(cursor.state, record.step_states[row])
        counts[STEPS] += 1
        if code.sections.shape[1]:
            record_sections(code, order, mode, h, cursor, record, work)
        states_at(J, order, h, cursor.state)
        goes_on = pass_time(times, h, left)
        if guard != NO_GUARD:
            note_sizes(record.step_states[row], cursor)
    if guard == NO_GUARD:
        return RUNNING if goes_on else repeated(counts)
    return handle_event(code, numbers, absolute, guard, multiplicity, order, tol, cursor, record, work)


@kernel
def advance(code, numbers, absolute, order, tol, cursor, record, work):
    """Run until the end, an error, or until a buffer may be full (RUNNING)."""
    times, counts = cursor.times, cursor.counts
    room = record.point_times.shape[0] - (order + 2) * code.sections.shape[1]
    while times[NOW] < times[END]:
        full = counts[STEPS] == record.step_modes.shape[0] or counts[EVENTS] == record.event_times.shape[0]
        if full or counts[POINTS] > room:
            return RUNNING
        status = take_step(code, numbers, absolute, order, tol, cursor, record, work)
        if status != RUNNING:
            return status
    return FINISHED
