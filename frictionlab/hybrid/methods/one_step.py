"""Methods of fixed steps, which check the conditions of a mode when a step is over.

`OneStepMethod` does all that does not depend on how a step is taken: the time grid, the search for events,
the choice of modes, the record.  `RK4`, the paper's algorithm (its Fig. 19), is one of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from frictionlab.hybrid.kernels import run_state
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.kernels.jets import state_rates, states_at
from frictionlab.hybrid.kernels.mode_selection import BY_VALUES
from frictionlab.hybrid.kernels.run_state import CELL, END, FINISHED, MODE, NOT_FINITE, NOW, RUNNING
from frictionlab.hybrid.methods.base import ActiveRun, Method
from frictionlab.hybrid.methods.runge_kutta import (
    BISECTIONS,
    NO_GUARD,
    NO_STATE,
    SIMPLE,
    STOP_ORDER,
    Tableau,
    advance_runge_kutta,
    end_of_cell,
    enter_next_mode,
    enter_next_mode_on_demand,
    failed_guard,
    is_full,
    new_scheme,
    record_step,
    step_before_stop,
)
from frictionlab.validation import check_field, check_number, check_sequence, explains_fields

Rates = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class OneStepMethod(Method):
    """Base of methods that go from one state to the next in steps of a fixed length.

    A subclass gives its `name` and either a `tableau`, whose steps are compiled, or `take_step`.  All else is
    done here.  The conditions of a mode are checked when a step is over; where one fails, bisection finds
    the instant within the step, the mode changes, and the rest of the step follows.  A condition that fails
    only within a step is not noticed.  Where v_r of friction in the plane may turn within a step, shorter
    steps are taken, so that only a stop counts as one.

    Parameters
    ----------
    step : float
        Length of a step in seconds.
    max_steps, max_events : int
        A run that reaches one ends with a status and keeps what it has.

    Examples
    --------
    Heun's method, of order 2:

    >>> import frictionlab as fl
    >>> class Heun(fl.OneStepMethod):
    ...     name = "heun"
    ...     tableau = fl.Tableau(stages=((), (1.0,)), weights=(1.0, 1.0), divisor=2.0)
    >>> fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.01, method=Heun(step=1e-3)).stats["steps"]
    10
    """

    tableau: ClassVar[Tableau | None] = None
    chooses_by_values: ClassVar[bool] = False  # choose modes by values of conditions, not by their series

    step: float = 1e-3
    max_steps: int = field(default=10_000_000, kw_only=True)

    def __post_init__(self) -> None:
        check_field(self, "step", above=0.0, cure="2e-4 s reproduces the paper")
        self.check_caps()
        if self.tableau is not None:
            _check_tableau(self.tableau)

    @property
    def entry(self) -> Any:
        """The kernel that takes longest to compile."""
        return enter_next_mode if self.tableau is None else advance_runge_kutta

    @property
    def degree(self) -> int:
        return 8

    def take_step(self, rates: Rates, z: np.ndarray, h: float) -> np.ndarray:
        """The state a time `h` after `z`, in the mode whose `rates` are given as a function of the state."""
        raise NotImplementedError(
            f"the method {type(self).__name__} says nothing of its steps: give it a tableau, or "
            "take_step(self, rates, z, h)"
        )

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        if self.tableau is not None:
            scheme = new_scheme(self.tableau, float(self.step), self._order, len(run.cursor.state))
            return advance_runge_kutta(run.system, scheme, run.cursor, record, run.scratch)
        times = run.cursor.times
        while times[NOW] < times[END]:
            if is_full(run.cursor, record, run.scratch):
                return RUNNING
            status = self._advance_step(run, record)
            if status != RUNNING:
                return status
        return FINISHED

    def handle_event(self, run: ActiveRun, event: GuardZero, record: run_state.Record) -> int:
        arrays = run.cursor, record, run.scratch
        if run.queue is None:
            return enter_next_mode(run.system, event, self._order, *arrays)
        return enter_next_mode_on_demand(run.system, run.queue, event, self._order, *arrays)

    @property
    def _order(self) -> int:
        return BY_VALUES if self.chooses_by_values else self.degree

    def _advance_step(self, run: ActiveRun, record: run_state.Record) -> int:
        """As :func:`take_runge_kutta_step`, by :meth:`take_step`."""
        cursor = run.cursor
        now, goal = cursor.times[NOW], end_of_cell(self.step, cursor)
        left = max(goal - now, 0.0)
        about = run.system.code, run.system.numbers, cursor.counts[MODE]
        h, stop, _ = step_before_stop(*about, left, cursor, run.scratch.jets)
        if stop != NO_GUARD:
            new = np.empty_like(cursor.state)
            states_at(run.scratch.jets, STOP_ORDER, h, new)
            guard = failed_guard(*about, new, run.scratch.jets)
        else:
            new, guard = self._try_step(run, h)
        if guard == NO_STATE:
            return NOT_FINITE
        if guard == NO_GUARD:
            guard = stop
        else:
            h, new, guard = self._bisect_event(run, h)
        if guard == NO_GUARD and h == left:
            cursor.counts[CELL] += 1
        else:
            goal = now + h
        record_step(h, goal, new, cursor, record)
        if guard < 0:
            return RUNNING
        return self.handle_event(run, GuardZero(h, guard, SIMPLE), record)

    def _try_step(self, run: ActiveRun, h: float) -> tuple[np.ndarray, int]:
        """The state after `h`, and the guard that fails there."""
        mode, tape = run.cursor.counts[MODE], (run.system.code, run.system.numbers)

        def rates(z: np.ndarray) -> np.ndarray:
            out = np.empty(len(z))
            state_rates(*tape, mode, np.ascontiguousarray(z, dtype=float), run.scratch.jets, out)
            return out

        new = np.ascontiguousarray(self.take_step(rates, run.cursor.state.copy(), h), dtype=float)
        return new, failed_guard(*tape, mode, new, run.scratch.jets)

    def _bisect_event(self, run: ActiveRun, h: float) -> tuple[float, np.ndarray, int]:
        """As :func:`bisect_event`; returns the length, the state there and the guard."""
        safe, length = 0.0, h
        for _ in range(BISECTIONS):
            middle = 0.5 * (safe + length)
            if self._try_step(run, middle)[1] == NO_GUARD:
                safe = middle
            else:
                length = middle
        return length, *self._try_step(run, length)


@explains_fields
@dataclass(frozen=True)
class RK4(OneStepMethod):
    """The algorithm of the paper's Fig. 19: classical Runge-Kutta on a fixed time grid.

    The conditions of a mode are checked only at the end of a step; where one fails, bisection finds
    the instant within the step, the mode changes, and the rest of the step follows.  After a re-contact
    slip is entered, also where an impact opens the gap again.  A condition that fails only within a step is
    not noticed, so that flights shorter than a step are passed over.  Where a contact bounces, errors are of
    first order in `step`; use this method to compare with the paper.

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
    chooses_by_values: ClassVar[bool] = True
    tableau: ClassVar[Tableau | None] = Tableau(
        stages=((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)), weights=(1.0, 2.0, 2.0, 1.0), divisor=6.0
    )

    step: float = 2e-4


def _check_tableau(tableau: Tableau) -> None:
    """Raise ValueError unless each stage uses only stages before it, and has a weight."""
    cure = "give (), (a,), (a, b), ..."
    rows = check_sequence("stages of a tableau", tableau.stages, cure)
    for row in (*rows, tableau.weights):
        one = check_sequence("a row of a tableau", row, cure)
        for number in one:
            check_number("a number of a tableau", number, cure=cure)
    check_number("divisor of a tableau", tableau.divisor, cure="give the sum of the weights")
    if tableau.divisor == 0.0 or not rows:
        raise ValueError("a tableau must have a stage, and a divisor that is not 0, got none: " + cure)
    lengths = [len(row) for row in tableau.stages]
    if len(lengths) != len(tableau.weights) or any(count > s for s, count in enumerate(lengths)):
        raise ValueError(
            "stages of a tableau must have a row for each weight, with numbers for the stages before it, "
            f"got rows of {lengths} numbers for {len(tableau.weights)} weights: give (), (a,), (a, b), ...; "
            "an implicit method gives take_step"
        )
