"""Kernels for many runs of one structure: runs in the same mode take their steps side by side.

Runs wait in a queue for each mode.  As many as there are lanes are taken from the longest queue, in turn.
Now and then the mode of the run that is farthest behind comes first, so that all come to their ends at about
the same time and few are left with empty lanes beside them.  A step of all lanes is two calls of the mode's
native code (:mod:`frictionlab.hybrid.codegen.step_codegen`).  The first one computes the jets and the lengths
of the steps.  Between the calls the kernels of single runs find the events, in the jets of the lanes.  The
second call advances all states, up to the event where there is one.  A run that meets an event leaves its
lane to the next run in the queue.  Its next mode is chosen by a low order of its series.  The full order is
computed once the run is in a lane again.  Until then it is noted which leading coefficients count as zero
after the event.  Rare kinds of steps are taken by the kernels of single runs.  Every run takes the steps that
it would take alone, so its results depend on no other run.
"""

from __future__ import annotations

import math

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.codegen.jet_codegen import (
    CONTROL_ROWS,
    LEFT,
    LENGTH,
    MEASURE,
    MEASURED,
    MOVE,
    REGULAR,
    SUITED,
)
from frictionlab.hybrid.ensemble.arrays import FREE
from frictionlab.hybrid.kernels.arithmetic import call_lane_step
from frictionlab.hybrid.kernels.event_handling import count_repeat, handle_event
from frictionlab.hybrid.kernels.event_location import (
    COEFFICIENT_ROUNDING,
    LOW_ORDER,
    NO_GUARD,
    GuardZero,
    first_event,
    is_zero_truncated,
    refine_zero,
)
from frictionlab.hybrid.kernels.jets import JET_COLUMNS, copy_vector, mode_jets
from frictionlab.hybrid.kernels.mode_selection import NO_MODE, Rounding, forget_zeros, select_mode
from frictionlab.hybrid.kernels.remainder import has_zero_guard, needs_remainder
from frictionlab.hybrid.kernels.run_state import (
    END,
    ENTERED,
    EVENTS,
    FINISHED,
    JETS_READY,
    MODE,
    NO_ADMISSIBLE_MODE,
    NOW,
    RUNNING,
    STEPS,
    RunState,
    Truncation,
    advance_clock,
    record_sizes,
    remaining_time,
)
from frictionlab.hybrid.kernels.step_length import function_step, has_negative_base, is_cut_short
from frictionlab.hybrid.kernels.taylor_steps import advance_taylor
from frictionlab.tape.program import Numbers, System

MIN_RUNS_FOR_LANES = 2  # fewer runs in a mode are advanced one by one,
LANES_PER_RUN = 3  # and fewer than one for so many lanes, whose step takes as long as that of a run alone
SINGLE_STEPS = 20  # steps of runs alone or farthest behind, after which it looks for the longest queue again
MAX_CALLS = 50  # most calls in one mode, after which the kernel looks for the longest queue again
LATE_STEPS = 400  # steps after which the run that is farthest behind comes first
CAPPED = -1  # the status of a run that has reached its cap of steps or events
ALONE = NO_GUARD - 1  # stands for the guard of a lane whose run takes its next step alone


@kernel
def run_state_of(runs, i):
    """A run in the form that the kernels of single runs take."""
    return RunState(runs.states[i], runs.sizes[i], runs.times[i], runs.counts[i], runs.signs)


@kernel
def system_of_run(code, runs, i):
    """The automaton with the numbers of a run."""
    numbers = Numbers(runs.constants[i], runs.terms[i])
    return System(code, numbers, Numbers(runs.sizes_of_constants[i], runs.sizes_of_terms[i]))


@kernel
def record_step_end(runs, i, status):
    """Record how a step ended; True where the run is over."""
    counts, totals = runs.counts[i], runs.totals[i]
    totals[0] += counts[STEPS]
    totals[1] += counts[EVENTS]
    counts[STEPS] = counts[EVENTS] = 0
    if status == RUNNING and not runs.times[i, NOW] < runs.times[i, END]:
        status = FINISHED
    elif status == RUNNING and (totals[0] >= runs.caps[0] or totals[1] >= runs.caps[1]):
        status = CAPPED
    runs.status[i] = status
    return status != RUNNING


@kernel
def enqueue(runs, i):
    """Put a run at the end of the queue of its mode."""
    mode = runs.counts[i, MODE]
    runs.queue[mode, (runs.first[mode] + runs.queued[mode]) % runs.queue.shape[1]] = i
    runs.queued[mode] += 1


