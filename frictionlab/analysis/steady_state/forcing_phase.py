"""The phase of a periodic force as a state: its reset once a period is no event of the motion.

For comparisons the phase is a point on a circle, so that the end of a period is its beginning.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.automaton import Mode
from frictionlab.hybrid.trajectory import Trajectory


def phase_resets(run: Trajectory) -> np.ndarray:
    """Which events (E,) only set a phase back: no coordinate, velocity or mode changes."""
    events, automaton = run.events, run.automaton
    if not _other_states(run):
        return np.zeros(len(events), dtype=bool)
    pairs = list(zip(events.source.tolist(), events.guard.tolist()))
    modes = {name: automaton.modes[automaton.names.index(name)] for name in {*events.source.tolist()}}
    known = {(name, guard) for name, mode in modes.items() for guard in _phase_guards(run, mode)}
    return np.array([pair in known for pair in pairs], dtype=bool)


def _phase_guards(run: Trajectory, mode: Mode) -> list[str]:
    """The events of a mode that set a phase back."""
    others = _other_states(run)
    return [
        e.name
        for e in mode.events
        if e.targets == (mode.name,) and e.reset.jump and {*e.reset.jump} <= others
    ]


def _other_states(run: Trajectory) -> set[Any]:
    """The states that are neither coordinates nor velocities."""
    first = 2 * run.automaton.coordinates
    return {*run.automaton.states[first:]} if first else set()


def only_phase_resets(run: Trajectory) -> bool:
    """Whether a motion stays in one mode without events but the resets of a phase."""
    return bool(phase_resets(run).all())


def covers_period(run: Trajectory) -> bool:
    """Whether every phase of a run without other events has gone through a whole period; true without
    phases."""
    events, passed = run.events, run.final_state - run.raw.step_states[0]
    for guard in _phase_guards(run, run.automaton.modes[run.raw.mode]):
        at = np.flatnonzero(events.guard == guard)
        if not len(at) or (len(at) == 1 and (passed * (events.before[at] - events.state[at]) < 0.0).any()):
            return False
    return True


def phase_on_circle(run: Trajectory, states: Array) -> Array:
    """States (N, m) of a run with every phase as a point on a circle."""
    at, columns = phase_resets(run), [*states.T]
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
