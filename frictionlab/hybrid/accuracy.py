"""How exact a run is: the defect of its steps, and how far samples violate the conditions of their modes.

Between two stored states a run is a polynomial in time, its dense output.  Put into the equations it leaves a
residual x' - f(x), and where another method than the series chose the next state, a jump at its end.  Either,
over a step and as a share of the motion's size, is what the step adds to the error: it compares with the
tolerance. Whether event functions are positive and constraints zero at the samples is checked by their values
alone, independently of how events are located.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels.jets import (
    MACHINE_EPSILON,
    majorant,
    mode_jets,
    polynomial_slope,
    run_tape,
    states_at,
)
from frictionlab.hybrid.kernels.run_state import jet_columns
from frictionlab.hybrid.kernels.taylor_steps import step_series
from frictionlab.hybrid.problem import Problem, RunData
from frictionlab.hybrid.tape.program import Numbers

CHECK_POINTS = 8  # in a step, the zeros of a Chebyshev polynomial: dense towards its ends
# Share of the terms of a sum that may be rounding, which is no defect.
RESIDUAL_ROUNDING = 8 * MACHINE_EPSILON
UNKNOWN_END = np.nan  # end of a step too short for the clock, so that its event is not told from earlier ones


class StoredSteps(NamedTuple):
    """Steps of a run: start and length, mode, states at the start, and at the end before an event."""

    times: np.ndarray  # (steps, 2)
    modes: np.ndarray
    states: np.ndarray
    ends: np.ndarray


class DefectScratch(NamedTuple):
    """Scratch arrays: series, values and their majorants; a state, the sums of its absolute terms; the
    largest error of each state and its largest value in the step."""

    jets: np.ndarray
    values: np.ndarray
    bounds: np.ndarray
    z: np.ndarray
    sums: np.ndarray
    errors: np.ndarray
    sizes: np.ndarray


def defects(
    problem: Problem, raw: RunData, order: int, chosen: np.ndarray | None = None
) -> Mapping[str, float]:
    """The largest defect of a run's steps, or of those `chosen`, by the name of the mode."""
    program, steps = problem.program, stored_steps(raw)
    if chosen is None:
        chosen = np.arange(len(raw.step_modes))
    worst = np.full(len(program.modes), -1.0)
    absolute = Numbers(*map(np.abs, problem.numbers))
    room = _new_scratch(program.slots, raw.state.size, order)
    with np.errstate(all="ignore"):
        measure_defects(
            native_code(program).code, problem.numbers, absolute, order, steps, chosen, worst, room
        )
    found = zip(program.modes, worst.tolist())
    return MappingProxyType({name: defect for name, defect in found if defect >= 0.0})


def stored_steps(raw: RunData) -> StoredSteps:
    """The steps with the states at their ends: the next stored state, or the state before the event there."""
    times = np.append(raw.step_times[1:, 0], raw.t)[: len(raw.step_times)]
    ends = np.concatenate([raw.step_states[1:], raw.state[None]])[: len(times)]
    first = np.searchsorted(raw.event_times, times)
    at_event = np.append(raw.event_times, np.inf)[first] == times
    ends[at_event] = raw.event_states[first[at_event], 0]
    ends[at_event & (raw.step_times[:, 0] == times)] = UNKNOWN_END
    return StoredSteps(raw.step_times, raw.step_modes, raw.step_states, ends)


def _new_scratch(slots: int, states: int, order: int) -> DefectScratch:
    series, values, bounds = (np.zeros((slots, jet_columns(k))) for k in (order, 0, 0))
    return DefectScratch(series, values, bounds, *np.zeros((4, states)))


@kernel
def measure_defects(code, numbers, absolute, order, steps, chosen, worst, room):
    """Write the largest defect of each mode's steps into `worst`."""
    for step in chosen:
        mode, h = steps.modes[step], steps.times[step, 1]
        if h > 0.0:
            begin_step(code, numbers, order, mode, h, steps.states[step], room)
            for point in range(CHECK_POINTS):
                s = 0.5 * h * (1.0 - math.cos(math.pi * (point + 0.5) / CHECK_POINTS))
                record_residuals(code, numbers, absolute, order, mode, s, room)
            for i in range(room.errors.shape[0]):
                room.errors[i] *= h
            record_jump(code, order, mode, h, steps.ends[step], room)
            worst[mode] = max(worst[mode], relative_defect(code, room))


@kernel
def begin_step(code, numbers, order, mode, h, state, room):
    """The series of a step, no errors yet, and the sizes at its start."""
    step_series(code, numbers, mode, order, h, state, room.jets)
    for i in range(state.shape[0]):
        room.errors[i], room.sizes[i] = 0.0, abs(state[i])