@inlined
def dequeue(runs, mode):
    """The run that has waited longest in a mode, taken out of its queue."""
    i = runs.queue[mode, runs.first[mode]]
    runs.first[mode] = (runs.first[mode] + 1) % runs.queue.shape[1]
    runs.queued[mode] -= 1
    return i


@kernel
def keep_zeros(runs, i, scratch):
    """Store which leading coefficients count as zero in a run's next step; its jets in `scratch` are lost."""
    runs.counts[i, JETS_READY] = 0
    copy_vector(scratch.leading_zeros, runs.zeros[i])


@kernel
def advance_single(code, truncation, runs, i, most, record, scratch):
    """Take up to `most` steps of one run, and more while its jets are at hand; queue it unless it is over."""
    system, run = system_of_run(code, runs, i), run_state_of(runs, i)
    mode_jets(code, system.numbers, runs.counts[i, MODE], truncation.order, run.state, scratch.jets)
    copy_vector(runs.zeros[i], scratch.leading_zeros)
    forget_zeros(scratch)
    runs.counts[i, JETS_READY] = 1
    over = False
    while not over and (most > 0 or runs.counts[i, JETS_READY]):
        most -= 1  # one step in each pass: the record has no room for more
        mode = runs.counts[i, MODE]
        status = advance_taylor(system, truncation, run, record, scratch)
        if code.powers[mode] and runs.counts[i, STEPS] > 0:
            note_negative_base(system, mode, record.step_states[0], runs, i, scratch)
        over = record_step_end(runs, i, status)
    mode = runs.counts[i, MODE]
    if over and mode != NO_MODE and code.powers[mode]:
        note_negative_base(system, mode, run.state, runs, i, scratch)
    if runs.counts[i, JETS_READY] == 0:
        scratch.leading_zeros[:] = 0
    keep_zeros(runs, i, scratch)
    if not over:
        enqueue(runs, i)


@kernel
def note_negative_base(system, mode, z, runs, i, scratch):
    """Note for a run whether the base of a power is negative at a state."""
    if has_negative_base(system, mode, z, scratch.values, scratch.bounds):
        runs.undefined[i] = 1


@kernel
def begin_run(code, truncation, runs, i, initial, scratch):
    """Choose the first mode of a run."""
    system, z = system_of_run(code, runs, i), runs.states[i]
    forget_zeros(scratch)
    rounding = Rounding(z, COEFFICIENT_ROUNDING)
    mode, _ = select_mode(system, initial, z, rounding, truncation.order, scratch)
    runs.counts[i, MODE] = mode
    keep_zeros(runs, i, scratch)
    if mode == NO_MODE:
        runs.status[i] = NO_ADMISSIBLE_MODE
    else:
        enqueue(runs, i)


@kernel
def begin_runs(code, truncation, runs, which, initial, scratch):
    """Choose the first modes of some of the runs."""
    for i in which:
        begin_run(code, truncation, runs, i, initial, scratch)


@kernel
def load_lane(runs, lanes, mode, lane, i):
    """Load a run into a lane, with its numbers for its mode; those of all runs are there."""
    lanes.runs[lane] = i
    copy_vector(runs.states[i], lanes.z[:, lane])
    copy_vector(runs.zeros[i], lanes.control[CONTROL_ROWS:, lane])
    for k in lanes.own_constants[mode]:
        if k == FREE:
            break
        lanes.constants[k, lane] = runs.constants[i, k]
    for k in lanes.own_terms[mode]:
        if k == FREE:
            break
        lanes.terms[k, lane] = runs.terms[i, k]


@inlined
def unload_lane(runs, lanes, lane):
    """Free a lane; returns the run that was in it."""
    i = lanes.runs[lane]
    lanes.runs[lane] = FREE
    copy_vector(lanes.z[:, lane], runs.states[i])
    copy_vector(lanes.control[CONTROL_ROWS:, lane], runs.zeros[i])
    return i


@kernel
def load_lanes(runs, lanes, mode):
    """Load runs from the queue of the mode into free lanes; returns the number of occupied lanes."""
    taken = 0
    for lane in range(lanes.runs.shape[0]):
        if lanes.runs[lane] == FREE and runs.queued[mode] > 0:
            load_lane(runs, lanes, mode, lane, dequeue(runs, mode))
        if lanes.runs[lane] != FREE:
            taken += 1
            i = lanes.runs[lane]
            lanes.control[LEFT, lane] = remaining_time(runs.times[i])
    return taken


