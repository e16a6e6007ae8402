"""Another tool's integrator as a method: it integrates and finds the events; resets and mode choice are ours.

Tools are given a mode's flow, event functions and Jacobian as functions of floats, compiled by numba
where it is installed.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache
from typing import Any, ClassVar, NamedTuple

import numpy as np
import sympy

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.compilation.loaded_kernels import prepared_call
from frictionlab.compilation.machine_code import HAS_MACHINE_CODE
from frictionlab.hybrid.kernels import event_handling, run_state
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.methods.base import ActiveRun, Method, RecordList
from frictionlab.hybrid.methods.scipy_methods import Scipy
from frictionlab.hybrid.problem import Problem, Status
from frictionlab.presentation import import_optional

Array = Any

SAME_INSTANT = 1e-12  # s: a zero so soon after the start of a mode is the one just left
MAX_RESTARTS = 3  # most integrations to get past such a zero
WARM_UP_TIME = 1e-6  # s


class CompiledMode(NamedTuple):
    """A mode: functions of (z, out) that write into `out`; the parameter values are compiled in."""

    rates: Callable[[Array, Array], None]
    guards: Callable[[Array, Array], None]
    jacobian: Callable[[Array, Array], None]  # Jacobian of the rates, row by row
    count: int  # of guards


@lru_cache(maxsize=64)
def compile_mode(mode: Mode, states: tuple[Any, ...], values: tuple[tuple[Any, float], ...]) -> CompiledMode:
    """Functions of a mode with these parameter values; compiled by numba where it is installed."""
    numbers = dict(values)
    flow = [sympy.sympify(e, strict=True).subs(numbers) for e in mode.flow]
    guards = [sympy.sympify(event.function, strict=True).subs(numbers) for event in mode.events]
    jacobian = list(sympy.Matrix(flow).jacobian(states))
    return CompiledMode(
        _compile_function(states, flow),
        _compile_function(states, guards),
        _compile_function(states, jacobian),
        len(guards),
    )


def _compile_function(states: tuple[Any, ...], expressions: list[Any]) -> Callable[[Array, Array], None]:
    """f(z, out), from the source that sympy prints."""
    z = [sympy.Symbol(f"z{i}") for i in range(len(states))]
    shared, results = sympy.cse([e.xreplace(dict(zip(states, z, strict=True))) for e in expressions])
    lines = ["def function(z, out):", *(f"    z{i} = z[{i}]" for i in range(len(z)))]
    lines += [f"    {name} = {sympy.pycode(value)}" for name, value in shared]
    lines += [f"    out[{i}] = {sympy.pycode(value)}" for i, value in enumerate(results)] or ["    pass"]
    space: dict[str, Any] = {"math": np}
    exec("\n".join(lines), space)
    return compile_peer(space["function"])


def compile_peer(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of another method, compiled by numba; plain Python where our kernels are too."""
    if not HAS_MACHINE_CODE:
        return function
    return import_optional("numba", "what other tools call", "compile").njit(function)


