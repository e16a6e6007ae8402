"""The solver's loop in one kernel: step by Taylor polynomial, event, reset, next mode; and dense output.

The loop runs until the end, an error, an event that it leaves to its caller, or a full record.  It can then
be called again.  A step is stored as the state at its start.  Dense output computes the polynomial again from
this state, which needs a twentieth of the memory and costs one jet per step evaluated.  Section events, zero
crossings that change no mode, are recorded along a step.
"""

from __future__ import annotations

import math

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.event_handling import count_repeat, handle_event, leave_event
from frictionlab.hybrid.kernels.event_location import (
    COEFFICIENT_ROUNDING,
    NO_GUARD,
    first_event,
    is_zero_truncated,
    isolate_roots,
    refine_zero,
    rescale,
)
from frictionlab.hybrid.kernels.jets import (
    copy_vector,
    majorant,
    mode_jets,
    polynomial_value,
    series_range,
    states_at,
)
from frictionlab.hybrid.kernels.mode_selection import has_modes_on_demand
from frictionlab.hybrid.kernels.power_onset import onset_step
from frictionlab.hybrid.kernels.remainder import (
    has_zero_series,
    needs_remainder,
    polynomials_visible,
    remainder_step,
)
from frictionlab.hybrid.kernels.run_state import (
    CLOCK_RESOLUTION,
    END,
    ENTERED,
    EVENTS,
    FINISHED,
    JETS_READY,
    MODE,
    NOT_FINITE,
    NOW,
    POINTS,
    RUNNING,
    STEPS,
    Truncation,
    advance_clock,
    record_sizes,
    remaining_time,
)
from frictionlab.hybrid.kernels.step_length import (
    MIN_USEFUL_ORDER,
    SHARE_OF_STOP,
    has_base_near_zero,
    lacks_series,
    largest_coefficient,
    measured_function_step,
    step_length,
    time_near_stop,
    time_to_stop,
    time_to_zero_base,
    truncate_series_at_stop,
    truncate_series_near_zero,
    unresolved_time,
)

PAST_STOP = 1.0 + 1e-15  # so that the step to a stop has it inside
SIGN_SAMPLES = 5  # points between two zeros of a section at which its sign is told from rounding


@kernel
def record_section_point(section, s, order, run, record, scratch):
    """Record the state at `s` after the start of the step."""
    row = run.counts[POINTS]
    record.point_times[row] = run.times[NOW] + s
    record.point_sections[row] = section
    states_at(scratch.jets, order, s, record.point_states[row])
    run.counts[POINTS] += 1


@inlined
def keeps_sign(J, slot, sign, order, h):
    """Whether a section's series has the same `sign` throughout [0, h]."""
    return sign * J[slot, 0] > series_range(J, slot, order, h)


@kernel
def sign_of(value):
    """Sign of a value; 0 for zero and NaN."""
    return 1 if value > 0.0 else (-1 if value < 0.0 else 0)


@kernel
def note_sign(code, section, sign, s, order, run, record, scratch):
    """Note the sign that a section has from `s` after the start of the step on; record where it changes."""
    if sign != 0:
        if run.signs[section] == -sign and code.directions[section] != -sign:
            record_section_point(section, s, order, run, record, scratch)
        run.signs[section] = sign


@kernel
def record_section_events(system, order, mode, h, run, record, scratch):
    """Record every crossing in (0, h]: the section changes its sign from one open interval to another.

    Values within rounding have no sign.  So it is no crossing to touch the surface, or to lie on it for a
    while.  If a jump between two steps crosses the surface, the crossing belongs to the later step.  Near a
    pole only the value at the start has a sign.
    """
    code, J = system.code, scratch.jets
    bounded = False
    for section in range(code.sections.shape[1]):
        slot = code.sections[mode, section]
        if keeps_sign(J, slot, run.signs[section], order, h):
            continue
        if not bounded:
            bound_section_errors(system, order, mode, h, run, scratch)
            bounded = True
        error = COEFFICIENT_ROUNDING * scratch.bounds[slot, 0]
        error += abs(polynomial_value(J[slot], order, h) - scratch.values[slot, 0])
        if not error < math.inf:  # a pole is so near that the polynomial has no meaning
            note_sign(code, section, sign_of(J[slot, 0]), 0.0, order, run, record, scratch)
        elif rescale(J[slot], 0, order, h, scratch.roots.scaled) > error:
            record_crossings(code, section, error, mode, order, h, run, record, scratch)