@kernel
def release_lanes(runs, lanes):
    """Free all lanes; their runs return to the queue."""
    for lane in range(lanes.runs.shape[0]):
        if lanes.runs[lane] != FREE:
            enqueue(runs, unload_lane(runs, lanes, lane))


@kernel
def accept_lane_step(runs, lanes, lane):
    """Record a step of a lane without an event."""
    i = lanes.runs[lane]
    goes_on = advance_clock(runs.times[i], lanes.control[LENGTH, lane], lanes.control[LEFT, lane])
    runs.counts[i, STEPS] = 1
    if record_step_end(runs, i, RUNNING if goes_on else count_repeat(runs.counts[i])):
        unload_lane(runs, lanes, lane)


@inlined
def copy_jet(lanes, lane, slot, order, scratch):
    """Copy a slot's jet from a lane."""
    copy_vector(lanes.jets[slot, : order + 1, lane], scratch.jets[slot])


@inlined
def copy_needed_jets(code, lanes, lane, mode, order, all_guards, scratch):
    """Copy the jets needed to find events, and how many leading coefficients of guards count as zero.

    Those of guards that stay positive are needed only if `all_guards` are.
    """
    for slot in lanes.needed[mode]:
        if slot == FREE:
            break
        copy_jet(lanes, lane, slot, order, scratch)
    copy_vector(lanes.control[CONTROL_ROWS:, lane], scratch.leading_zeros)
    first = code.mode_guards[mode]
    for g in range(first, code.mode_guards[mode + 1]):
        if all_guards or scratch.leading_zeros[g - first] <= order:
            copy_jet(lanes, lane, code.function_slots[g], order, scratch)


@inlined
def shorter_length(code, truncation, lanes, lane, mode, scratch):
    """Length of a lane's step if its guards alone make it shorter; 0 if more has to be looked at."""
    longest, left = lanes.control[LENGTH, lane], lanes.control[LEFT, lane]
    if lanes.control[SUITED, lane] == 0.0 or code.powers[mode]:
        return 0.0
    h = function_step(code, truncation, mode, longest, False, scratch.jets, scratch.values)
    if is_cut_short(h, longest) or needs_remainder(code, truncation.order, mode, longest, left):
        return 0.0
    return 0.0 if has_zero_guard(code, truncation.order, mode, scratch.jets) else h


@kernel
def locate_event(code, truncation, runs, lanes, mode, lane, scratch):
    """Find the event of a step that is not regular; the step ends there, or has the length zero if the run
    takes it alone."""
    order, control, i = truncation.order, lanes.control, lanes.runs[lane]
    h, left, measured = control[LENGTH, lane], control[LEFT, lane], control[MEASURED, lane] != 0.0
    copy_needed_jets(code, lanes, lane, mode, order, not measured, scratch)
    if not measured:
        h = shorter_length(code, truncation, lanes, lane, mode, scratch)
        if h == 0.0:
            lanes.guards[lane], control[LENGTH, lane] = ALONE, 0.0
            return
    system, z = system_of_run(code, runs, i), runs.states[i]
    copy_vector(lanes.z[:, lane], z)
    zero = first_event(system, mode, z, order, h, measured, scratch)
    if is_zero_truncated(code, zero, mode, order, scratch.jets):
        for slot in range(code.inputs):
            copy_jet(lanes, lane, slot, order, scratch)
        zero = refine_zero(system, mode, zero, left, order, scratch)
    control[LENGTH, lane], lanes.guards[lane], lanes.multiplicities[lane] = zero
    control[CONTROL_ROWS:, lane] = 0.0


@kernel
def finish_at_event(code, truncation, runs, lanes, lane, record, scratch):
    """Complete a step that has led to an event: the run leaves its lane for its next mode."""
    i, h, left = lanes.runs[lane], lanes.control[LENGTH, lane], lanes.control[LEFT, lane]
    lanes.runs[lane] = FREE
    system, run = system_of_run(code, runs, i), run_state_of(runs, i)
    copy_vector(lanes.z[:, lane], run.state)
    if h > 0.0:
        run.counts[STEPS] += 1
        advance_clock(run.times, h, left)
        record_sizes(lanes.jets[:, 0, lane], lanes.jets[:, 1, lane], h, run)
    event = GuardZero(h, lanes.guards[lane], lanes.multiplicities[lane])
    forget_zeros(scratch)
    status = change_mode(system, truncation, event, run, lanes.counts, record, scratch)
    keep_zeros(runs, i, scratch)
    if not record_step_end(runs, i, status):
        enqueue(runs, i)


