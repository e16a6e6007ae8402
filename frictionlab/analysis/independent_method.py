"""The independent method of `verify`: DOP853 of scipy with a search for events of its own.

Steps are as long as the integrator's own error control allows.  All over them guards are bounded by intervals
(:mod:`frictionlab.hybrid.guard_bounds`), so that no zero is missed, however short the guard stays negative.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from frictionlab.hybrid.guard_bounds import Pieces, Tape, largest_defect, negative_points, pieces_of
from frictionlab.hybrid.kernels import run_state
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.methods.base import ActiveRun
from frictionlab.hybrid.methods.scipy_methods import Guards, Scipy, record_step

DENSE_ORDER = 7  # of the polynomials of DOP853's dense output
GUARD_RTOL = 1e-10  # share of a guard's size that the dense output does not resolve
DEFECT = 1e-7  # share of the motion's size: more of it in a step is a layer of a law that was passed over
SHORTER, MOST_SHORTENINGS = 0.125, 8
STEPS_AT_ONCE = 24  # whose guards are bounded together, which costs little more than those of one


class Step(NamedTuple):
    """A step of the integrator: where it begins and ends, its dense output, the state at its end."""

    start: float
    end: float
    dense: Any
    state: np.ndarray


@dataclass(frozen=True)
class IndependentMethod(Scipy):
    """DOP853 that misses no event."""

    name: ClassVar[str] = "independent"

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        """Run up to the next event, to the end, or until the record is full."""
        cursor, solver = run.cursor, self.solver_of(run)
        if solver is None:
            return run_state.NOT_FINITE
        guards, shorter = BoundedGuards(run, self.rtol, self.atol), 0
        while solver.status == "running":
            room = len(record.step_modes) - int(cursor.counts[run_state.STEPS])
            if room == 0:
                return run_state.RUNNING
            steps = guards.steps(solver, min(room, STEPS_AT_ONCE))
            if solver.status == "failed" or not steps:
                return run_state.NOT_FINITE
            pieces = guards.pieces(steps)
            longest = guards.longest_step(pieces)
            if longest < np.inf and shorter < MOST_SHORTENINGS:
                solver, shorter = replace(self, max_step=longest).solver_of(run), shorter + 1
                continue
            which, zero, guard = guards.first_of(steps, pieces)
            for step in steps[: which + 1]:
                end = zero if step is steps[which] else step.end
                new = step.state if end == step.end else step.dense(end)
                if end > step.start:
                    record_step(end - step.start, end, new, cursor, record)
                    cursor.counts[run_state.REPEATED] = 0
                cursor.state[:] = new
            if guard >= 0:
                return self.handle_event(run, GuardZero(zero - steps[which].start, guard, 1), record)
            if shorter and solver.status == "running":
                solver, shorter = self.solver_of(run), 0
        cursor.times[run_state.NOW] = cursor.times[run_state.END]
        return run_state.FINISHED


class BoundedGuards(Guards):
    """Guards that are bounded all over the steps; states below ``least`` count as that large."""

    def __init__(self, run: ActiveRun, rtol: float, atol: float) -> None:
        super().__init__(run, rtol, atol)
        self._tape = Tape(run.problem.program.code, run.problem.numbers, self.mode)
        self._sizes = np.zeros(len(self._tape.functions))
        self._groups = run.problem.program.code.groups
        self._largest = np.maximum(np.abs(run.cursor.state), self.least)

    def steps(self, solver: Any, most: int) -> list[Step]:
        """The next steps: at most so many, up to one at whose end a guard is negative."""
        steps: list[Step] = []
        while solver.status == "running" and len(steps) < most:
            self.start = solver.y.copy()
            solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                break
            steps.append(Step(float(solver.t_old), float(solver.t), solver.dense_output(), solver.y.copy()))
            if (self.values(solver.y) < 0.0).any():
                break
        return steps

    def first_of(self, steps: list[Step], pieces: Pieces) -> tuple[int, float, int]:
        """The first event: its step, its time and its guard; the end of the last step and -1 for none."""
        which, zero, guard = len(steps) - 1, steps[-1].end, -1
        bad = negative_points(self._tape, pieces, self._bounds(pieces))
        if len(bad.times):
            k = int(bad.times.argmin())
            which = max(int(np.searchsorted(pieces.starts, bad.times[k])) - 1, 0)
            zero, guard = self._zero(steps[which], int(bad.functions[k]), float(bad.times[k]))
        # What is below zero by less than that at the end of the last step has its zero there as well.
        last = steps[-1]
        if which == len(steps) - 1:
            self.start = last.dense(last.start)
            for function in np.flatnonzero(self.values(last.state) < 0.0):
                other = self._zero(last, int(function), last.end)
                if not self.only_turned(int(function), last.dense(other[0]), other[0]):
                    zero, guard = min((zero, guard), other) if guard >= 0 else other
        return which, zero, guard

    def longest_step(self, pieces: Pieces) -> float:
        """The longest step that would not pass over what the rates do within; infinite where none did."""
        defect = largest_defect(self._tape, pieces, self._state_sizes(pieces))
        if not defect.share > DEFECT:
            return np.inf
        which = max(int(np.searchsorted(pieces.starts, defect.time, side="right")) - 1, 0)
        return float(pieces.lengths[which]) * SHORTER

    def _zero(self, step: Step, function: int, end: float) -> tuple[float, int]:
        """The zero of a guard between the start of a step and a time at which it is negative."""
        self.start = step.dense(step.start)
        zero = self.root(lambda t: self.values(step.dense(t))[function], step.start, end)
        return zero, self.numbers_of_guards.start + function

    def pieces(self, steps: list[Step]) -> Pieces:
        """The steps as pieces."""
        starts, ends = (np.array([step[i] for step in steps]) for i in (0, 1))
        at = DENSE_ORDER + 1

        def states(t: np.ndarray) -> np.ndarray:
            parts = zip(steps, t.reshape(-1, at), strict=True)
            return np.concatenate([step.dense(times).T for step, times in parts])

        return pieces_of(starts, ends - starts, DENSE_ORDER, states)

    def _state_sizes(self, pieces: Pieces) -> np.ndarray:
        """The largest value of each state's group so far."""
        self._largest = np.maximum(self._largest, np.abs(pieces.coefficients.sum(axis=1)).max(axis=0))
        sizes = np.ones_like(self._largest)
        for first, last in zip(self._groups[:-1], self._groups[1:], strict=True):
            sizes[first:last] = self._largest[first:last].max(initial=0.0) or 1.0
        return sizes

    def _bounds(self, pieces: Pieces) -> np.ndarray:
        self._sizes = np.maximum(self._sizes, self._tape.sizes(pieces.coefficients.sum(axis=1)))
        bounds = -GUARD_RTOL * self._sizes
        bounds[len(self._tape.guards) :] = -np.inf  # what drifts off a constraint is no event
        return bounds
