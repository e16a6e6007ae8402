"""Another tool's integrator as a method: it integrates and finds the events, resets and modes are ours."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid import stepping
from frictionlab.hybrid.methods import Method, Run

from .lowered import Lowered, lowered

CHATTER = 1e-6


@dataclass(frozen=True)
class External(Method):
    """Base of the adapters: a subclass gives :meth:`to_event`.

    Parameters
    ----------
    automaton : HybridAutomaton
        What is to be run: other tools need its expressions.
    """

    entry: ClassVar[Any] = staticmethod(stepping.handle_event)

    automaton: HybridAutomaton

    @property
    def degree(self) -> int:
        return 20

    @property
    def limits(self) -> tuple[float, float]:
        return 0.0, CHATTER

    @abstractmethod
    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        """Integrate in a mode up to its first event or the end: time, state, its guard or -1, steps."""

    def mode(self, number: int) -> Lowered:
        """The compiled functions of a mode."""
        values = tuple(self.automaton.parameters.items())
        return lowered(self.automaton.modes[number], self.automaton.states, values)

    def advance(self, run: Run, record: stepping.Record) -> int:
        """One flow up to its event, entered as one step; the tool's own steps are added to the count."""
        cursor, code = run.cursor, run.problem.program.code
        times, counts = cursor.times, cursor.counts
        mode = int(counts[stepping.MODE])
        now, end = float(times[stepping.NOW]), float(times[stepping.END])
        t, z, guard, _ = self.to_event(mode, cursor.state.copy(), now, end)
        row = counts[stepping.STEPS]
        record.step_times[row] = now, t - now
        record.step_modes[row] = mode
        record.step_states[row] = cursor.state
        counts[stepping.STEPS] += 1
        times[stepping.NOW], cursor.state[:] = t, z
        if guard < 0:
            return stepping.FINISHED if t >= end else stepping.NOT_FINITE
        guard += int(code.mode_guards[mode])
        arrays = code, run.problem.numbers, run.absolute
        return stepping.handle_event(*arrays, guard, 1, self.degree, cursor, record, run.work)
