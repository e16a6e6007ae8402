"""How a periodic orbit closes: its state returns, up to turns of cyclic coordinates.

Where nothing depends on how far cyclic coordinates have turned together, only what is left of the state
without that shift has to return: P (x(T) - x(0)) = 0 with a projection P.  The monodromy matrix is then P M,
which has the multiplier 0 for the shift.  A coordinate that enters as an angle returns up to whole turns.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.steady_state.drift import TURN, shifts_without_effect
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import end_rates


class Closing(NamedTuple):
    """What of a motion has to return.

    Parameters
    ----------
    projection : array (n, n) or None
        P; None where the whole state has to return.
    angles : tuple of int
        Places of the states that return up to whole turns.
    """

    projection: Array | None = None
    angles: tuple[int, ...] = ()

    def difference(self, states: Array, other: Array) -> Array:
        """How far states (..., n) are from another one, but for turns."""
        away = states - other
        for place in self.angles:
            away[..., place] -= TURN * np.round(away[..., place] / TURN)
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
    automaton = run.automaton
    if not automaton.cyclic:
        return Closing()
    places = [automaton.state_names.index(name) for name in automaton.cyclic]
    shifts = shifts_without_effect(run, places)
    if shifts is None:
        return Closing()
    if shifts.turning:
        return Closing(angles=tuple(shifts.turning))
    projection = np.eye(len(automaton.state_names))
    projection[np.ix_(places, places)] = shifts.across @ np.linalg.pinv(shifts.across)
    return Closing(projection)
