"""scipy's integrators on the same automaton, for cross-checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from frictionlab.compilation.loaded_kernels import prepared_call
from frictionlab.hybrid.kernels import event_handling, run_state
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.kernels.jets import majorant, mode_jets, slot_gradients, state_rates
from frictionlab.hybrid.kernels.step_length import LEAST_TANGENCY, base_of_root, time_near_stop
from frictionlab.hybrid.methods.base import ActiveRun, Method
from frictionlab.hybrid.methods.runge_kutta import guard_at_stop, record_step
from frictionlab.validation import check_choice, check_field, explains_fields

IMPLICIT_INTEGRATORS = ("Radau", "BDF", "LSODA")
INTEGRATORS = ("RK23", "RK45", "DOP853", *IMPLICIT_INTEGRATORS)


@explains_fields
@dataclass(frozen=True)
class Scipy(Method):
    """One of scipy's integrators, stopped at every event.

    An event is found where a guard changes its sign between the ends of a step, as in
    :func:`scipy.integrate.solve_ivp`; two zeros within one step are missed.  The implicit integrators are
    given the exact Jacobian, because finite differences at states as small as `atol`, as after a start from
    rest, are rounding errors alone.

    Parameters
    ----------
    integrator : str
        RK23, RK45, DOP853, Radau, BDF or LSODA.
    rtol, atol : float
        Relative and absolute tolerance.
    max_step : float or None
        Longest step in seconds, None for no limit.  With half of the shortest stay in a mode no event is
        missed.
    chatter : float or None
        As that of :class:`Taylor`; None takes a share of 2e-4: the flights that the tolerances resolve are
        longer.
    max_steps, max_events : int
        A run that reaches one ends with a status and keeps what it has.
    """

    name: ClassVar[str] = "scipy"
    entry: ClassVar[Any] = staticmethod(event_handling.handle_event)
    parts: ClassVar[int] = 4
    chatter_share: ClassVar[float] = 2e-4  # 1e-6 s for the paper's model

    integrator: str = "DOP853"
    rtol: float = 1e-10
    atol: float = 1e-13
    max_step: float | None = None
    chatter: float | None = None

    def __post_init__(self) -> None:
        check_choice("integrator", self.integrator, INTEGRATORS)
        check_field(self, "rtol", least=3e-14, below=1.0, cure="1e-10 is the default")
        check_field(self, "atol", least=0.0, cure="1e-13 is the default")
        if self.max_step is not None:
            check_field(self, "max_step", above=0.0, cure="leave it out for no limit")
        if self.chatter is not None:
            check_field(self, "chatter", least=0.0, cure="leave it out for a share of the motion's time")
        self.check_caps()

    @property
    def degree(self) -> int:
        return 20

    @property
    def event_tol(self) -> float:
        return self.rtol

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        """Run up to the next event, to the end, or until the record is full."""
        cursor = run.cursor
        solver = self.solver_of(run)
        if solver is None:
            return run_state.NOT_FINITE
        guards = Guards(run, self.rtol, self.atol)
        while solver.status == "running" and cursor.counts[run_state.STEPS] < len(record.step_modes):
            solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                return run_state.NOT_FINITE
            length, guard = guards.first(solver)
            goal = cursor.times[run_state.NOW] + length
            new = solver.y if guard < 0 else solver.dense_output()(goal)
            if length > 0.0:
                record_step(length, goal, new, cursor, record)
                cursor.counts[run_state.REPEATED] = 0
            elif guard < 0:  # at a singularity LSODA steps for ever without advancing time
                cursor.counts[run_state.REPEATED] += 1
                if event_handling.status_after_repeat(cursor.counts) != run_state.RUNNING:
                    return run_state.STALLED
            cursor.state[:] = new
            if guard >= 0:
                return self.handle_event(run, GuardZero(length, guard, 1), record)
        if solver.status == "running":
            return run_state.RUNNING
        cursor.times[run_state.NOW] = cursor.times[run_state.END]
        return run_state.FINISHED

    def solver_of(self, run: ActiveRun) -> Any:
        """scipy's integrator at the state of the run; None where a rate there is not finite."""
        from scipy import integrate

        problem, cursor = run.problem, run.cursor
        code, mode = run.native.code, int(cursor.counts[run_state.MODE])

        at, rate = np.empty_like(cursor.state), np.empty_like(cursor.state)
        arguments = (code, problem.numbers, mode, at, run.scratch.jets, rate)
        write_rates = prepared_call(state_rates, arguments, place=2)

        def rates(t: float, z: np.ndarray) -> np.ndarray:
            at[:] = z
            write_rates(mode)
            return rate.copy()

        def jacobian(t: float, z: np.ndarray) -> np.ndarray:
            tangents = np.empty((problem.program.slots, len(z)))
            slot_gradients(code, problem.numbers, mode, np.ascontiguousarray(z), run.scratch.jets, tangents)
            return tangents[code.flow[mode]]

        start, end = cursor.times[run_state.NOW], cursor.times[run_state.END]
        if not np.isfinite(rates(start, cursor.state)).all():  # scipy would look for a first step for ever
            return None
        settings: dict[str, Any] = {"rtol": self.rtol, "atol": self.atol}
        settings["max_step"] = np.inf if self.max_step is None else self.max_step
        if self.integrator in IMPLICIT_INTEGRATORS:
            settings["jac"] = jacobian
        return getattr(integrate, self.integrator)(rates, start, cursor.state.copy(), end, **settings)


