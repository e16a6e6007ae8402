"""The problem that a method integrates, and the data that it returns.

A `Problem` is a program with its numbers, an initial state and an end.  Kernels fill records of fixed
capacity; `RecordList` joins these to `RunData`, the arrays that a
:class:`~frictionlab.hybrid.trajectory.Trajectory` wraps, and `Status` says in a sentence how the run ended.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.kernels.run_state import Record, new_record
from frictionlab.hybrid.tape.program import Code, Numbers, Program


@dataclass(frozen=True)
class Problem:
    """A program with its numbers, the initial state, the mode to start in (None: choose) and the end.

    Where only some modes are derived, `derive` gives program and numbers with that of one combination more;
    all that were in the program keep their numbers.
    """

    program: Program
    numbers: Numbers
    x0: np.ndarray
    t_end: float
    mode: int | None = None
    derive: Callable[[tuple[int, ...]], tuple[Program, Numbers]] | None = None

    def with_mode(self, combination: np.ndarray) -> Problem:
        """The problem with the mode of one combination more."""
        assert self.derive is not None
        program, numbers = self.derive(tuple(combination.tolist()))
        return replace(self, program=program, numbers=numbers)


class RunData(NamedTuple):
    """What a method computed, as arrays; :class:`~frictionlab.hybrid.trajectory.Trajectory` wraps it.

    A step is its start time, its length, its mode and the state at its start; an event its time, the
    guard, the mode entered (-1: none), whether it closed an accumulation, and the states around it.
    """

    step_times: np.ndarray  # (steps, 2)
    step_modes: np.ndarray  # (steps,)
    step_states: np.ndarray  # (steps, states)
    event_times: np.ndarray  # (events,)
    event_codes: np.ndarray  # (events, 3)
    event_states: np.ndarray  # (events, 2, states)
    point_times: np.ndarray  # (points,) section points
    point_sections: np.ndarray
    point_states: np.ndarray
    t: float
    state: np.ndarray
    mode: int
    status: Status

    def cut(self, states: int) -> RunData:
        """The data without the integrals, which follow the first `states` states."""
        if self.state.size == states:
            return self
        names = ("step_states", "event_states", "point_states", "state")
        return self._replace(**{name: getattr(self, name)[..., :states].copy() for name in names})


class Status(Enum):
    """How a run ended; the value is a sentence that says what happened and what can be done."""

    FINISHED = "finished: the end time was reached"
    NO_ADMISSIBLE_MODE = (
        "no admissible mode: after the last event no mode of the automaton could be entered; "
        "check the model's laws there, or the initial state"
    )
    STALLED = (
        "stalled: time no longer advances; the step or the dwell times fell below the resolution of time"
    )
    ACCUMULATED = "accumulation: events piled up in finite time; use accumulation='close' to pass such points"
    NOT_FINITE = (
        "not finite: a state overflowed or its rate is no number; end the run earlier where the motion is "
        "unbounded, or see where a law is not defined"
    )
    STEP_CAP = "step cap: max_steps was reached before the end time; raise it to go on"
    EVENT_CAP = "event cap: max_events was reached before the end time; raise it to go on"
    INTERRUPTED = "interrupted: stopped by ctrl-C; the run is kept up to there"
    RUNNING = "running"

    def __str__(self) -> str:
        return self.value

    @property
    def ok(self) -> bool:
        """Whether the end time was reached."""
        return self is Status.FINISHED


class RecordList:
    """Records in the order in which they were filled.

    Attributes
    ----------
    copied : bool
        Whether what is kept of the last record is a copy, so that it can be filled again.
    """

    def __init__(self) -> None:
        self._parts: list[Record] = []
        self.steps, self.events, self.copied = 0, 0, False

    def add(self, record: Record, steps: int, events: int, points: int) -> None:
        """Keep the filled part of a record."""
        lengths = [steps] * 3 + [events] * 3 + [points] * 3
        cut = (
            array[:n].copy() if n < len(array) else array for array, n in zip(record, lengths, strict=True)
        )
        self._parts.append(Record(*cut))
        self.copied = all(n < len(array) for array, n in zip(record, lengths) if len(array))
        self.steps += int(steps)
        self.events += int(events)

    def raw(self, code: Code, t: float, state: np.ndarray, mode: int, status: Status) -> RunData:
        """Everything joined."""
        parts = self._parts or [new_record(code, 0, 0, 0)]
        arrays = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
        joined = dict(zip(Record._fields, arrays))
        return RunData(**joined, t=float(t), state=state, mode=mode, status=status)
