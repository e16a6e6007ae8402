"""Explicit Runge-Kutta methods by their tableau: the loop of their steps, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels.event_handling import leave_event
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.kernels.jets import copy_vector, state_rates
from frictionlab.hybrid.kernels.mode_selection import has_modes_on_demand
from frictionlab.hybrid.kernels.run_state import CELL, END, FINISHED, MODE, NOT_FINITE, NOW, RUNNING
from frictionlab.hybrid.methods.step_events import (
    BISECTIONS,
    NO_GUARD,
    NO_STATE,
    SIMPLE,
    end_of_cell,
    enter_next_mode,
    failed_guard,
    is_full,
    record_step,
)


class Tableau(NamedTuple):
    """Coefficients of an explicit Runge-Kutta method (Butcher's tableau).

    Stage s is the rate f at z + h (sum of stages[s][j] times stage j); the step ends at
    z + h/divisor (sum of weights[s] times stage s).
    """

    stages: tuple[tuple[float, ...], ...]  # a row for each stage, with a number for each stage before it
    weights: tuple[float, ...]
    divisor: float = 1.0


class Scheme(NamedTuple):
    """A tableau and the length of its steps as arrays, with room for a step."""

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
    """Step from `z` to ``scheme.new``.  Stages of one weight that follow each other are added first."""
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


@inlined
def take_runge_kutta_step(system, scheme, run, record, scratch):
    """To the end of the current cell of the grid, or up to an event within it."""
    code, numbers, J, new = system.code, system.numbers, scratch.jets, scheme.new
    times, counts = run.times, run.counts
    mode, goal = counts[MODE], end_of_cell(scheme.step, run)
    h = max(goal - times[NOW], 0.0)
    runge_kutta_step(code, numbers, mode, run.state, h, scheme, J)
    guard = failed_guard(code, numbers, mode, new, J)
    if guard == NO_STATE:
        return NOT_FINITE
    if guard == NO_GUARD:
        counts[CELL] += 1
    else:
        h, guard = bisect_event(code, numbers, mode, run.state, h, scheme, J)
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
    """Run until the end, an error, an event that is left, or until a buffer is full (RUNNING)."""
    while run.times[NOW] < run.times[END]:
        if is_full(run, record):
            return RUNNING
        status = take_runge_kutta_step(system, scheme, run, record, scratch)
        if status != RUNNING:
            return status
    return FINISHED
