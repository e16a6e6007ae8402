"""What is done at an event: it is recorded, the state is reset, the next mode entered; Zeno accumulations are
closed.

Two stays in a row that are shorter than a limit are taken for a Zeno accumulation, infinitely many events in
finite time, where the event has a reset that closes it.  This reset is applied.  By the limit CHATTER the
automaton's limit mode is entered, if it has one that is admissible; by the limit DWELL the next mode is
chosen as after other events.
"""

from __future__ import annotations

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.jets import copy_vector
from frictionlab.hybrid.kernels.mode_selection import (
    NO_MODE,
    Rounding,
    apply_reset,
    select_combination,
    select_mode,
    set_zeros_by_construction,
)
from frictionlab.hybrid.kernels.run_state import (
    CHATTER,
    CLOCK_RESOLUTION,
    DWELL,
    ENTERED,
    EVENT_GUARD,
    EVENT_MULTIPLICITY,
    EVENT_PENDING,
    EVENTS,
    JETS_READY,
    MODE,
    MODE_NOT_DERIVED,
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
    """Count a step that does not advance the clock; returns the status of the run after it."""
    counts[REPEATED] += 1
    return status_after_repeat(counts)


@kernel
def is_zeno(code, guard, limit, count, run):
    """Whether the stay that ends and the one before it were both shorter than ``times[limit]``; updates the
    counts."""
    times, counts = run.times, run.counts
    if times[NOW] - times[ENTERED] >= max(times[limit], CLOCK_RESOLUTION * abs(times[NOW])):
        counts[count] = 0
    elif code.resets[guard, 1] != code.resets[guard, 0]:
        counts[count] += 1
    if counts[count] < 2:
        return False
    counts[count] = 0
    return True


@kernel
def select_limit_mode(system, guard, order, run, scratch):
    """Reset, and select the limit mode, a :class:`Selection`; where none is admissible the state is kept."""
    code, z, before = system.code, run.state, scratch.states
    copy_vector(z, before)
    apply_reset(system, code.resets[guard, 1], z, scratch.jets)
    set_zeros_by_construction(code, guard, 1, scratch)
    selection = select_mode(system, code.limits, z, Rounding(z, COEFFICIENT_ROUNDING), order, scratch)
    if selection.mode == NO_MODE and selection.missing == NO_MODE:
        copy_vector(before, z)
    return selection


@inlined
def select_target(system, queue, guard, z, rounding, order, scratch):
    """First admissible mode after the event of a guard, a :class:`Selection`."""
    if queue is None:
        return select_mode(system, system.code.targets[guard], z, rounding, order, scratch)
    return select_combination(system, queue, guard, z, rounding, order, scratch)


@kernel
def reset_and_select_mode(system, queue, truncation, event, run, scratch):
    """Reset the state after an event and enter the next mode; returns (:class:`Selection`, closed)."""
    code, guard, order = system.code, event.guard, truncation.order
    closing = 0
    if len(code.limits) and is_zeno(code, guard, CHATTER, SHORT_FLIGHTS, run):
        selection = select_limit_mode(system, guard, order, run, scratch)
        if selection.mode != NO_MODE or selection.missing != NO_MODE:
            return selection, 1
    if is_zeno(code, guard, DWELL, SHORT_DWELLS, run):
        closing = 1
    apply_reset(system, code.resets[guard, closing], run.state, scratch.jets)
    set_zeros_by_construction(code, guard, closing, scratch)
    if code.resets[guard, closing] < 0:
        scratch.ended[0], scratch.ended[1] = guard, event.multiplicity
    z = run.state
    selection = select_target(system, queue, guard, z, Rounding(z, COEFFICIENT_ROUNDING), order, scratch)
    # Another event at this instant? Its guard is zero up to the step's rounding, or up to its remainder.
    for share in (COEFFICIENT_ROUNDING, max(COEFFICIENT_ROUNDING, FUNCTION_TOL_FACTOR * truncation.tol)):
        if selection.mode == NO_MODE and selection.missing == NO_MODE:
            selection = select_target(system, queue, guard, z, Rounding(run.sizes, share), order, scratch)
    return selection, closing


@kernel
def leave_event(event, run):
    """Note an event that is yet to be handled; returns EVENT_PENDING, the status of the run.

    Where modes are derived on demand the solver's loop leaves events to its caller: the code that chooses
    among combinations of regimes would make the loop longer for all models.
    """
    run.counts[EVENT_GUARD], run.counts[EVENT_MULTIPLICITY] = event.guard, event.multiplicity
    return EVENT_PENDING


@kernel
def handle_event(system, truncation, event, run, record, scratch):
    """Record the event and change the mode; returns the status of the run.

    ``truncation.tol`` is the share of the states by which the end of the step may miss the event.
    """
    return record_and_change_mode(system, None, truncation, event, run, record, scratch)


@kernel
def handle_event_on_demand(system, queue, truncation, event, run, record, scratch):
    """As :func:`handle_event`, where modes are derived on demand and chosen among combinations of regimes."""
    return record_and_change_mode(system, queue, truncation, event, run, record, scratch)


@kernel
def record_and_change_mode(system, queue, truncation, event, run, record, scratch):
    """As :func:`handle_event`; `queue` is None where modes are listed."""
    times, counts = run.times, run.counts
    row = counts[EVENTS]
    record.event_times[row] = times[NOW]
    copy_vector(run.state, record.event_states[row, 0])
    short_dwells, short_flights = counts[SHORT_DWELLS], counts[SHORT_FLIGHTS]
    selection, closed = reset_and_select_mode(system, queue, truncation, event, run, scratch)
    mode = selection.mode
    if selection.missing != NO_MODE:  # it is to be derived first: undo the event, which is handled again then
        copy_vector(record.event_states[row, 0], run.state)
        counts[SHORT_DWELLS], counts[SHORT_FLIGHTS] = short_dwells, short_flights
        leave_event(event, run)
        return MODE_NOT_DERIVED
    record.event_codes[row, 0] = event.guard
    record.event_codes[row, 1] = mode
    record.event_codes[row, 2] = closed
    copy_vector(run.state, record.event_states[row, 1])
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
