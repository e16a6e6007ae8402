"""The solver's loop: step by Taylor polynomial, event, reset, next mode; all in one kernel.

It runs until the end, an end that is an error, or a full buffer, after which it can be called again.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.arithmetic import exp2, log2
from frictionlab.hybrid.compiled import inlined, kernel
from frictionlab.hybrid.guards import NO_GUARD, first_event
from frictionlab.hybrid.jets import copy, mode_jets, states_at
from frictionlab.hybrid.riders import record_sections
from frictionlab.hybrid.transitions import NO_MODE, apply_reset, enter

RUNNING, FINISHED, NO_ADMISSIBLE_MODE, STALLED, ACCUMULATED, NOT_FINITE = range(6)
SLACK = 64.0  # what the tolerance of a function of the states is wider than theirs: the room for rounding
SHARE = 0.02
REPEATS = 50  # events without advance of time after which the run is called stalled


class Work(NamedTuple):
    """Scratch arrays of a run."""

    jets: np.ndarray
    bounds: np.ndarray
    stack: np.ndarray
    intervals: np.ndarray
    scaled: np.ndarray
    roots: np.ndarray
    multiplicity: np.ndarray
    declared: np.ndarray
    zeros: np.ndarray
    before: np.ndarray


class Cursor(NamedTuple):
    """Where a run stands.  ``times``: now, end, entry into the mode, limit of the dwell time, that for
    events that have a limit mode, and what the sum of the steps is beyond now;
    ``counts``: mode, steps, events, section points, short dwells in a row by either limit, accumulations
    closed, events without advance, whether the jets are at hand, whether an accumulation ends the run, and
    the number of the current cell of a fixed time grid;
    ``sizes``: what the rounding errors of the state at the last event are relative to."""

    state: np.ndarray
    sizes: np.ndarray
    times: np.ndarray
    counts: np.ndarray
    signs: np.ndarray


NOW, END, ENTERED, DWELL, CHATTER, CARRY = range(6)
MODE, STEPS, EVENTS, POINTS, SHORT, SHORT_FLIGHTS, CLOSED, REPEATED, READY, RAISES, CELL = range(11)


class Record(NamedTuple):
    """Buffers of what a run leaves: steps, events and section points."""

    step_times: np.ndarray  # (capacity, 2) start and length
    step_modes: np.ndarray
    step_states: np.ndarray
    event_times: np.ndarray
    event_codes: np.ndarray  # (capacity, 3) guard, mode entered (-1: none), whether an accumulation closed
    event_states: np.ndarray  # (capacity, 2, states) before and after
    point_times: np.ndarray
    point_sections: np.ndarray
    point_states: np.ndarray


@inlined
def largest(J, first, last, k):
    """Largest Taylor coefficient number `k` of the states [first, last); infinite where one is no number."""
    size = 0.0
    for i in range(first, last):
        c = abs(J[i, k])
        if not c <= size:
            size = c if c == c else math.inf
    return size


@kernel
def from_later_terms(room, p, first, last, J):
    """The same by the first term that is not zero, where the first three are; infinite where none is."""
    for m in range(3, p):
        size = largest(J, first, last, m)
        if size > 0.0:
            return (room + log2(size)) / (p - m)
    return math.inf


@inlined
def group_length(code, order, log_tol, first, last, J):
    """Binary logarithm of the longest step that suits the states [first, last); -inf where none does."""
    size0 = largest(J, first, last, 0)
    size1 = largest(J, first, last, 1)
    size2 = largest(J, first, last, 2)
    start0, start1, start2 = log2(size0), log2(size1), log2(size2)
    best = math.inf
    for p in range(order - 1, order + 1):
        end = largest(J, first, last, p)
        if not end < math.inf:
            return -math.inf
        if end > 0.0:
            room = log_tol - log2(end)
            if size0 > 0.0 or size1 > 0.0 or size2 > 0.0:
                longest = max((room + start0) / p, max((room + start1) / (p - 1), (room + start2) / (p - 2)))
            else:
                longest = from_later_terms(room, p, first, last, J)
            best = min(best, longest)
    return best


@inlined
def step_length(code, order, tol, J):
    """Longest step for which the last two terms stay below `tol` times the size of their group of states.

    Jorba & Zou (2005), section 3.2.  The size of a group is the largest of its first three terms at the
    end of the step, so that no absolute tolerance is needed: a step h will do if, for one m of 0, 1, 2,
    |c_p| h^p <= tol |c_m| h^m; where those three are zero, for the next that is not.  Zero where a
    coefficient is no number.
    """
    log_tol = math.log2(tol)
    best = math.inf
    for group in range(3):
        first, last = code.groups[group], code.groups[group + 1]
        if last > first:
            best = min(best, group_length(code, order, log_tol, first, last, J))
    if best == -math.inf:
        return 0.0
    return exp2(best)


@kernel
def resolved(c, order, tol, h):
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
        h *= max(0.1, (tol * size / last) ** (1.0 / (order - 1)))
    return h


@inlined
def function_step(code, order, tol, mode, h, J):
    """Longest step up to `h` in which the series of guards, sections and integrals hold too.

    The states' series do not tell: a guard x^5 needs a fifth of the step that x does.  What would need
    less than a `SHARE` of their step is rounding error.
    """
    tol *= SLACK
    shortest = SHARE * h
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        h = resolved(J[code.function_slots[g]], order, tol, h)
    for section in range(code.sections.shape[1]):
        h = resolved(J[code.sections[mode, section]], order, tol, h)
    for i in range(code.groups[3], code.inputs):
        h = resolved(J[i], order, tol, h)
    return max(h, shortest)


@inlined
def time_left(times):
    """From now to the end."""
    return (times[END] - times[NOW]) - times[CARRY]


@inlined
def pass_time(times, h, left):
    """Go on by `h`, of `left` at most; returns whether the clock shows it.

    What rounding takes from the sum is carried to the next step (Knuth's two-sum): steps of nearly one
    length are rounded nearly alike, which would add up to 2e-8 s in 1e4 s.
    """
    before = times[NOW]
    if h == left:
        times[NOW], times[CARRY] = times[END], 0.0
    else:
        h += times[CARRY]
        now = before + h
        shown = now - before
        times[NOW], times[CARRY] = now, (before - (now - shown)) + (h - shown)
    return times[NOW] > before


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
    mode = enter(
        code, numbers, absolute, code.limits, z, z, order, work.declared, work.zeros, work.jets, work.bounds
    )
    if mode == NO_MODE:
        copy(before, z)
    return mode


@kernel
def close_event(code, numbers, absolute, guard, multiplicity, order, cursor, work):
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
    mode = enter(
        code, numbers, absolute, next_, z, z, order, work.declared, work.zeros, work.jets, work.bounds
    )
    if mode == NO_MODE:  # another event at this instant? Its guard is zero up to the rounding of the step
        sizes = cursor.sizes
        mode = enter(
            code, numbers, absolute, next_, z, sizes, order, work.declared, work.zeros, work.jets, work.bounds
        )
    return mode, closing


@kernel
def handle_event(code, numbers, absolute, guard, multiplicity, order, cursor, record, work):
    """Record the event, change the mode; returns how the run goes on."""
    times, counts = cursor.times, cursor.counts
    row = counts[EVENTS]
    record.event_times[row] = times[NOW]
    copy(cursor.state, record.event_states[row, 0])
    mode, closed = close_event(code, numbers, absolute, guard, multiplicity, order, cursor, work)
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
    return STALLED if counts[REPEATED] > REPEATS else RUNNING


@inlined
def note_sizes(start, cursor):
    """Note what the state's rounding errors are relative to, after a step from `start`."""
    for i in range(start.shape[0]):
        cursor.sizes[i] = max(abs(start[i]), abs(cursor.state[i]))


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
    goes_on = False
    h, guard, multiplicity = first_event(code, absolute, mode, cursor.state, order, J, work.zeros, h, work)
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
        return RUNNING if goes_on else STALLED
    return handle_event(code, numbers, absolute, guard, multiplicity, order, cursor, record, work)


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


def new_cursor(
    state: np.ndarray, mode: int, t_end: float, limits: tuple[float, float], raises: bool
) -> Cursor:
    """Cursor at time 0 in `mode`, whose jets are at hand; without sections."""
    counts, times = np.zeros(11, dtype=np.int64), np.array([0.0, t_end, 0.0, *limits, 0.0])
    counts[MODE], counts[READY], counts[RAISES] = mode, 1, raises
    return Cursor(state.copy(), np.abs(state), times, counts, np.zeros(0, dtype=np.int64))