@dataclass(frozen=True)
class ExternalMethod(Method):
    """Base of the adapters: a subclass implements :meth:`to_event`.

    Parameters
    ----------
    automaton : HybridAutomaton
        The automaton to be run: other tools need its expressions.
    max_steps : int
        Most of the tool's own steps; a run that reaches it ends with a status.
    """

    entry: ClassVar[Any] = staticmethod(event_handling.handle_event)
    chatter = None
    chatter_share: ClassVar[float] = Scipy.chatter_share

    automaton: HybridAutomaton
    count: list[int] = field(default_factory=lambda: [0], init=False, repr=False, compare=False)

    @property
    def degree(self) -> int:
        return 20

    @property
    def steps(self) -> int:
        """The tool's own steps in the last run."""
        return self.count[0]

    def prepare(self, z: np.ndarray) -> None:
        """Compile what every mode needs, so that no timed run does."""
        with np.errstate(all="ignore"):
            for mode in range(len(self.automaton.modes)):
                self.to_event(mode, z.copy(), 0.0, WARM_UP_TIME)

    @abstractmethod
    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        """Integrate in a mode up to its first event or the end: time, state, its guard or -1, steps.

        `z` is the run's own array and must not be changed; the state returned may be an array of the tool.
        """

    @cached_property
    def values(self) -> tuple[tuple[Any, float], ...]:
        """The parameters and their values; the dwell time `chatter` is the method's, as in `solve`."""
        numbers, limit = self.automaton.parameters.items(), self.chatter_limit(self.automaton)
        return tuple((symbol, limit if symbol.name == "chatter" else number) for symbol, number in numbers)

    @cached_property
    def modes(self) -> list[CompiledMode]:
        """The compiled functions of all modes; kept, as looking them up by their expressions takes time."""
        return [compile_mode(mode, self.automaton.states, self.values) for mode in self.automaton.modes]

    def describe(self) -> dict[str, Any]:
        """Name and settings, without the automaton: copying it would take a share of a run's time."""
        settings = {f.name: getattr(self, f.name) for f in fields(self) if f.init and f.name != "automaton"}
        return {"name": self.name, **settings}

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        """Integrate from event to event until a buffer is full or the run ends; each stretch is one step."""
        counts, status = run.cursor.counts, run_state.RUNNING
        room = min(len(record.step_modes), len(record.event_times))
        switch = self._switch(run, record)
        while status == run_state.RUNNING and counts[run_state.STEPS] < room and self.steps < self.max_steps:
            status = self._flow(run, record, switch)
        return status

    def _switch(self, run: ActiveRun, record: run_state.Record) -> Callable[[GuardZero], int]:
        """The compiled function that handles an event, reset and next mode, and returns the run's status."""
        if run.queue is not None:  # modes are derived on demand
            return lambda event: self.handle_event(run, event, record)
        truncation, example = run_state.Truncation(self.degree, 0.0), GuardZero(0.0, 0, 1)
        arguments = (run.system, truncation, example, run.cursor, record, run.scratch)
        return prepared_call(event_handling.handle_event, arguments, arguments.index(example))

    def _flow(self, run: ActiveRun, record: run_state.Record, switch: Callable[[GuardZero], int]) -> int:
        cursor, code = run.cursor, run.problem.program.code
        times, counts = cursor.times, cursor.counts
        mode = int(counts[run_state.MODE])
        now, end = float(times[run_state.NOW]), float(times[run_state.END])
        row = counts[run_state.STEPS]
        record.step_states[row] = cursor.state
        t, z, guard, steps = self.to_event(mode, cursor.state, now, end)
        self.count[0] += steps
        record.step_times[row] = now, t - now
        record.step_modes[row] = mode
        counts[run_state.STEPS] += 1
        times[run_state.NOW], cursor.state[:] = t, z
        if guard < 0:
            failed = run_state.RUNNING if self.steps >= self.max_steps else run_state.NOT_FINITE
            return run_state.FINISHED if t >= end else failed
        return switch(GuardZero(t - now, guard + int(code.mode_guards[mode]), 1))

    def _begin(self, problem: Problem, order: int) -> ActiveRun:
        self.count[0] = 0
        return super()._begin(problem, order)

    def _status(self, pieces: RecordList) -> Status:
        return Status.STEP_CAP if self.steps >= self.max_steps else super()._status(pieces)


@dataclass(frozen=True)
class RestartedMethod(ExternalMethod):
    """Base for tools whose clock starts at zero in every mode: a subclass implements :meth:`flow`."""

    @abstractmethod
    def flow(self, mode: int, z: np.ndarray, length: float) -> tuple[float, np.ndarray, int, int]:
        """As :meth:`to_event`, with time counted from the start of the integration."""

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        now, guard, total = t, 0, 0
        for _ in range(MAX_RESTARTS):
            passed, z, guard, steps = self.flow(mode, z, t_end - now)
            now, total = now + passed if passed < t_end - now else t_end, total + steps
            # Otherwise this is the zero just left, passed once more by rounding: go on from after it.
            if guard < 0 or now - t >= SAME_INSTANT:
                break
        return now, z, guard, total
