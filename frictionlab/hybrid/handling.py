"""What is done at an event: the reset, the next mode, and the limit that events too dense come to."""

from __future__ import annotations

from frictionlab.hybrid.bookkeeping import (
    ACCUMULATED,
    CHATTER,
    CLOSED,
    DWELL,
    ENTERED,
    EVENTS,
    MODE,
    NO_ADMISSIBLE_MODE,
    NOW,
    RAISES,
    READY,
    REPEATED,
    RUNNING,
    SHORT,
    SHORT_FLIGHTS,
    STALLED,
)
from frictionlab.hybrid.compiled import inlined, kernel
from frictionlab.hybrid.guards import NOISE
from frictionlab.hybrid.jets import copy
from frictionlab.hybrid.step_length import SLACK
from frictionlab.hybrid.transitions import NO_MODE, Rounding, apply_reset, enter

REPEATS = 50  # events or steps without advance of time after which the run is called stalled


@inlined
def still_running(counts):
    """How a run goes on after events, or steps, that the clock does not show."""
    return STALLED if counts[REPEATED] > REPEATS else RUNNING


@kernel
def repeated(counts):
    """The same after one step more."""
    counts[REPEATED] += 1
    return still_running(counts)


@kernel
def in_a_row(code, guard, limit, count, cursor):
    """Whether the mode that ends lasted less than a limit, and the one before it; counts on."""
    times, counts = cursor.times, cursor.counts
    if times[NOW] - times[ENTERED] >= max(times[limit], 1e-15 * abs(times[NOW])):
        counts[count] = 0
    elif code.resets[guard, 1] != code.resets[guard, 0]:
        counts[count] += 1
    if counts[count] < 2:
        return False
    counts[count] = 0
    return True


@kernel
def enter_limit(code, numbers, absolute, guard, order, cursor, work):
    """Enter what the events come to, if that is admissible; else leave the state, and return NO_MODE."""
    z, before = cursor.state, work.before
    copy(z, before)
    apply_reset(code, numbers, code.resets[guard, 1], z, work.jets)
    copy(code.declared[guard, 1], work.declared)
    rounding = Rounding(z, NOISE)
    arrays = work.declared, work.zeros, work.jets, work.bounds
    mode = enter(code, numbers, absolute, code.limits, z, rounding, order, *arrays)
    if mode == NO_MODE:
        copy(before, z)
    return mode


@kernel
def close_event(code, numbers, absolute, guard, multiplicity, order, tol, cursor, work):
    """Reset the state after the guard's event and enter the next mode; returns (mode, closed)."""
    closing = 0
    if len(code.limits) and in_a_row(code, guard, CHATTER, SHORT_FLIGHTS, cursor):
        mode = enter_limit(code, numbers, absolute, guard, order, cursor, work)
        if mode != NO_MODE:
            return mode, 1
    if in_a_row(code, guard, DWELL, SHORT, cursor):
        closing = 1
    apply_reset(code, numbers, code.resets[guard, closing], cursor.state, work.jets)
    copy(code.declared[guard, closing], work.declared)
    if code.resets[guard, closing] < 0:
        work.declared[guard] = max(work.declared[guard], multiplicity)
    next_, z = code.targets[guard], cursor.state
    arrays = work.declared, work.zeros, work.jets, work.bounds
    mode = enter(code, numbers, absolute, next_, z, Rounding(z, NOISE), order, *arrays)
    if mode == NO_MODE:  # another event at this instant? Its guard is zero up to the rounding of the step
        mode = enter(code, numbers, absolute, next_, z, Rounding(cursor.sizes, NOISE), order, *arrays)
    if mode == NO_MODE:  # or up to what the step leaves out
        left_out = Rounding(cursor.sizes, max(NOISE, SLACK * tol))
        mode = enter(code, numbers, absolute, next_, z, left_out, order, *arrays)
    return mode, closing


@kernel
def handle_event(code, numbers, absolute, guard, multiplicity, order, tol, cursor, record, work):
    """Record the event, change the mode; returns how the run goes on.

    `tol` is the share of the states by which the steps may miss the event.
    """
    times, counts = cursor.times, cursor.counts
    row = counts[EVENTS]
    record.event_times[row] = times[NOW]
    copy(cursor.state, record.event_states[row, 0])
    mode, closed = close_event(code, numbers, absolute, guard, multiplicity, order, tol, cursor, work)
    if mode < NO_MODE:  # a mode is to be derived first, as if the event were yet to happen
        copy(record.event_states[row, 0], cursor.state)
        return mode
    record.event_codes[row, 0] = guard
    record.event_codes[row, 1] = mode
    record.event_codes[row, 2] = closed
    copy(cursor.state, record.event_states[row, 1])
    counts[EVENTS] += 1
    counts[CLOSED] += closed
    counts[REPEATED] = 0 if times[NOW] > times[ENTERED] else counts[REPEATED] + 1
    times[ENTERED] = times[NOW]
    if mode == NO_MODE:
        return NO_ADMISSIBLE_MODE
    counts[MODE] = mode
    counts[READY] = 1
    if closed and counts[RAISES]:
        return ACCUMULATED
    return still_running(counts)