@kernel
def bound_section_errors(system, order, mode, h, run, scratch):
    """Write the values of all slots at the end of a step, and bounds of their terms throughout it.

    Right after an event the states have rounding errors of the size that they had before it.
    """
    code, J, sizes = system.code, scratch.jets, scratch.states
    states_at(J, order, h, sizes)
    mode_jets(code, system.numbers, mode, 0, sizes, scratch.values)
    begins = run.times[NOW] == run.times[ENTERED]
    for i in range(sizes.shape[0]):
        sizes[i] = abs(J[i, 0]) + series_range(J, i, order, h)
        if begins:
            sizes[i] = max(sizes[i], run.sizes[i])
    majorant(code, system.magnitudes, mode, 0, sizes, J, scratch.bounds)


@kernel
def sign_between(c, order, first, last, error):
    """Sign of a polynomial between two of its zeros; 0 where it goes no farther from zero than `error`."""
    largest = 0.0
    for i in range(SIGN_SAMPLES):
        value = polynomial_value(c, order, first + (last - first) * (i + 0.5) / SIGN_SAMPLES)
        if abs(value) > abs(largest):
            largest = value
    return sign_of(largest) if abs(largest) > error else 0


@kernel
def record_crossings(code, section, error, mode, order, h, run, record, scratch):
    """Record where a section whose rescaled series has this `error` changes its sign in a step."""
    roots, c = scratch.roots, scratch.jets[code.sections[mode, section]]
    count = isolate_roots(order, order + 1, roots)
    place = 0.0
    for i in range(count + 1):
        end = roots.places[i] * h if i < count else h
        sign = sign_between(c, order, place, end, error)
        note_sign(code, section, sign, place, order, run, record, scratch)
        place = end


@kernel
def step_series(code, numbers, mode, order, now, h, z, J):
    """Compute again the jets along which a step of length `h` from `z` was taken at the time `now`.

    Returns whether the step led to a stop.
    """
    mode_jets(code, numbers, mode, order, z, J)
    if not code.powers[mode]:
        return False
    time = time_to_stop(code, numbers, mode, J)
    stops = time <= time_near_stop(now, now) and h > SHARE_OF_STOP * time
    if stops:
        truncate_series_at_stop(code, numbers, mode, J)
    elif has_base_near_zero(code, order, mode, now, J):
        truncate_series_near_zero(code, numbers, mode, order, z, h, J)
    return stops


@kernel
def sample_states(code, numbers, order, steps, which, times, out, J):
    """Write the states at ascending `times`, each within the step of number ``which[i]``, into `out`."""
    current = -1
    for i in range(times.shape[0]):
        step = which[i]
        if step != current:
            mode, now, h = steps.modes[step], steps.times[step, 0], steps.times[step, 1]
            step_series(code, numbers, mode, order, now, h, steps.states[step], J)
            current = step
        states_at(J, order, times[i] - steps.times[step, 0], out[i])


