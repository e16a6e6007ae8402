"""How a periodic orbit closes: its state returns, up to turns of cyclic coordinates and of phases.

Where nothing depends on how far cyclic coordinates have turned together, only what is left of the state
without that shift has to return: P (x(T) - x(0)) = 0 with a projection P.  The monodromy matrix is then P M,
which has the multiplier 0 for the shift.  A coordinate that enters as an angle returns up to whole turns,
alone or with others that it turns in a ratio, as gears do; a phase up to whole periods, at whose end it may
be seen before its reset or after.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.steady_state.drift import TURN, Drift, shifts_without_effect
from frictionlab.analysis.steady_state.poincare_sections import turns_of_phases
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import end_rates


class Closing(NamedTuple):
    """What of a motion has to return.

    Parameters
    ----------
    projection : array (n, n) or None
        P; None where the whole state has to return.
    turns : tuple of (array (n,), array (n,))
        For each angle how many turns of it a change of the states is, and how far all states move in one.
    """

    projection: Array | None = None
    turns: tuple[tuple[Array, Array], ...] = ()

    def difference(self, states: Array, other: Array) -> Array:
        """How far states (..., n) are from another one, but for turns."""
        away = states - other
        for count, turn in self.turns:
            away = away - np.round(away @ count)[..., None] * turn
        return away if self.projection is None else away @ self.projection.T

    def matrix(self, fundamental: Array) -> Array:
        """The monodromy matrix."""
        return fundamental if self.projection is None else self.projection @ fundamental

    def end_rates(self, run: Trajectory) -> tuple[Array, Array]:
        """Rates (n,) of the state at both ends of a run, without the shift."""
        first, last = end_rates(run)
        if self.projection is None:
            return first, last
        return self.projection @ first, self.projection @ last


def but_for_turns(run: Trajectory, state: Array, other: Array) -> Array:
    """The difference (n,) of two states of a motion, but for whole periods of its phases."""
    return Closing(None, turns_of_phases(run)).difference(state, other)


def closing_of(run: Trajectory) -> Closing:
    """What of a motion has to return, by the modes that a run of it visits."""
    automaton, turns = run.automaton, turns_of_phases(run)
    if not automaton.cyclic:
        return Closing(None, turns)
    places = [automaton.state_names.index(name) for name in automaton.cyclic]
    shifts = shifts_without_effect(run, places)
    if shifts is None:
        return Closing(None, turns)
    if shifts.winding.size:
        return Closing(None, (*turns, *_turns_of_angles(shifts, len(automaton.state_names))))
    projection = np.eye(len(automaton.state_names))
    projection[np.ix_(places, places)] = shifts.across @ np.linalg.pinv(shifts.across)
    return Closing(projection, turns)


def _turns_of_angles(shifts: Drift, states: int) -> Iterator[tuple[Array, Array]]:
    """The turns of angles, alone or with others; across them nothing moves."""
    others = shifts.across.shape[1]
    moves = np.linalg.inv(np.hstack([shifts.across, shifts.winding]).T)
    for j in range(shifts.winding.shape[1]):
        count, turn = np.zeros((2, states))
        count[shifts.places], turn[shifts.places] = shifts.winding[:, j] / TURN, TURN * moves[:, others + j]
        yield count, turn