@inlined
def polynomial_magnitude(c, n, s):
    """Sum of the absolute terms of a polynomial at s > 0."""
    total = abs(c[n])
    for k in range(n - 1, -1, -1):
        total = total * s + abs(c[k])
    return total


@inlined
def slope_magnitude(c, n, s):
    """Sum of the absolute terms of its derivative."""
    total = n * abs(c[n])
    for k in range(n - 1, 0, -1):
        total = total * s + k * abs(c[k])
    return total


@inlined
def larger_or_infinite(error, worst):
    """The larger of the two; infinite where the error is no number."""
    if error <= worst:
        return worst
    return error if error == error else math.inf


@kernel
def states_and_sums(order, s, room):
    """The states at time `s` of a step, and what their rounding errors are relative to."""
    states_at(room.jets, order, s, room.z)
    for i in range(room.z.shape[0]):
        room.sums[i] = polynomial_magnitude(room.jets[i], order, s)
        room.sizes[i] = max(room.sizes[i], abs(room.z[i]))


@kernel
def record_residuals(code, numbers, absolute, order, mode, s, room):
    """Record |x' - f(x)| at time `s` of a step, less what rounding explains."""
    states_and_sums(order, s, room)
    mode_jets(code, numbers, mode, 0, room.z, room.values)
    majorant(code, absolute, mode, 0, room.sums, room.values, room.bounds)
    for i in range(room.z.shape[0]):
        slot, c = code.flow[mode, i], room.jets[i]
        residual = abs(polynomial_slope(c, order, s) - room.values[slot, 0])
        rounding = RESIDUAL_ROUNDING * (room.bounds[slot, 0] + slope_magnitude(c, order, s))
        room.errors[i] = larger_or_infinite(residual - rounding, room.errors[i])


@kernel
def record_jump(code, order, mode, h, end, room):
    """Record the jump from the end of the polynomial to the next state, less what rounding explains."""
    states_and_sums(order, h, room)
    for i in range(room.z.shape[0]):
        if end[i] == end[i]:
            rounding = RESIDUAL_ROUNDING * (room.sums[i] + h * room.bounds[code.flow[mode, i], 0])
            room.errors[i] = larger_or_infinite(abs(end[i] - room.z[i]) - rounding, room.errors[i])


@kernel
def relative_defect(code, room):
    """The largest error as a share of the largest state of its group: coordinates, velocities, others."""
    worst = 0.0
    for group in range(3):
        error = size = 0.0
        for i in range(code.groups[group], code.groups[group + 1]):
            error, size = max(error, room.errors[i]), max(size, room.sizes[i])
        if error > 0.0:
            worst = larger_or_infinite(error / size, worst)
    return worst


def condition_violation(problem: Problem, raw: RunData, states: np.ndarray, modes: np.ndarray) -> float:
    """Most that samples of a run violate a condition of their modes, as a share of the condition's size.

    Event functions must not be negative, constraints must be zero.  The size of a condition is the largest
    sum of its absolute terms along the run, in whatever mode: where a flight begins the gap is all rounding,
    and a flight may be as short as one likes.

    Parameters
    ----------
    problem, raw : Problem, RunData
        Of the run.
    states : array (N, states)
        Samples of it.
    modes : int array (N,)
        The mode of each.
    """
    worst = 0.0
    for mode in np.unique(modes):
        inside = states[modes == mode]
        amounts, terms = _condition_values(problem, mode, np.vstack([inside, raw.step_states]))
        sizes = np.where(np.isfinite(terms), terms, 0.0).max(axis=0)  # elsewhere it may be none, as sqrt(gap)
        shares = amounts[: len(inside), sizes > 0] / sizes[sizes > 0]
        worst = max(worst, shares.max(initial=0.0))
    return float(worst)


def _condition_values(problem: Problem, mode: int, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By how much states (N, n) violate a mode's conditions (N, k), and the sums of their absolute terms."""
    code, numbers = problem.program.code, problem.numbers
    absolute, J = Numbers(*map(np.abs, numbers)), np.zeros((problem.program.slots, 1))
    guards = code.function_slots[code.mode_guards[mode] : code.mode_guards[mode + 1]]
    fixed = code.function_slots[code.mode_constraints[mode] : code.mode_constraints[mode + 1]]
    amounts = np.empty((len(states), len(guards) + len(fixed)))
    terms, sums = np.empty_like(amounts), J.copy()
    for i, z in enumerate(states):
        J[: len(z), 0] = z
        run_tape(code, numbers, code.mode_ops[mode], code.mode_ops[mode + 1], 0, code.flow[mode], -1.0, J, J)
        majorant(code, absolute, mode, 0, z, J, sums)
        amounts[i] = np.append(-J[guards, 0], np.abs(J[fixed, 0]))
        terms[i] = np.append(sums[guards, 0], sums[fixed, 0])
    return amounts, terms
