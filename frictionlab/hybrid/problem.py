"""What every method is given to integrate, and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.layout import Numbers, Program
from frictionlab.hybrid.status import Status


class Unbuilt(Exception):
    """A run came to where a mode is to be tried that has yet to be derived; `mode` is its number."""

    def __init__(self, mode: int) -> None:
        super().__init__(mode)
        self.mode = mode


@dataclass(frozen=True)
class Problem:
    """A program with its numbers, the initial state, the mode to start in (None: choose) and the end."""

    program: Program
    numbers: Numbers
    x0: np.ndarray
    t_end: float
    mode: int | None = None


class Raw(NamedTuple):
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

    def cut(self, states: int) -> Raw:
        """The same without the integrals that follow the first `states` states."""
        if self.state.size == states:
            return self
        names = ("step_states", "event_states", "point_states", "state")
        return self._replace(**{name: getattr(self, name)[..., :states].copy() for name in names})