class Guards:
    """Values of the current mode's guards along scipy's steps."""

    def __init__(self, run: ActiveRun, rtol: float, atol: float) -> None:
        self._run, self._rtol, self.least = run, rtol, atol / rtol
        code, self.mode = run.problem.program.code, int(run.cursor.counts[run_state.MODE])
        self.numbers_of_guards = range(code.mode_guards[self.mode], code.mode_guards[self.mode + 1])

        slots = code.function_slots[self.numbers_of_guards.start : self.numbers_of_guards.stop]
        roots = [base_of_root(code, run.problem.numbers, self.mode, int(slot)) for slot in slots]
        self.slots, self.norms = slots, [(i, square) for i, square in enumerate(roots) if square >= 0]
        self.start = run.cursor.state  # of the step

    def values(self, z: np.ndarray) -> np.ndarray:
        """Values of the guards.  A norm is positive on both sides of its zero, so twice the inner product of
        its vector with that at the start takes its place: 4 |(a + b)/2|^2 - |a|^2 - |b|^2, which is at most
        2 |a| |b|.  For another root that is less, with the sign of its base."""
        values, start = self._slots(z, self.slots), self.start
        for i, square in self.norms:
            middle, one, other = (self._slots(at, square) for at in (0.5 * (start + z), start, z))
            most = 2.0 * np.copysign(np.sqrt(abs(one * other)), other)
            values[i] = min(4.0 * middle - one - other, most)
        return values

    def _slots(self, z: np.ndarray, slots: Any) -> Any:
        run, jets = self._run, self._run.scratch.jets
        z = np.ascontiguousarray(z)
        state_rates(run.native.code, run.problem.numbers, self.mode, z, jets, np.empty_like(z))
        return jets[slots, 0].copy()

    def only_turned(self, i: int, z: np.ndarray, t: float) -> bool:
        """Whether a guard is a norm whose vector at `z`, at right angles to the first, is not zero.

        It is zero where accelerations bring it there within the time near a stop, or up to the tolerance.
        """
        square = dict(self.norms).get(i)
        if square is None:
            return False
        run, code = self._run, self._run.native.code
        z, jets, bounds = np.ascontiguousarray(z), run.scratch.jets, run.scratch.bounds
        mode_jets(code, run.problem.numbers, self.mode, 2, z, jets)
        majorant(code, run.system.magnitudes, self.mode, 0, np.abs(z) + self.least, jets, bounds)
        base, slope, curvature = jets[square, :3]
        if not 4.0 * base * curvature > LEAST_TANGENCY * slope**2:  # the zero of another root is simple
            return False
        way = self._time_near_stop(t) ** 2 * curvature
        return bool(base > max(way, self._rtol**2 * bounds[square, 0]))

    def near_stop(self, z: np.ndarray, t: float) -> int:
        """The guard that is a norm, and so near to zero at `z` that steps would come to an end; or -1."""
        run = self._run
        about = run.native.code, run.problem.numbers, self.mode, self._time_near_stop(t)
        return int(guard_at_stop(*about, np.ascontiguousarray(z), run.scratch.jets).guard)

    def _time_near_stop(self, t: float) -> float:
        return time_near_stop(t, t - float(self._run.cursor.times[run_state.ENTERED]))

    def first(self, solver: Any) -> tuple[float, int]:
        """Time from the step's start to its first event, and the guard; its whole length and -1 for none."""
        start, end = self._run.cursor.times[run_state.NOW], solver.t
        failing = np.flatnonzero(self.values(solver.y) < 0.0)
        if not failing.size:
            return end - start, self.near_stop(solver.y, end)
        dense = solver.dense_output()
        places = {int(i): self.root(lambda t, i=i: self.values(dense(t))[i], start, end) for i in failing}
        places = {i: t for i, t in places.items() if not self.only_turned(i, dense(t), t)}
        if not places:
            return end - start, self.near_stop(solver.y, end)
        first = min(places, key=places.__getitem__)
        return places[first] - start, self.numbers_of_guards.start + first

    def root(self, function: Any, start: float, end: float) -> float:
        """Zero between the start, where the guard is positive, and the end, where it is negative."""
        from scipy import optimize

        brentq: Any = optimize.brentq
        if function(end) >= 0.0:  # the dense output differs from the step's end by rounding
            return end
        # After an event the guard may be zero at the start by construction, with any sign by rounding.  So a
        # time is looked for at which it is positive.
        parts = start + (end - start) * 0.5 ** np.arange(1, 40)
        left = next((t for t in parts if function(t) > 0.0), end)
        return start if left == end else float(brentq(function, left, end, xtol=1e-15, rtol=1e-15))
