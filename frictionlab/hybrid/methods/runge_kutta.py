"""Explicit Runge-Kutta methods by their tableau, in a compiled loop of steps.

Methods of fixed steps check the conditions of a mode only at the end of a step.  What they do there is here
too: they find the condition that fails, keep to the time grid, record steps and events, and choose the next
mode.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.kernels.event_handling import (
    count_at_instant,
    handle_event,
    handle_event_on_demand,
    leave_event,
    status_after_repeat,
)
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING, LOW_ORDER, GuardZero
from frictionlab.hybrid.kernels.impacts import is_short, keep_regimes_until_impacts, note_resolution
from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON, copy_vector, mode_jets, state_rates, states_at
from frictionlab.hybrid.kernels.mode_selection import (
    ADMITTED,
    BY_VALUES,
    NO_MODE,
    Rounding,
    Selection,
    apply_reset,
    has_modes_on_demand,
    is_impact,
    select_combination,
    set_zeros_by_construction,
    try_mode_by_values,
)
from frictionlab.hybrid.kernels.run_state import (
    CELL,
    END,
    ENTERED,
    EVENTS,
    FINISHED,
    MODE,
    MODE_NOT_DERIVED,
    NO_ADMISSIBLE_MODE,
    NO_REGIME,
    NOT_FINITE,
    NOW,
    RUNNING,
    STEPS,
    Truncation,
)
from frictionlab.hybrid.kernels.step_length import first_stop, step_length, step_of_turn, time_near_stop

BISECTIONS = 50  # halvings of a step: 2^-50 of it is rounding
TURN_ORDER = 8  # of the series by which steps are chosen where v_r in the plane may turn
STOP_ORDER = 2  # of the series of a step to a stop, in which accelerations are constant
LARGEST_STATE = 1e300  # beyond, a state counts as not finite
SIMPLE = 1  # multiplicity of a zero that bisection finds: the guard's sign changes there
NO_GUARD, NO_STATE = -1, -2  # no guard fails; the state is not finite


@inlined
def failed_guard(code, numbers, mode, z, J):
    """First guard of the mode that is negative at `z`; NO_GUARD, or NO_STATE where `z` is not finite."""
    mode_jets(code, numbers, mode, 0, z, J)
    for i in range(z.shape[0]):
        if not abs(z[i]) < LARGEST_STATE:
            return NO_STATE
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if J[code.function_slots[g], 0] < 0.0:
            return g
    return NO_GUARD


@kernel
def select_mode_by_values(system, queue, guard, run, scratch):
    """First target whose conditions hold by their values; those that the event made zero do.

    So slip is entered after a re-contact, whatever the penetration rate.  The guard itself is negative where
    no reset makes it zero, as at a border: what it is a condition of does not go on.  Where all comes to
    rest, what is left is a rounding error of the states before.
    """
    z = run.state
    set_zeros_by_construction(system.code, guard, 0, scratch)
    if system.code.resets[guard, 0] < 0:
        scratch.structural_zeros[system.code.function_classes[guard]] = 0
    rounding = Rounding(run.sizes, COEFFICIENT_ROUNDING)
    if queue is not None:
        scratch.impacts.guards[0] = guard
        keep_regimes_until_impacts(system, queue, 0.0, 1, run, scratch)
        selection = select_combination(system, queue, guard, z, rounding, BY_VALUES, scratch)
        queue.kept[:] = NO_REGIME
        return selection
    for mode in system.code.targets[guard]:
        if try_mode_by_values(system, mode, z, rounding, scratch) == ADMITTED:
            return Selection(mode, NO_MODE)
    return Selection(NO_MODE, NO_MODE)


@kernel
def change_mode(system, queue, event, run, record, scratch):
    """Record the event, reset the state, enter the mode that :func:`select_mode_by_values` chooses.

    Where it finds none, nothing is done.
    """
    counts, guard = run.counts, event.guard
    row = counts[EVENTS]
    record.event_times[row] = run.times[NOW]
    copy_vector(run.state, record.event_states[row, 0])
    apply_reset(system, system.code.resets[guard, 0], run.state, scratch.jets)
    for i in range(run.state.shape[0]):
        run.sizes[i] = max(run.sizes[i], abs(run.state[i]))
    mode, missing = select_mode_by_values(system, queue, guard, run, scratch)
    if mode == NO_MODE:
        copy_vector(record.event_states[row, 0], run.state)
        if missing == NO_MODE:
            return NO_ADMISSIBLE_MODE
        leave_event(event, run)
        return MODE_NOT_DERIVED
    copy_vector(run.state, record.event_states[row, 1])
    record.event_codes[row, 0] = guard
    record.event_codes[row, 1] = mode
    record.event_codes[row, 2] = 0
    counts[EVENTS] += 1
    count_at_instant(system.code, guard, run)
    counts[MODE] = mode
    return status_after_repeat(counts)


@inlined
def order_of_choice(system, event, order, run, scratch):
    """Up to which order the next mode is chosen: by series where an accumulation of impacts may end."""
    note_resolution(system, event.guard, run, scratch)
    may_end = is_impact(system.code, event.guard) and is_short(run)
    return LOW_ORDER if order == BY_VALUES and may_end else order


@kernel
def enter_next_mode(system, event, order, run, record, scratch):
    """Handle an event; the next mode is chosen by series up to `order`, or at 0 by values of conditions.

    Where values allow no mode, as several conditions fail at one instant, series say which of them are zero.
    """
    order = order_of_choice(system, event, order, run, scratch)
    if order == BY_VALUES:
        status = change_mode(system, None, event, run, record, scratch)
        if status != NO_ADMISSIBLE_MODE:
            return status
        order = LOW_ORDER
    return handle_event(system, exact(order), event, run, record, scratch)


@kernel
def enter_next_mode_on_demand(system, queue, event, order, run, record, scratch):
    """As :func:`enter_next_mode`, for modes on demand, which are chosen among combinations of regimes."""
    order = order_of_choice(system, event, order, run, scratch)
    if order == BY_VALUES:
        status = change_mode(system, queue, event, run, record, scratch)
        if status != NO_ADMISSIBLE_MODE:
            return status
        order = LOW_ORDER
    return handle_event_on_demand(system, queue, exact(order), event, run, record, scratch)


@inlined
def exact(order):
    """Series up to an order, for steps taken to end exactly at events: the tolerance is zero."""
    return Truncation(order, 0.0)


@kernel
def end_of_cell(step, run):
    """Where the current cell of the time grid ends."""
    return min((run.counts[CELL] + 1) * step, run.times[END])


@kernel
def record_step(h, goal, new, run, record):
    """Record a step of length `h`, and go on to its end, the state `new` at the time `goal`."""
    row = run.counts[STEPS]
    record.step_times[row, 0] = run.times[NOW]
    record.step_times[row, 1] = h
    record.step_modes[row] = run.counts[MODE]
    copy_vector(run.state, record.step_states[row])
    for i in range(new.shape[0]):
        run.sizes[i] = max(abs(run.state[i]), abs(new[i]))
    run.counts[STEPS] += 1
    copy_vector(new, run.state)
    run.times[NOW] = goal


@kernel
def is_full(run, record, scratch):
    """Whether there is no room for another step, or for its events."""
    counts, event_room = run.counts, record.event_times.shape[0] - scratch.impacts.guards.shape[0]
    return counts[STEPS] == record.step_modes.shape[0] or counts[EVENTS] > event_room


class Tableau(NamedTuple):
    """Coefficients of an explicit Runge-Kutta method (Butcher's tableau).

    Stage s is the rate f at z + h (sum of stages[s][j] times stage j); the step ends at
    z + h/divisor (sum of weights[s] times stage s).
    """

    stages: tuple[tuple[float, ...], ...]  # a row for each stage, with a number for each stage before it
    weights: tuple[float, ...]
    divisor: float = 1.0


class Scheme(NamedTuple):
    """A tableau as arrays, the length of its steps, and scratch arrays for a step."""

    step: float
    order: int  # of the series by which modes are chosen; 0: by the values of their conditions
    stages: np.ndarray  # (stages, stages)
    weights: np.ndarray  # (stages,)
    divisor: float
    rates: np.ndarray  # (stages, states)
    shifted: np.ndarray  # (states,)
    new: np.ndarray  # (states,) at the end of the step


def new_scheme(tableau: Tableau, step: float, order: int, states: int) -> Scheme:
    """A tableau as arrays."""
    count = len(tableau.weights)
    stages = np.zeros((count, count))
    for row, given in zip(stages, tableau.stages, strict=True):
        row[: len(given)] = given
    room = np.empty((count, states)), np.empty(states), np.empty(states)
    return Scheme(step, order, stages, np.array(tableau.weights), tableau.divisor, *room)


@inlined
def runge_kutta_step(code, numbers, mode, z, h, scheme, J):
    """Step from `z` to ``scheme.new``.  Successive stages of equal weight are added first."""
    rates, shifted, weights = scheme.rates, scheme.shifted, scheme.weights
    for s in range(weights.shape[0]):
        copy_vector(z, shifted)
        for j in range(s):
            if scheme.stages[s, j] != 0.0:
                share = scheme.stages[s, j] * h
                for i in range(z.shape[0]):
                    shifted[i] += share * rates[j, i]
        state_rates(code, numbers, mode, shifted, J, rates[s])
    for i in range(z.shape[0]):
        total, same = -0.0, rates[0, i]  # -0.0 + x is x for every x
        for s in range(1, weights.shape[0]):
            if weights[s] == weights[s - 1]:
                same += rates[s, i]
            else:
                total += weights[s - 1] * same
                same = rates[s, i]
        scheme.new[i] = z[i] + h / scheme.divisor * (total + weights[-1] * same)


@kernel
def bisect_event(code, numbers, mode, z, h, scheme, J):
    """Shortest step after which a guard fails, given that one fails after `h`; (step, guard)."""
    lo = 0.0
    hi = h
    for _ in range(BISECTIONS):
        middle = 0.5 * (lo + hi)
        runge_kutta_step(code, numbers, mode, z, middle, scheme, J)
        if failed_guard(code, numbers, mode, scheme.new, J) == NO_GUARD:
            lo = middle
        else:
            hi = middle
    runge_kutta_step(code, numbers, mode, z, hi, scheme, J)
    return hi, failed_guard(code, numbers, mode, scheme.new, J)


@kernel
def guard_at_stop(code, numbers, mode, h, z, J):
    """When the first guard that is a norm comes to zero within `h`, at constant accelerations: a
    :class:`GuardZero`.

    A norm is not negative anywhere, so that a step does not show it.  Writes the series of the step.
    """
    if not code.powers[mode]:
        return GuardZero(h, NO_GUARD, SIMPLE)
    mode_jets(code, numbers, mode, STOP_ORDER, z, J)
    time, guard = first_stop(code, numbers, mode, J)
    return GuardZero(time, guard, SIMPLE) if time <= h else GuardZero(h, NO_GUARD, SIMPLE)


@kernel
def step_before_stop(code, numbers, mode, h, run, J):
    """A step of a time up to `h`, or up to a stop that is near: a :class:`GuardZero`.

    It is shorter where v_r in the plane is so small that it may turn within `h`: as a series would take it,
    which shows how stiff the direction is.
    """
    if not code.powers[mode]:
        return GuardZero(h, NO_GUARD, SIMPLE)
    now, since = run.times[NOW], run.times[NOW] - run.times[ENTERED]
    zero = guard_at_stop(code, numbers, mode, min(h, time_near_stop(now, since)), run.state, J)
    if zero.guard != NO_GUARD:
        return zero
    turn = step_of_turn(code, numbers, mode, h, J)
    if turn < h:
        order = min(TURN_ORDER, J.shape[1] - 1)
        mode_jets(code, numbers, mode, order, run.state, J)
        turn = min(turn, step_length(code, order, MACHINE_EPSILON, J))
    return GuardZero(min(h, max(turn, time_near_stop(now, 0.0))), NO_GUARD, SIMPLE)


@inlined
def take_runge_kutta_step(system, scheme, run, record, scratch):
    """Step to the end of the current cell of the grid, or up to an event within it; the status of the run."""
    code, numbers, J, new = system.code, system.numbers, scratch.jets, scheme.new
    times, counts = run.times, run.counts
    mode, goal = counts[MODE], end_of_cell(scheme.step, run)
    left = max(goal - times[NOW], 0.0)
    h, stop, _ = step_before_stop(code, numbers, mode, left, run, J)
    if stop != NO_GUARD:
        states_at(J, STOP_ORDER, h, new)
    else:
        runge_kutta_step(code, numbers, mode, run.state, h, scheme, J)
    guard = failed_guard(code, numbers, mode, new, J)
    if guard == NO_STATE:
        return NOT_FINITE
    if guard == NO_GUARD:
        guard = stop
    else:
        h, guard = bisect_event(code, numbers, mode, run.state, h, scheme, J)
    if guard == NO_GUARD and h == left:
        counts[CELL] += 1
    else:
        goal = times[NOW] + h
    record_step(h, goal, new, run, record)
    if guard < 0:
        return RUNNING
    event = GuardZero(h, guard, SIMPLE)
    if has_modes_on_demand(code):
        return leave_event(event, run)
    return enter_next_mode(system, event, scheme.order, run, record, scratch)


@kernel
def advance_runge_kutta(system, scheme, run, record, scratch):
    """Run until the end, an error, an event left to the caller, or a full buffer (RUNNING)."""
    while run.times[NOW] < run.times[END]:
        if is_full(run, record, scratch):
            return RUNNING
        status = take_runge_kutta_step(system, scheme, run, record, scratch)
        if status != RUNNING:
            return status
    return FINISHED
