"""What is done at an event: it is recorded, the state is reset, the next mode is entered.

Zeno accumulations, infinitely many events in finite time, are closed here.  An event has a reset for this.
After two stays in a row that are shorter than the limit CHATTER, the automaton's limit mode is entered, if it
has one that is admissible.  Otherwise `impacts` closes the accumulation once rates are negligible, and the
next mode is chosen as after other events.  Impacts at one instant are no accumulation in time; `impacts` has
them too.
"""

from __future__ import annotations

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.impacts import (
    FLIGHTS,
    impact,
    is_short,
    keep_regimes_until_impacts,
    stay_limit,
)
from frictionlab.hybrid.kernels.jets import copy_vector, mode_jets
from frictionlab.hybrid.kernels.mode_selection import (
    NO_MODE,
    Rounding,
    apply_event_reset,
    count_negative_as_zero,
    is_impact,
    keep_held_at_zero,
    select_combination,
    select_mode,
)
from frictionlab.hybrid.kernels.run_state import (
    CHATTER,
    CLOCK_RESOLUTION,
    ENTERED,
    EVENT_GUARD,
    EVENT_MULTIPLICITY,
    EVENT_PENDING,
    EVENTS,
    IMPACTS,
    JETS_READY,
    MODE,
    MODE_NOT_DERIVED,
    NO_ADMISSIBLE_MODE,
    NO_REGIME,
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

MAX_REPEATS = 50  # other events or steps without advance of time after which the run is called stalled
MAX_IMPACTS = 100_000  # impacts at one instant after which it is


@inlined
def status_after_repeat(counts):
    """Status of a run after an event or step that does not advance the clock: stalled after too many."""
    return STALLED if counts[REPEATED] > MAX_REPEATS or counts[IMPACTS] > MAX_IMPACTS else RUNNING


@kernel
def count_repeat(counts):
    """Count a step that does not advance the clock; returns the status of the run after it."""
    counts[REPEATED] += 1
    return status_after_repeat(counts)


@inlined
def is_chatter(code, guard, run):
    """Whether the stay that ends and the one before it were both shorter than the limit; counts them."""
    times, counts = run.times, run.counts
    if times[NOW] - times[ENTERED] >= max(times[CHATTER], CLOCK_RESOLUTION * abs(times[NOW])):
        counts[SHORT_FLIGHTS] = 0
    elif is_impact(code, guard):
        counts[SHORT_FLIGHTS] += 1
    if counts[SHORT_FLIGHTS] < 2:
        return False
    counts[SHORT_FLIGHTS] = 0
    return True


@kernel
def select_limit_mode(system, guard, order, run, scratch):
    """Reset, and select the limit mode, a :class:`Selection`; if none is admissible the state is kept."""
    code, z, before = system.code, run.state, scratch.states
    copy_vector(z, before)
    apply_event_reset(system, guard, 1, z, scratch)
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
def widen_by_clock(system, run, scratch):
    """Note that rounding errors of the state are as large as what its rates give in a stay that the clock
    hardly resolves: so the stays of an accumulation that end by stick are its end."""
    J, time = scratch.jets, FLIGHTS * stay_limit(run) / COEFFICIENT_ROUNDING
    mode_jets(system.code, system.numbers, run.counts[MODE], 1, run.state, J)
    for i in range(run.state.shape[0]):
        run.sizes[i] = max(run.sizes[i], time * abs(J[i, 1]))


@inlined
def reset_at_event(system, truncation, event, run, record, scratch):
    """Reset the state after an event; returns how many impacts that were.

    Their guards, or that of another event, are in ``scratch.impacts``.
    """
    code, guard, impacts = system.code, event.guard, scratch.impacts
    if is_impact(code, guard):
        return impact(system, truncation, guard, run, record, scratch)
    impacts.guards[0], impacts.closing[0] = guard, 0
    if is_short(run):
        widen_by_clock(system, run, scratch)
    z, before = run.state, scratch.states
    copy_vector(z, before)
    apply_event_reset(system, guard, 0, z, scratch)
    if code.resets[guard, 0] < 0:
        scratch.ended[0], scratch.ended[1] = guard, event.multiplicity
    else:
        keep_held_at_zero(system, run.counts[MODE], code.resets[guard, 0], before, z, run.sizes, scratch)
    return 1


@inlined
def reset_and_select_mode(system, queue, truncation, event, run, record, scratch):
    """Reset the state after an event and select the next mode; returns a :class:`Selection`, and how many
    impacts there were."""
    code, order, z, impacts = system.code, truncation.order, run.state, scratch.impacts
    if len(code.limits) and is_chatter(code, event.guard, run):
        selection = select_limit_mode(system, event.guard, order, run, scratch)
        if selection.mode != NO_MODE or selection.missing != NO_MODE:
            impacts.guards[0], impacts.closing[0] = event.guard, 1
            return selection, 1
    count = reset_at_event(system, truncation, event, run, record, scratch)
    guard = impacts.guards[0]
    if queue is not None:
        keep_regimes_until_impacts(system, queue, truncation.tol, count, run, scratch)
    # Where all comes to rest, what is left is a rounding error of the states before.
    rests = is_closed(count, impacts) or not is_impact(code, guard)
    rounding = Rounding(run.sizes if rests else z, COEFFICIENT_ROUNDING)
    selection = select_target(system, queue, guard, z, rounding, order, scratch)
    if rests and selection.mode == NO_MODE and selection.missing == NO_MODE:  # it does not come to rest
        rounding = Rounding(z, COEFFICIENT_ROUNDING)
        selection = select_target(system, queue, guard, z, rounding, order, scratch)
    # Another event at this instant? Its guard is zero up to the step's rounding, or up to its remainder.
    remainder = max(COEFFICIENT_ROUNDING, FUNCTION_TOL_FACTOR * truncation.tol)
    for share in (COEFFICIENT_ROUNDING, remainder):
        if selection.mode == NO_MODE and selection.missing == NO_MODE:
            selection = select_target(system, queue, guard, z, Rounding(run.sizes, share), order, scratch)
    if selection.mode == NO_MODE and selection.missing == NO_MODE:
        before = record.event_states[run.counts[EVENTS], 0]
        count_negative_as_zero(system, run.counts[MODE], before, scratch)
        selection = select_target(system, queue, guard, z, Rounding(run.sizes, remainder), order, scratch)
    if queue is not None:
        queue.kept[:] = NO_REGIME
    return selection, count


@inlined
def is_closed(count, impacts):
    """Whether any of the impacts closed an accumulation."""
    closed = 0
    for i in range(count):
        closed = max(closed, impacts.closing[i])
    return closed


@inlined
def note_holding(code, mode, count, impacts):
    """Note the impacts after which a mode holds their guard at zero: they close an accumulation."""
    for i in range(count):
        guard = impacts.guards[i]
        if mode != NO_MODE and is_impact(code, guard):
            for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
                if code.function_classes[f] == code.function_classes[guard]:
                    impacts.closing[i] = 1


@inlined
def record_events(count, mode, run, record, impacts):
    """Record an event, or impacts that acted together: the states between them are there."""
    times, counts, row = run.times, run.counts, run.counts[EVENTS]
    copy_vector(run.state, record.event_states[row + count - 1, 1])
    for i in range(count):
        record.event_times[row + i] = times[NOW]
        record.event_codes[row + i, 0] = impacts.guards[i]
        record.event_codes[row + i, 1] = mode
        record.event_codes[row + i, 2] = impacts.closing[i]
    counts[EVENTS] += count
    counts[ZENO_COUNT] += is_closed(count, impacts)


@inlined
def count_at_instant(code, guard, run):
    """Count the events since the clock was advanced, impacts and others separately."""
    times, counts = run.times, run.counts
    if times[NOW] > times[ENTERED]:
        counts[REPEATED] = counts[IMPACTS] = 0
    elif is_impact(code, guard):
        counts[IMPACTS] += 1
    else:
        counts[REPEATED] += 1
    times[ENTERED] = times[NOW]


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
    """As :func:`handle_event`, for modes on demand, which are chosen among combinations of regimes."""
    return record_and_change_mode(system, queue, truncation, event, run, record, scratch)


@inlined
def record_and_change_mode(system, queue, truncation, event, run, record, scratch):
    """As :func:`handle_event`; `queue` is None where modes are listed."""
    counts, row = run.counts, run.counts[EVENTS]
    copy_vector(run.state, record.event_states[row, 0])
    short_dwells, short_flights = counts[SHORT_DWELLS], counts[SHORT_FLIGHTS]
    selection, count = reset_and_select_mode(system, queue, truncation, event, run, record, scratch)
    mode = selection.mode
    if selection.missing != NO_MODE:  # it is to be derived first: undo the event, which is handled again then
        copy_vector(record.event_states[row, 0], run.state)
        counts[SHORT_DWELLS], counts[SHORT_FLIGHTS] = short_dwells, short_flights
        leave_event(event, run)
        return MODE_NOT_DERIVED
    note_holding(system.code, mode, count, scratch.impacts)
    record_events(count, mode, run, record, scratch.impacts)
    count_at_instant(system.code, event.guard, run)
    if mode == NO_MODE:
        return NO_ADMISSIBLE_MODE
    counts[MODE] = mode
    counts[JETS_READY] = 1
    if is_closed(count, scratch.impacts) and counts[STOPS_AT_ZENO]:
        return ZENO
    return status_after_repeat(counts)
