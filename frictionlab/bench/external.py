"""Another tool's integrator as a method: it integrates and finds the events, resets and modes are ours."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid import bookkeeping, handling
from frictionlab.hybrid.buffers import Pieces
from frictionlab.hybrid.methods import Method, Run
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.scipy_methods import CHATTER
from frictionlab.hybrid.status import Status

from .lowered import Lowered, lowered

AT_ONCE = 1e-12  # s: a zero so soon after the start of a mode is the one just left
PASSES = 3  # times that such a zero is passed over
MOMENT = 1e-6  # s


@dataclass(frozen=True)
class External(Method):
    """Base of the adapters: a subclass gives :meth:`to_event`.

    Parameters
    ----------
    automaton : HybridAutomaton
        What is to be run: other tools need its expressions.
    max_steps : int
        Of the tool's own steps; a run that reaches it ends with a status.
    """

    entry: ClassVar[Any] = staticmethod(handling.handle_event)

    automaton: HybridAutomaton
    count: list[int] = field(default_factory=lambda: [0], init=False, repr=False, compare=False)

    @property
    def degree(self) -> int:
        return 20

    @property
    def limits(self) -> tuple[float, float]:
        return 0.0, CHATTER

    @property
    def steps(self) -> int:
        """The tool's own steps in the last run."""
        return self.count[0]

    def prepare(self, z: np.ndarray) -> None:
        """Have compiled what every mode needs, so that no run that is timed does."""
        with np.errstate(all="ignore"):
            for mode in range(len(self.automaton.modes)):
                self.to_event(mode, z.copy(), 0.0, MOMENT)

    @abstractmethod
    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        """Integrate in a mode up to its first event or the end: time, state, its guard or -1, steps."""

    @cached_property
    def values(self) -> tuple[tuple[Any, float], ...]:
        """The parameters with their numbers; that of the limit of chatter is the method's, as in `solve`."""
        numbers = self.automaton.parameters.items()
        return tuple((symbol, CHATTER if symbol.name == "chatter" else number) for symbol, number in numbers)

    @cached_property
    def modes(self) -> list[Lowered]:
        """The compiled functions of all modes; kept, as looking them up by expressions takes its time."""
        return [lowered(mode, self.automaton.states, self.values) for mode in self.automaton.modes]

    def describe(self) -> dict[str, Any]:
        """Name and settings without the automaton, whose copy would take a share of a run."""
        settings = {f.name: getattr(self, f.name) for f in fields(self) if f.init and f.name != "automaton"}
        return {"name": self.name, **settings}

    def advance(self, run: Run, record: bookkeeping.Record) -> int:
        """Flows up to their events, each entered as one step, until a buffer is full or the run ends."""
        counts, status = run.cursor.counts, bookkeeping.RUNNING
        room = min(len(record.step_modes), len(record.event_times))
        while (
            status == bookkeeping.RUNNING and counts[bookkeeping.STEPS] < room and self.steps < self.max_steps
        ):
            status = self._flow(run, record)
        return status

    def _flow(self, run: Run, record: bookkeeping.Record) -> int:
        cursor, code = run.cursor, run.problem.program.code
        times, counts = cursor.times, cursor.counts
        mode = int(counts[bookkeeping.MODE])
        now, end = float(times[bookkeeping.NOW]), float(times[bookkeeping.END])
        t, z, guard, steps = self.to_event(mode, cursor.state.copy(), now, end)
        self.count[0] += steps
        row = counts[bookkeeping.STEPS]
        record.step_times[row] = now, t - now
        record.step_modes[row] = mode
        record.step_states[row] = cursor.state
        counts[bookkeeping.STEPS] += 1
        times[bookkeeping.NOW], cursor.state[:] = t, z
        if guard < 0:
            failed = bookkeeping.RUNNING if self.steps >= self.max_steps else bookkeeping.NOT_FINITE
            return bookkeeping.FINISHED if t >= end else failed
        guard += int(code.mode_guards[mode])
        arrays = code, run.problem.numbers, run.absolute
        return handling.handle_event(*arrays, guard, 1, self.degree, 0.0, cursor, record, run.work)

    def _begin(self, problem: Problem) -> Run:
        self.count[0] = 0
        return super()._begin(problem)

    def _status(self, status: Status, pieces: Pieces) -> Status:
        capped = status is Status.RUNNING and self.steps >= self.max_steps
        return Status.STEP_CAP if capped else super()._status(status, pieces)


@dataclass(frozen=True)
class Restarted(External):
    """Base for tools whose clock starts at zero in every mode: a subclass gives :meth:`flow`."""

    @abstractmethod
    def flow(self, mode: int, z: np.ndarray, length: float) -> tuple[float, np.ndarray, int, int]:
        """As :meth:`to_event`, in the time since the start."""

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        now, guard, total = t, 0, 0
        for _ in range(PASSES):
            passed, z, guard, steps = self.flow(mode, z, t_end - now)
            now, total = now + passed if passed < t_end - now else t_end, total + steps
            # The zero just left, which rounding has made fall once more: to go on from behind it is enough.
            if guard < 0 or now - t >= AT_ONCE:
                break
        return now, z, guard, total
