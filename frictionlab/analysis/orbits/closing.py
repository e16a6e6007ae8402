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
    turns : tuple of (int, array (n,))
        Places of the states that return up to whole turns, each with how far all states move in a turn.
    """

    projection: Array | None = None
    turns: tuple[tuple[int, Array], ...] = ()

    def difference(self, states: Array, other: Array) -> Array:
        """How far states (..., n) are from another one, but for turns."""
        away = states - other
        for place, turn in self.turns:
            away = away - np.round(away[..., place] / turn[place])[..., None] * turn
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


def closing_of(run: Trajectory) -> Closing:
    """What of a motion has to return, by the modes that a run of it visits."""
    automaton, turns = run.automaton, turns_of_phases(run)
    if not automaton.cyclic:
        return Closing(None, turns)
    places = [automaton.state_names.index(name) for name in automaton.cyclic]
    shifts = shifts_without_effect(run, places)
    if shifts is None:
        return Closing(None, turns)
    if shifts.turning:
        return Closing(None, (*turns, *_turns_of_angles(shifts, len(automaton.state_names))))
    projection = np.eye(len(automaton.state_names))
    projection[np.ix_(places, places)] = shifts.across @ np.linalg.pinv(shifts.across)
    return Closing(projection, turns)


def _turns_of_angles(shifts: Drift, states: int) -> Iterator[tuple[int, Array]]:
    """The angles that return up to whole turns, and how far others turn with each."""
    others = [place for place in shifts.places if place not in shifts.turning]
    for angle in shifts.turning:
        turn = np.zeros(states)
        turn[angle] = TURN
        turn[others] = -TURN * shifts.across[shifts.places.index(angle)]
        yield angle, turn
