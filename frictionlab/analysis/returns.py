"""A state near a periodic orbit and about its period, from what one has: a state, a run, a steady state."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory

from .kinds import PERIODIC
from .recurrence import Array, sizes
from .window import SteadyState

CLOSE = 0.1  # share of the largest distance so far within which a state has returned
SMALLEST = 1e-6  # range of a coordinate, as a share of the largest of them, below which it counts as that
STILL = 1e-9  # share of a coordinate's values below which it does not move


class Guess(NamedTuple):
    """A state (n,), about a period (s), and the size (n,) of the motion in each state."""

    state: Array
    period: float
    size: Array


def groups(coordinates: int) -> tuple[slice, slice, slice]:
    """Coordinates, velocities, other states: each has a unit of its own."""
    return slice(coordinates), slice(coordinates, 2 * coordinates), slice(2 * coordinates, None)


def scales(states: Array, coordinates: int) -> Array:
    """The range of each state, by which differences are measured.

    It is at least a share of the largest in its group, as what dies away need not come back.  A group that
    does not move is measured by its values.
    """
    found, values = sizes(states), np.abs(states).max(axis=0)
    for group in groups(coordinates):
        largest = found[group].max(initial=0.0) or values[group].max(initial=0.0) or 1.0
        found[group] = np.maximum(found[group], SMALLEST * largest)
    return found


def guessed(
    automaton: HybridAutomaton, guess: Any, period: float | None, longest: float
) -> tuple[Array, float]:
    """The state (n,) and the period that a guess of :func:`frictionlab.periodic_orbit` stands for.

    Raises
    ------
    ValueError
        Where it does not come back to where it was.
    """
    if isinstance(guess, SteadyState):
        if guess.kind != PERIODIC:
            raise ValueError(
                f"guess must be periodic, the steady state is {guess.kind!r}: give another state"
            )
        return guess.trajectory.final_state, period or guess.period
    if isinstance(guess, Trajectory):
        return guess.final_state, period or first_return(guess, guess.raw.t, -1)
    state = np.asarray(guess, dtype=float)
    return state, period or first_return(solve(automaton, longest, x0=state), 0.0, 1)


def first_return(run: Trajectory, start: float, direction: int) -> float:
    """Time from `start`, an end of the run, to where the state is close to that again.

    Close is what is near as compared with the largest distance on the way there.
    """
    t = run.t[::direction]
    away = _distances(run, t, start)
    largest = np.maximum.accumulate(away, axis=0)
    still = STILL * np.abs(run.states).max()
    share = np.where(largest > still, away / np.where(largest > still, largest, 1.0), 0.0).max(axis=1)
    for i in 1 + np.flatnonzero((share[1:-1] <= share[:-2]) & (share[1:-1] < share[2:])):
        low, high = sorted((t[i - 1], t[i + 1]))
        scales = np.maximum(largest[i], still)
        found: Any = minimize_scalar(_share, args=(run, start, scales), bounds=(low, high), method="bounded")
        if found.fun < CLOSE:
            return float(abs(found.x - start))
    raise ValueError(
        f"guess must come back within {CLOSE:.0%} of the size of its motion, it does not in {run.raw.t:g} s: "
        "give a state nearer to the orbit, a larger longest=, or about its period as period="
    )


def _share(t: float, run: Trajectory, start: float, scales: Array) -> float:
    return float((_distances(run, [t], start) / scales).max())


def _distances(run: Trajectory, t: Any, start: float) -> Array:
    """Distances (N, 3) from the state at `start`: in the coordinates, in the velocities, in the rest."""
    apart = np.abs(run(np.asarray(t)) - run(start))
    parts = groups(run.automaton.coordinates)
    return np.column_stack([apart[:, part].max(axis=1, initial=0.0) for part in parts])
