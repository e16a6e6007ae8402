"""Newton's method for periodic orbits: single shooting on a Poincare section normal to the flow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.saltation import SaltationError
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.tangent_flow import end_rates, tangent_flow
from frictionlab.hybrid.trajectory import Trajectory

from .recurrence import Array
from .returns import Guess

ITERATIONS = 40
HALVINGS = 8
ROUNDING = 1e-14  # residual that cannot become smaller
RANK = 1e-11  # directions in which orbits are this near to a family are left as they are
STRETCH = 2.0  # by which factor the period may change in one iteration


class Shot(NamedTuple):
    """One period tried: the run, its fundamental matrix, and its residual, scaled by the motion's size."""

    run: Trajectory
    matrix: Array
    residual: float


def shoot(automaton: HybridAutomaton, guess: Guess, tolerance: float) -> Shot:
    """The closed orbit near a guess.

    Unknown are the state z and the period T: the flow after T is z.

    Raises
    ------
    ValueError
        Where Newton's method does not get below the tolerance.
    """
    z, period = guess.state, guess.period
    shot = _shot(automaton, z, period, guess.size)
    for _ in range(ITERATIONS):
        if shot.residual <= ROUNDING:
            break
        step = _newton(shot, period, guess.size)
        better = _damped(automaton, z, period, step, guess.size, shot.residual)
        if better is None:
            break
        z, period, shot = better
    if not shot.residual <= tolerance:
        raise ValueError(
            "no periodic orbit found near the guess: Newton's method reached a residual of "
            f"{shot.residual:.2g} of the motion's size at period {period:.6g} s, asked for is {tolerance:g}: "
            "give a guess nearer to an orbit"
        )
    return shot


def _shot(automaton: HybridAutomaton, z: Array, period: float, size: Array) -> Shot:
    run = solve(automaton, period, x0=z, progress=False)
    if not run.status.ok:
        raise SaltationError(f"a motion near the guess ends after {run.raw.t:g} s: {run.status}")
    missed = float(np.abs((run.final_state - z) / size).max())
    return Shot(run, tangent_flow(run, progress=False).matrix, missed)


def _newton(shot: Shot, period: float, size: Array) -> Array:
    """Newton's step for (z / size, T / period): the least that closes the orbit.

    At a closed orbit it is normal to the flow, so that z moves on a Poincare section.
    """
    last = end_rates(shot.run)[1] / size
    matrix = shot.matrix * size / size[:, None] - np.eye(len(size))
    gap = (shot.run.final_state - shot.run.raw.step_states[0]) / size
    return np.linalg.lstsq(np.column_stack([matrix, last * period]), -gap, rcond=RANK)[0]


def _damped(
    automaton: HybridAutomaton, z: Array, period: float, step: Array, size: Array, residual: float
) -> tuple[Array, float, Shot] | None:
    """The step, or the largest half, quarter ... of it that lessens the residual; None where none does."""
    for share in 0.5 ** np.arange(HALVINGS):
        other, longer = z + share * step[:-1] * size, period * (1.0 + share * step[-1])
        if not period / STRETCH < longer < period * STRETCH:
            continue
        try:
            shot = _shot(automaton, other, longer, size)
        except SaltationError:
            continue
        if shot.residual < residual:
            return other, longer, shot
    return None