@kernel
def finish_step(code, truncation, runs, lanes, lane, record, scratch):
    """Record the end of a lane's step."""
    if lanes.guards[lane] == NO_GUARD:
        accept_lane_step(runs, lanes, lane)
    elif lanes.guards[lane] == ALONE:
        i = unload_lane(runs, lanes, lane)
        advance_single(code, truncation, runs, i, 1, record, scratch)
    else:
        finish_at_event(code, truncation, runs, lanes, lane, record, scratch)


@kernel
def change_mode(system, truncation, event, run, before, record, scratch):
    """Handle an event by a low order of the series, or by the full order if that leaves a guard undecided.

    `before` is scratch.
    """
    counts, times = run.counts, run.times
    few = Truncation(min(LOW_ORDER, truncation.order), truncation.tol)
    copy_vector(counts, before)
    entered = times[ENTERED]
    status = handle_event(system, few, event, run, record, scratch)
    if status != NO_ADMISSIBLE_MODE and is_undecided(system.code, counts[MODE], few.order, scratch):
        copy_vector(before, counts)
        times[ENTERED] = entered
        copy_vector(record.event_states[counts[EVENTS], 0], run.state)
        status = handle_event(system, truncation, event, run, record, scratch)
    return status


@inlined
def is_undecided(code, mode, order, scratch):
    """Whether a guard of a mode has coefficients that all count as zero up to an order."""
    for g in range(code.mode_guards[mode + 1] - code.mode_guards[mode]):
        if scratch.leading_zeros[g] > order:
            return True
    return False


@inlined
def fewest_runs(lanes):
    """Number of runs in a mode below which they are advanced one by one."""
    return max(MIN_RUNS_FOR_LANES, -(-lanes.runs.shape[0] // LANES_PER_RUN))


@inlined
def longest_queue(runs):
    """The mode in which most runs wait."""
    mode = 0
    for other in range(1, runs.queued.shape[0]):
        if runs.queued[other] > runs.queued[mode]:
            mode = other
    return mode


@inlined
def farthest_behind(runs):
    """The mode in which the run that has waited longest is at an earlier time than in other modes."""
    mode, earliest = 0, math.inf
    for other in range(runs.queued.shape[0]):
        if runs.queued[other] > 0:
            time = runs.times[runs.queue[other, runs.first[other]], NOW]
            if time < earliest:
                mode, earliest = other, time
    return mode


@kernel
def advance_lanes(code, truncation, runs, lanes, mode, least, record, scratch):
    """Advance the runs in a mode; returns the number of calls.

    It ends when few runs are left, or when another mode would fill more lanes, the latter after the `least`
    number of calls.
    """
    calls, count = 0, lanes.runs.shape[0]
    arrays = lanes.z, lanes.constants, lanes.terms, lanes.jets, lanes.control
    while calls < MAX_CALLS:
        taken = load_lanes(runs, lanes, mode)
        others_fill_lanes = runs.queued[longest_queue(runs)] >= count
        if taken < fewest_runs(lanes) or (calls >= least and taken < count and others_fill_lanes):
            break
        calls += 1
        call_lane_step(code.lanes[mode], *arrays, MEASURE, truncation.order)
        for lane in range(count):
            lanes.guards[lane] = NO_GUARD
            if lanes.runs[lane] != FREE and lanes.control[REGULAR, lane] == 0.0:
                locate_event(code, truncation, runs, lanes, mode, lane, scratch)
        call_lane_step(code.lanes[mode], *arrays, MOVE, truncation.order)
        for lane in range(count):
            if lanes.runs[lane] != FREE:
                finish_step(code, truncation, runs, lanes, lane, record, scratch)
    release_lanes(runs, lanes)
    return calls


@kernel
def advance_batch_kernel(code, truncation, runs, lanes, record, scratch, rounds):
    """Advance the runs by about `rounds` steps in all; returns whether any run is left."""
    late = rounds
    while rounds > 0:
        mode, least = longest_queue(runs), 0
        if late - rounds >= LATE_STEPS:
            mode, least, late = farthest_behind(runs), SINGLE_STEPS, rounds
        if runs.queued[mode] == 0:
            return False
        if (
            code.lanes[mode] != 0
            and not code.powers[mode]
            and lanes.jets.shape[1] == JET_COLUMNS
            and runs.queued[mode] >= fewest_runs(lanes)
        ):
            calls = advance_lanes(code, truncation, runs, lanes, mode, least, record, scratch)
            rounds -= lanes.runs.shape[0] * calls
        else:
            advance_single(code, truncation, runs, dequeue(runs, mode), SINGLE_STEPS, record, scratch)
            rounds -= SINGLE_STEPS
    return True