def subdivide_steps(step_times: np.ndarray, parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Times that cut every step into `parts`, without the end of the step, and the step of each."""
    share = np.arange(parts) / parts
    times = step_times[:, :1] + step_times[:, 1:] * share
    steps = np.repeat(np.arange(len(step_times)), parts)
    return times.ravel(), steps


@kernel
def power_onset_step(system, truncation, mode, left, stops, run, scratch):
    """Length of a step in which the base of a power is nearly zero; may change the jets.

    If this is the square of a norm that comes to zero, `stops`, no power counts as constant.
    """
    code, order, J, z = system.code, truncation.order, scratch.jets, run.state
    scale = time_to_zero_base(code, mode, J)
    hidden = has_zero_series(code, order, mode, J)
    onset = unresolved = 0.0
    if not stops and lacks_series(code, order, mode, J):
        onset = measured_function_step(system, truncation, mode, left, run, scratch)
        onset = remainder_step(system, truncation, mode, onset, False, hidden, run, scratch)
        onset = onset_step(system, truncation, mode, onset, run, scratch)
    if not stops:
        unresolved = unresolved_time(code, system.magnitudes, mode, z, J, scratch.bounds)
    h = min(left, max(onset, unresolved, CLOCK_RESOLUTION * run.times[NOW]))
    few = truncate_series_near_zero(code, system.numbers, mode, order, z, h, J)
    if few < MIN_USEFUL_ORDER:
        return h
    shorter = Truncation(few, truncation.tol)
    return remainder_step(system, shorter, mode, min(left, scale), False, hidden, run, scratch)


@inlined
def take_taylor_step(system, truncation, run, record, scratch):
    """Take one step, up to an event if there is one; returns the status of the run."""
    code, order, J = system.code, truncation.order, scratch.jets
    counts = run.counts
    mode = counts[MODE]
    if counts[JETS_READY] == 0:
        mode_jets(code, system.numbers, mode, order, run.state, J)
        for g in range(scratch.leading_zeros.shape[0]):
            scratch.leading_zeros[g] = 0
    counts[JETS_READY] = 0
    left, time = remaining_time(run.times), math.inf
    if code.powers[mode]:
        time = time_to_stop(code, system.numbers, mode, J)
    if time <= time_near_stop(run.times[NOW], run.times[NOW] - run.times[ENTERED]):
        truncate_series_at_stop(code, system.numbers, mode, J)
        h = min(left, PAST_STOP * time)
    elif code.powers[mode] and has_base_near_zero(code, order, mode, run.times[NOW], J):
        h = power_onset_step(system, truncation, mode, left, time < math.inf, run, scratch)
        if not largest_coefficient(J, 0, run.state.shape[0], 1) < math.inf:
            return NOT_FINITE
    else:
        h = step_length(code, order, truncation.tol, J)
        if not h > 0.0:
            return NOT_FINITE
        longest = min(h, left)
        h = measured_function_step(system, truncation, mode, longest, run, scratch)
        blind = needs_remainder(code, order, mode, longest, left)
        # Polynomials of low degree have a zero series only where states are exactly zero: as a mode begins.
        hidden = (blind or run.times[NOW] == run.times[ENTERED]) and has_zero_series(code, order, mode, J)
        if hidden or blind:
            visible = not hidden and polynomials_visible(code, order, mode, longest, left)
            h = remainder_step(system, truncation, mode, h, visible, hidden, run, scratch)
    zero = first_event(system, mode, run.state, order, h, False, scratch)
    event, status = step_to_event(system, truncation, zero, left, run, record, scratch)
    if event.guard == NO_GUARD:
        return status
    if has_modes_on_demand(code):
        return leave_event(event, run)
    return handle_event(system, truncation, event, run, record, scratch)


@inlined
def step_to_event(system, truncation, zero, left, run, record, scratch):
    """Go on to the first zero of the guards' series, by `left` at most, along the jets in `scratch`.

    Returns the event, which is yet to be handled, and the status of the run where there is none.
    """
    code, order, J = system.code, truncation.order, scratch.jets
    times, counts = run.times, run.counts
    mode, goes_on = counts[MODE], False
    if is_zero_truncated(code, zero, mode, order, J):
        zero = refine_zero(system, mode, zero, left, order, scratch)
    h, guard, _ = zero
    if h > 0.0:
        row = counts[STEPS]
        record.step_times[row, 0] = times[NOW]
        record.step_times[row, 1] = h
        record.step_modes[row] = mode
        copy_vector(run.state, record.step_states[row])
        counts[STEPS] += 1
        if code.sections.shape[1]:
            record_section_events(system, order, mode, h, run, record, scratch)
        states_at(J, order, h, run.state)
        goes_on = advance_clock(times, h, left)
        if guard != NO_GUARD:
            record_sizes(record.step_states[row], J[:, 1], h, run)
    status = RUNNING
    if guard == NO_GUARD and not goes_on:
        status = count_repeat(counts)
    return zero, status


@kernel
def advance_taylor(system, truncation, run, record, scratch):
    """Run until the end, an error, an event left to the caller, or a buffer that may be full (RUNNING)."""
    times, counts = run.times, run.counts
    room = record.point_times.shape[0] - (truncation.order + 2) * system.code.sections.shape[1]
    event_room = record.event_times.shape[0] - scratch.impacts.guards.shape[0]
    while times[NOW] < times[END]:
        full = counts[STEPS] == record.step_modes.shape[0] or counts[EVENTS] > event_room
        if full or counts[POINTS] > room:
            return RUNNING
        status = take_taylor_step(system, truncation, run, record, scratch)
        if status != RUNNING:
            return status
    return FINISHED
