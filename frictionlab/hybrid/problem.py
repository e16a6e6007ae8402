"""The problem that a method integrates, and what it returns: arrays.

A `Problem` is a program with its numbers, an initial state and an end time.  Kernels fill records of fixed
capacity, which are joined into `RunData`, the arrays that a
:class:`~frictionlab.hybrid.trajectory.Trajectory` wraps.  `Status` says in a sentence how the run ended.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from frictionlab.tape.program import Numbers, Program


class Problem(NamedTuple):
    """A program with its numbers, an initial state, an end time, and a mode to start in (None: choose one).

    Two flights in a row shorter than `chatter` (s) are replaced by the limit mode, if there is one.

    Where modes are derived on demand, `derive` takes combinations of regimes and returns the program and its
    numbers with their modes added.  The modes already in the program keep their indices.
    """

    program: Program
    numbers: Numbers
    x0: np.ndarray
    t_end: float
    mode: int | None = None
    derive: Callable[[Sequence[tuple[int, ...]]], tuple[Program, Numbers]] | None = None
    chatter: float = 0.0

    def with_mode(self, combination: np.ndarray) -> Problem:
        """The problem with the mode of one more combination."""
        assert self.derive is not None
        program, numbers = self.derive([tuple(combination.tolist())])
        return self._replace(program=program, numbers=numbers)

    def with_derived_modes(self) -> Problem:
        """The problem with all modes that runs have had derived meanwhile."""
        if self.derive is None:
            return self
        program, numbers = self.derive([])
        return self._replace(program=program, numbers=numbers)


class Sampling(NamedTuple):
    """How a run is sampled: the order of its dense output, and at what times.

    Samples cut each step into `parts`, or are at the times `t_eval`.  `sections` names the recorded ones.
    """

    order: int
    parts: int
    t_eval: np.ndarray | None = None
    sections: tuple[str, ...] = ()


class RunData(NamedTuple):
    """What a method computed, as arrays; :class:`~frictionlab.hybrid.trajectory.Trajectory` wraps it.

    A step has its start time, its length, its mode and the state at its start.  An event has its time, the
    guard, the mode entered (-1: none), whether it closed an accumulation, and the states before and after.
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

    def renumbered(self, before: Program, after: Program) -> RunData:
        """The data of a run of one program with the numbers that modes and guards have in another."""
        if before.modes == after.modes[: len(before.modes)]:
            return self
        places = {name: i for i, name in enumerate(after.modes)}
        modes = np.array([*(places[name] for name in before.modes), -1], dtype=np.int64)
        guards, codes = np.arange(len(before.guards)), self.event_codes.copy()
        source = before.guard_modes
        guards += after.code.mode_guards[modes[source]] - before.code.mode_guards[source]
        codes[:, 0], codes[:, 1] = guards[codes[:, 0]], modes[codes[:, 1]]
        return self._replace(step_modes=modes[self.step_modes], event_codes=codes, mode=int(modes[self.mode]))

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
        "check the model's laws there, or the initial state; a force that jumps where a velocity changes its "
        "sign, and drives it back from either side, is dry friction, which needs a Friction contact"
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
    MEMORY_CAP = (
        "memory cap: what is kept of the run would soon fill the memory that is free; end the run earlier, "
        "go on from its final state, or use fl.ensemble, which keeps no steps"
    )
    INTERRUPTED = "interrupted: stopped by ctrl-C; the run is kept up to there"
    RUNNING = "running"

    def __str__(self) -> str:
        return self.value

    @property
    def ok(self) -> bool:
        """Whether the end time was reached."""
        return self is Status.FINISHED
