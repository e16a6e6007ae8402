"""Clocks: states that only tell the time, as the phase of a force, and are set back once a round.

To set one back is no event of the motion, and the end of a round is its beginning.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.automaton import Mode
from frictionlab.hybrid.trajectory import Trajectory

from .recurrence import Array


def ticks(run: Trajectory) -> np.ndarray:
    """Which events (E,) do nothing but set a clock back: no coordinate, velocity or mode changes."""
    events, automaton = run.events, run.automaton
    if not _others(run):
        return np.zeros(len(events), dtype=bool)
    pairs = list(zip(events.source.tolist(), events.guard.tolist()))
    modes = {name: automaton.modes[automaton.names.index(name)] for name in {*events.source.tolist()}}
    known = {(name, guard) for name, mode in modes.items() for guard in _clocks(run, mode)}
    return np.array([pair in known for pair in pairs], dtype=bool)


def _clocks(run: Trajectory, mode: Mode) -> list[str]:
    """The events of a mode that set a clock back."""
    others = _others(run)
    return [
        e.name
        for e in mode.events
        if e.targets == (mode.name,) and e.reset.jump and {*e.reset.jump} <= others
    ]


def _others(run: Trajectory) -> set[Any]:
    """The states that are neither coordinates nor velocities."""
    first = 2 * run.automaton.coordinates
    return {*run.automaton.states[first:]} if first else set()


def undisturbed(run: Trajectory) -> bool:
    """Whether a motion stays in one mode and nothing happens in it."""
    return bool(ticks(run).all())


def come_round(run: Trajectory) -> bool:
    """Whether the clocks of an undisturbed run have shown all their times, if it has any."""
    events, passed = run.events, run.final_state - run.raw.step_states[0]
    for guard in _clocks(run, run.automaton.modes[run.raw.mode]):
        at = np.flatnonzero(events.guard == guard)
        if not len(at) or (len(at) == 1 and (passed * (events.before[at] - events.state[at]) < 0.0).any()):
            return False
    return True


def unwound(run: Trajectory, states: Array) -> Array:
    """States (N, m) of a run with every clock as a point on a circle."""
    at, columns = ticks(run), [*states.T]
    if not at.any():
        return states
    for i, (before, after) in enumerate(zip(run.events.before[at].T, run.events.state[at].T)):
        jumps = np.flatnonzero(before != after)
        if len(jumps):
            first, last = after[jumps[0]], before[jumps[0]]
            angle = 2 * np.pi * (columns[i] - first) / (last - first)
            columns[i] = np.cos(angle)
            columns.append(np.sin(angle))
    return np.column_stack(columns)
