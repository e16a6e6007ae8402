"""Is what closes a periodic orbit?  Checks that are independent of how it was found."""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.admissible import violation
from frictionlab.hybrid.tangent_flow import end_rates

from .recurrence import sizes
from .returns import Guess
from .shooting import Shot

SHRUNK = 1e-3  # share of the guess's size below which an orbit is but an equilibrium
ADMISSIBLE = 1e-6  # share of a condition's terms by which it may be violated
INVARIANT = 1e-6  # share by which the monodromy matrix may miss the direction of the flow


def check_moves(shot: Shot, guess: Guess) -> None:
    """Raise for what closes because it does not move."""
    if (sizes(shot.run.states) / guess.size).max() < SHRUNK:
        raise ValueError(
            "no periodic orbit found near the guess: Newton's method reached an equilibrium, "
            f"{shot.run.raw.step_states[0]}: give a guess nearer to an orbit"
        )


def check_closes_in_mode(shot: Shot) -> None:
    """Raise for what closes in its states only.

    At zero relative velocity, between kinetic and static friction, both slip and stick may begin: what slips
    away from such a state and comes back to stick there does not repeat.
    """
    names = shot.run.automaton.names
    first, last = names[int(shot.run.raw.step_modes[0])], names[shot.run.raw.mode]
    if first != last:
        raise ValueError(
            f"no periodic orbit found near the guess: what Newton's method reached begins in mode {first!r} "
            f"and comes back to the same state in mode {last!r}: give a guess nearer to an orbit"
        )


def check_orbit(shot: Shot, guess: Guess) -> None:
    """Raise for an orbit that ends in another mode than it begins in, that breaks a condition of its modes,
    or whose monodromy matrix is useless.
    """
    check_closes_in_mode(shot)
    if (amount := violation(shot.run)) > ADMISSIBLE:
        raise ValueError(
            f"the orbit found violates a condition of its modes by {amount:.2g}: give another guess"
        )
    first, last = (rate / guess.size for rate in end_rates(shot.run))
    matrix = shot.matrix * guess.size / guess.size[:, None]
    missed = np.abs(matrix @ first - last).max() / (np.abs(matrix) @ np.abs(first)).max()
    if not missed < INVARIANT:
        raise ValueError(
            f"the monodromy matrix misses the flow's direction by {missed:.2g}: "
            "the orbit is too unstable for single shooting; take other parameters"
        )
