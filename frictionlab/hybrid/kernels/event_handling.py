"""What is done at an event: it is recorded, the state is reset, the next mode entered; Zeno points are
closed.

Events that follow each other within less than a dwell time, twice in a row, are taken for a Zeno
accumulation, infinitely many in finite time: the closing reset is applied, and the automaton's limit mode
entered if it has one that is admissible.
"""

from __future__ import annotations

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.jets import copy_vector
from frictionlab.hybrid.kernels.mode_selection import NO_MODE, Rounding, apply_reset, select_mode
from frictionlab.hybrid.kernels.run_state import (
    CHATTER,
    DWELL,
    ENTERED,
    EVENTS,
    JETS_READY,
    MODE,
    NO_ADMISSIBLE_MODE,
    NOW,
    REPEATED,
    RUNNING,
    SHORT_DWELLS,
    SHORT_FLIGHTS,
    STALLED,
    STOPS_AT_ZENO,
    ZENO,
    ZENO_COUNT,
)
from frictionlab.hybrid.kernels.step_length import FUNCTION_TOL_FACTOR

MAX_REPEATS = 50  # events or steps without advance of time after which the run is called stalled


@inlined
def status_after_repeat(counts):
    """Status of a run after an event or step that does not advance the clock: stalled after too many of
    them."""
    return STALLED if counts[REPEATED] > MAX_REPEATS else RUNNING


@kernel
def count_repeat(counts):
    """The same after one step more."""
    counts[REPEATED] += 1
    return status_after_repeat(counts)


@kernel
def is_zeno(code, guard, limit, count, cursor):
    """Whether the stay that ends and the one before it were both shorter than a dwell time; updates the
    counts."""
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
def select_limit_mode(code, numbers, absolute, guard, order, cursor, work):
    """Enter the limit mode, if it is admissible; else leave the state, and return NO_MODE."""
    z, before = cursor.state, work.before
    copy_vector(z, before)
    apply_reset(code, numbers, code.resets[guard, 1], z, work.jets)
    copy_vector(code.declared[guard, 1], work.declared)
    rounding = Rounding(z, COEFFICIENT_ROUNDING)
    arrays = work.declared, work.zeros, work.jets, work.bounds
    mode = select_mode(code, numbers, absolute, code.limits, z, rounding, order, *arrays)
    if mode == NO_MODE:
        copy_vector(before, z)
    return mode


@kernel
def reset_and_select_mode(code, numbers, absolute, guard, multiplicity, order, tol, cursor, work):
    """Reset the state after the guard's event and enter the next mode; returns (mode, closed)."""
    closing = 0
    if len(code.limits) and is_zeno(code, guard, CHATTER, SHORT_FLIGHTS, cursor):
        mode = select_limit_mode(code, numbers, absolute, guard, order, cursor, work)
        if mode != NO_MODE:
            return mode, 1
    if is_zeno(code, guard, DWELL, SHORT_DWELLS, cursor):
        closing = 1
    apply_reset(code, numbers, code.resets[guard, closing], cursor.state, work.jets)
    copy_vector(code.declared[guard, closing], work.declared)
    if code.resets[guard, closing] < 0:
        work.declared[guard] = max(work.declared[guard], multiplicity)
    next_, z = code.targets[guard], cursor.state
    arrays = work.declared, work.zeros, work.jets, work.bounds
    mode = select_mode(code, numbers, absolute, next_, z, Rounding(z, COEFFICIENT_ROUNDING), order, *arrays)
    if mode == NO_MODE:  # another event at this instant? Its guard is zero up to the rounding of the step
        mode = select_mode(
            code, numbers, absolute, next_, z, Rounding(cursor.sizes, COEFFICIENT_ROUNDING), order, *arrays
        )
    if mode == NO_MODE:  # or up to what the step leaves out
        left_out = Rounding(cursor.sizes, max(COEFFICIENT_ROUNDING, FUNCTION_TOL_FACTOR * tol))
        mode = select_mode(code, numbers, absolute, next_, z, left_out, order, *arrays)
    return mode, closing


@kernel
def handle_event(code, numbers, absolute, guard, multiplicity, order, tol, cursor, record, work):
    """Record the event and change the mode; returns the status of the run.

    `tol` is the share of the states by which the steps may miss the event.
    """
    times, counts = cursor.times, cursor.counts
    row = counts[EVENTS]
    record.event_times[row] = times[NOW]
    copy_vector(cursor.state, record.event_states[row, 0])
    mode, closed = reset_and_select_mode(
        code, numbers, absolute, guard, multiplicity, order, tol, cursor, work
    )
    if mode < NO_MODE:  # a mode is to be derived first, as if the event were yet to happen
        copy_vector(record.event_states[row, 0], cursor.state)
        return mode
    record.event_codes[row, 0] = guard
    record.event_codes[row, 1] = mode
    record.event_codes[row, 2] = closed
    copy_vector(cursor.state, record.event_states[row, 1])
    counts[EVENTS] += 1
    counts[ZENO_COUNT] += closed
    counts[REPEATED] = 0 if times[NOW] > times[ENTERED] else counts[REPEATED] + 1
    times[ENTERED] = times[NOW]
    if mode == NO_MODE:
        return NO_ADMISSIBLE_MODE
    counts[MODE] = mode
    counts[JETS_READY] = 1
    if closed and counts[STOPS_AT_ZENO]:
        return ZENO
    return status_after_repeat(counts)
