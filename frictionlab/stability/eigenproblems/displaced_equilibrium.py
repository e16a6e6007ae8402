"""A state near an equilibrium, from which the least stable mode shows whether it grows: ``x0="near"``.

Its coordinates are one percent off.  That may leave a growing mode at rest, as in a plane of symmetry, or all
coordinates may be zero.  Then the least stable mode itself is displaced, by one percent of its own size.
This is the size s at which the linear motion x_e + s Re(exp(i a) r), over all angles a, first meets an event
or is no longer linear.  It counts as linear while the part of the rates that is not, along the left vector l,
is less than half of |lambda| s.  So no length enters that depends on a unit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.models.model import ModelOrAutomaton
from frictionlab.stability.eigenproblems.eigenvalues import jacobian
from frictionlab.stability.equilibrium_points.equilibria import Equilibrium, equilibrium, equilibrium_problem
from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.state_matrices import (
    Eigenpair,
    eigenpair,
    eigenvalues_of_matrices,
    is_neutral,
)

Array = NDArray[np.float64]
DISPLACEMENT = 0.01  # share by which coordinates, or the mode, are displaced
NEAR_EQUILIBRIUM_FACTOR = 1.01  # of coordinates; 1 + DISPLACEMENT rounds to it
SEEN_SHARE = 1e-9  # of the terms of a sum that cancel: what is smaller is rounding
NEGLIGIBLE_SHARE = 1e-6  # of the mode's displacement: one that is so much smaller leaves the mode at rest
NONLINEAR_SHARE = 0.5  # of the linear rates: with more the motion is no longer linear
SIZES = np.geomspace(1e-40, 1e40, 321)  # of the mode, in units of its vector: four in a decade
ANGLES = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)


def displaced_equilibrium(model: ModelOrAutomaton) -> Array:
    """The state (m,) near the default equilibrium of a model or an automaton.

    Raises
    ------
    ValueError
        If there is no equilibrium, or it is at the origin and cannot be linearised.
    """
    point, problem = equilibrium(model), equilibrium_problem(model)
    state, n = point.state.copy(), len(point.q)
    state[:n] *= NEAR_EQUILIBRIUM_FACTOR
    state = problem.completed(state)
    try:
        matrix = jacobian(model, point.state)
    except ValueError:
        if point.q.any():
            return state
        raise
    mode = _least_stable_mode(problem, matrix)
    if mode.value.real <= 0 and point.q.any():
        return state
    size = _linear_size(problem, point, matrix, mode)
    if _is_excited(mode, state - point.state, size):
        return state
    right = mode.right
    sizes = np.abs(right[:n]) if right[:n].any() else np.abs(right)
    # the last of those that rounding alone makes differ, as in a mode against a symmetry
    largest = right[np.flatnonzero(sizes >= (1.0 - SEEN_SHARE) * sizes.max())[-1]]
    length = DISPLACEMENT * (1.0 if np.isinf(size) else size)
    return problem.completed(state + length * (right * abs(largest) / largest).real)


def _least_stable_mode(problem: EquilibriumProblem, whole: Array) -> Eigenpair:
    """The mode that grows fastest; if none grows or decays, the one of the highest frequency."""
    matrix = problem.without_following(whole)
    values: Any = eigenvalues_of_matrices(matrix[None])[0]
    values.real[is_neutral(matrix, values)] = 0.0
    value = complex(values[np.lexsort((np.abs(values.imag), values.real))[-1]])
    mode = eigenpair(matrix, value)
    left = problem.with_following(mode.left[:, None])[:, 0]
    right = problem.with_following(mode.right[:, None] / np.abs(mode.right).max(), whole)[:, 0]
    return Eigenpair(value, left, right, complex(left @ right))


def _is_excited(mode: Eigenpair, shift: Array, size: float) -> bool:
    """Whether a displacement (m,) has a part along the mode that counts beside the mode's `size`."""
    left = mode.left
    part = abs(left @ shift)
    if part <= SEEN_SHARE * float(np.abs(left) @ np.abs(shift)):
        return False
    return np.isinf(size) or part > NEGLIGIBLE_SHARE * DISPLACEMENT * size * abs(mode.product)


def _linear_size(problem: EquilibriumProblem, point: Equilibrium, matrix: Array, mode: Eigenpair) -> float:
    """The size (in units of the mode's vector) up to which its motion is linear and meets no event.

    It is infinite if the motion is linear at all sizes.  Rounding makes very small motions look as if they
    were not linear.  So the end of the widest range of sizes with a linear motion is taken.
    """
    way = (np.exp(1j * ANGLES)[:, None] * mode.right).real
    way = way[np.abs(way).max(axis=1) > NONLINEAR_SHARE]  # those of a real mode may vanish
    displacements = SIZES[:, None, None] * way  # (sizes, angles, m)
    at = (point.state + displacements).reshape(-1, len(point.state)).T
    with np.errstate(all="ignore"):
        rates, margin = (
            np.broadcast_to(f(at, problem.values), (*lead, at.shape[1]))
            for f, lead in ((problem.flow.rhs, (len(at),)), (problem.flow.margin, ()))
        )
        bent = np.abs(mode.left @ (rates - matrix @ displacements.reshape(at.T.shape).T))
        usual = abs(mode.value * mode.product) * np.repeat(SIZES, len(way))
        linear = ((bent < NONLINEAR_SHARE * usual) & (margin > 0)).reshape(len(SIZES), -1).all(axis=1)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], linear, [False]]).astype(int)))
    if not len(ends):
        return np.inf
    starts, stops = ends[::2], ends[1::2]
    last = int(stops[np.argmax(stops - starts)])
    return float(SIZES[last]) if last < len(SIZES) else np.inf
