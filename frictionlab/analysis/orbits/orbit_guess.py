"""The initial guess of a periodic orbit, state and period, from a state, a run or a steady state."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from frictionlab.analysis.motion_scales import AT_REST_RTOL, Array, state_groups
from frictionlab.analysis.steady_state.motion_kind import MotionKind
from frictionlab.analysis.steady_state.result import SteadyState
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory

RETURN_RTOL = 0.1  # share of the largest distance so far within which a state has returned


class OrbitGuess(NamedTuple):
    """A state (n,) near the orbit, an approximate period (s), and the size (n,) of the motion in each
    state."""

    state: Array
    period: float
    size: Array


def state_and_period(
    automaton: HybridAutomaton, guess: Any, period: float | None, t_max: float
) -> tuple[Array, float]:
    """State (n,) and period of the guess that :func:`frictionlab.periodic_orbit` was given.

    Raises
    ------
    ValueError
        Where the motion does not return to the state.
    """
    if isinstance(guess, SteadyState):
        if guess.kind != MotionKind.PERIODIC:
            raise ValueError(
                f"guess must be periodic, the steady state is {guess.kind!r}: give another state"
            )
        return guess.trajectory.final_state, period or guess.period
    if isinstance(guess, Trajectory):
        return guess.final_state, period or first_return(guess, guess.raw.t, -1)
    state = np.asarray(guess, dtype=float)
    return state, period or first_return(solve(automaton, t_max, x0=state), 0.0, 1)


def first_return(run: Trajectory, start: float, direction: int) -> float:
    """Time from `start`, an end of the run, to where the state is close to that again.

    Close means a small share of the largest distance reached before.
    """
    t = run.t[::direction]
    away = _distances(run, t, start)
    largest = np.maximum.accumulate(away, axis=0)
    still = AT_REST_RTOL * np.abs(run.states).max()
    share = np.where(largest > still, away / np.where(largest > still, largest, 1.0), 0.0).max(axis=1)
    for i in 1 + np.flatnonzero((share[1:-1] <= share[:-2]) & (share[1:-1] < share[2:])):
        low, high = sorted((t[i - 1], t[i + 1]))
        scales = np.maximum(largest[i], still)
        found: Any = minimize_scalar(
            _relative_distance, args=(run, start, scales), bounds=(low, high), method="bounded"
        )
        if found.fun < RETURN_RTOL:
            return float(abs(found.x - start))
    raise ValueError(
        f"guess must come back within {RETURN_RTOL:.0%} of the size of its motion, it does not in "
        f"{run.raw.t:g} s: give a state nearer to the orbit, a larger t_max=, or about its period as period="
    )


def _relative_distance(t: float, run: Trajectory, start: float, scales: Array) -> float:
    return float((_distances(run, [t], start) / scales).max())


def _distances(run: Trajectory, t: Any, start: float) -> Array:
    """Distances (N, 3) from the state at `start`: in the coordinates, in the velocities, in the rest."""
    apart = np.abs(run(np.asarray(t)) - run(start))
    parts = state_groups(run.automaton.coordinates)
    return np.column_stack([apart[:, part].max(axis=1, initial=0.0) for part in parts])
