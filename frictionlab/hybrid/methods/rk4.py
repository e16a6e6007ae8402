"""The paper's algorithm (its Fig. 19) as a method: fixed steps, conditions checked at the end of each
step."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels import run_state
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.jets import copy_vector, majorant, mode_jets, state_rates
from frictionlab.hybrid.kernels.mode_selection import NO_MODE, NOT_DERIVED, Rounding, apply_reset, is_excluded
from frictionlab.hybrid.kernels.run_state import (
    CELL,
    END,
    ENTERED,
    EVENTS,
    FINISHED,
    MODE,
    NO_ADMISSIBLE_MODE,
    NOT_FINITE,
    NOW,
    RUNNING,
    STEPS,
)
from frictionlab.hybrid.methods.base import ActiveRun, Method
from frictionlab.validation import check_number

BISECTIONS = 50


@inlined
def rk4_step(code, numbers, mode, z, h, J, stages, new):
    """Classical Runge-Kutta step from `z`; `stages` (5, states) is scratch."""
    shifted = stages[4]
    state_rates(code, numbers, mode, z, J, stages[0])
    for s in range(1, 4):
        share = h if s == 3 else 0.5 * h
        for i in range(z.shape[0]):
            shifted[i] = z[i] + share * stages[s - 1, i]
        state_rates(code, numbers, mode, shifted, J, stages[s])
    for i in range(z.shape[0]):
        new[i] = z[i] + h / 6.0 * (stages[0, i] + 2.0 * (stages[1, i] + stages[2, i]) + stages[3, i])


@inlined
def failed_guard(code, numbers, mode, z, J):
    """First guard of the mode that is negative at `z`; -1 where all hold, -2 where one is no number."""
    mode_jets(code, numbers, mode, 0, z, J)
    for i in range(z.shape[0]):
        if not abs(z[i]) < 1e300:
            return -2
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if J[code.function_slots[g], 0] < 0.0:
            return g
    return -1


@kernel
def bisect_event(code, numbers, mode, z, h, J, stages, new):
    """Shortest step after which a guard fails, given that one fails after `h`; (step, guard)."""
    lo = 0.0
    hi = h
    for _ in range(BISECTIONS):
        middle = 0.5 * (lo + hi)
        rk4_step(code, numbers, mode, z, middle, J, stages, new)
        if failed_guard(code, numbers, mode, new, J) == -1:
            lo = middle
        else:
            hi = middle
    rk4_step(code, numbers, mode, z, hi, J, stages, new)
    return hi, failed_guard(code, numbers, mode, new, J)


@kernel
def select_mode_by_values(code, numbers, absolute, guard, z, work):
    """First target whose conditions hold by their values alone; what the event made zero holds.

    So slip is entered after a re-contact whatever the penetration rate.
    """
    J = work.jets
    declared = code.declared[guard, 0]
    for mode in code.targets[guard]:
        if code.built[mode] == 0:
            rounding = Rounding(z, COEFFICIENT_ROUNDING)
            if is_excluded(code, numbers, absolute, mode, z, rounding, declared, J, work.bounds):
                continue
            return NOT_DERIVED - mode
        mode_jets(code, numbers, mode, 0, z, J)
        majorant(code, absolute, mode, 0, z, J, work.bounds)
        fits = True
        for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
            if declared[g] == 0 and J[code.function_slots[g], 0] < 0.0:
                fits = False
        for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
            slot = code.function_slots[f]
            if declared[f] == 0 and abs(J[slot, 0]) > COEFFICIENT_ROUNDING * work.bounds[slot, 0]:
                fits = False
        if fits:
            return mode
    return NO_MODE


@kernel
def change_mode(code, numbers, absolute, guard, cursor, record, work):
    """Record the event, reset, enter the next mode."""
    counts = cursor.counts
    row = counts[EVENTS]
    record.event_times[row] = cursor.times[NOW]
    copy_vector(cursor.state, record.event_states[row, 0])
    apply_reset(code, numbers, code.resets[guard, 0], cursor.state, work.jets)
    mode = select_mode_by_values(code, numbers, absolute, guard, cursor.state, work)
    if mode < NO_MODE:
        copy_vector(record.event_states[row, 0], cursor.state)
        return mode
    copy_vector(cursor.state, record.event_states[row, 1])
    record.event_codes[row, 0] = guard
    record.event_codes[row, 1] = mode
    record.event_codes[row, 2] = 0
    counts[EVENTS] += 1
    cursor.times[ENTERED] = cursor.times[NOW]
    if mode == NO_MODE:
        return NO_ADMISSIBLE_MODE
    counts[MODE] = mode
    return RUNNING


@inlined
def take_rk4_step(code, numbers, absolute, step, cursor, record, work, stages, new):
    """To the end of the current cell of the grid, or up to an event within it."""
    times, counts, J = cursor.times, cursor.counts, work.jets
    mode = counts[MODE]
    goal = min((counts[CELL] + 1) * step, times[END])
    h = max(goal - times[NOW], 0.0)
    rk4_step(code, numbers, mode, cursor.state, h, J, stages, new)
    guard = failed_guard(code, numbers, mode, new, J)
    if guard == -2:
        return NOT_FINITE
    if guard >= 0:
        h, guard = bisect_event(code, numbers, mode, cursor.state, h, J, stages, new)
        goal = times[NOW] + h
    else:
        counts[CELL] += 1
    row = counts[STEPS]
    record.step_times[row, 0] = times[NOW]
    record.step_times[row, 1] = h
    record.step_modes[row] = mode
    copy_vector(cursor.state, record.step_states[row])
    counts[STEPS] += 1
    copy_vector(new, cursor.state)
    times[NOW] = goal
    if guard < 0:
        return RUNNING
    return change_mode(code, numbers, absolute, guard, cursor, record, work)


@kernel
def advance_rk4(code, numbers, absolute, step, cursor, record, work, stages, new):
    """Run until the end, an error, or until a buffer is full (RUNNING)."""
    times, counts = cursor.times, cursor.counts
    while times[NOW] < times[END]:
        if counts[STEPS] == record.step_modes.shape[0] or counts[EVENTS] == record.event_times.shape[0]:
            return RUNNING
        status = take_rk4_step(code, numbers, absolute, step, cursor, record, work, stages, new)
        if status != RUNNING:
            return status
    return FINISHED


@dataclass(frozen=True)
class RK4(Method):
    """The algorithm of the paper's Fig. 19: classical Runge-Kutta on a fixed time grid.

    The conditions of a mode are checked only at the end of a step; where one fails, bisection finds
    the instant within the step, the state changes, and the rest of the step follows.  After a re-contact
    slip is entered.  What happens and ends within a step is not seen, so the results depend on `step`;
    use it to compare with the paper.

    Parameters
    ----------
    step : float
        Length of a step in seconds.
    max_steps, max_events : int
        A run that reaches one ends with a status and keeps what it has.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.01, method=fl.RK4(step=1e-3))
    >>> run.stats["steps"]
    10
    """

    name: ClassVar[str] = "rk4"
    entry: ClassVar[Any] = staticmethod(advance_rk4)

    step: float = 2e-4
    max_steps: int = field(default=10_000_000, kw_only=True)

    def __post_init__(self) -> None:
        check_number("step", self.step, above=0.0, cure="2e-4 s reproduces the paper")
        self.check_caps()

    @property
    def degree(self) -> int:
        return 8

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        problem, states = run.problem, len(run.cursor.state)
        arrays = run.natives.code, problem.numbers, run.absolute
        scratch = np.empty((5, states)), np.empty(states)
        return advance_rk4(*arrays, self.step, run.cursor, record, run.work, *scratch)
