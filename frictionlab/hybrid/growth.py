"""Growth of tangent vectors along a run, kept apart by orthonormalising them after every step."""

from __future__ import annotations

import math

import numpy as np

from frictionlab.hybrid.compiled import kernel
from frictionlab.hybrid.jets import copy
from frictionlab.hybrid.tangent_flow import carry_rows, pieces, saltation_at
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational import SHORTEST, carry

LOST = 1e-12  # share of a vector's length that is left by rounding alone where an event takes it all


@kernel
def inner(a, b, size):
    """Inner product of two vectors, each component measured by its `size`."""
    total = 0.0
    for i in range(a.shape[0]):
        total += (a[i] / size[i]) * (b[i] / size[i])
    return total


@kernel
def orthonormalise(frame, size, growth):
    """Gram-Schmidt on the rows of `frame`; adds the logarithms of their lengths to `growth`."""
    for d in range(frame.shape[0]):
        for e in range(d):
            share = inner(frame[d], frame[e], size)
            for i in range(frame.shape[1]):
                frame[d, i] -= share * frame[e, i]
        length = math.sqrt(inner(frame[d], frame[d], size))
        growth[d] += math.log(length)
        for i in range(frame.shape[1]):
            frame[d, i] /= length


@kernel
def grow_steps(code, numbers, order, tol, times, modes, states, z, frame, J, T, size, growth):
    """Carry the frame over the steps of a run; returns the number of the step that failed, or -1."""
    for i in range(modes.shape[0]):
        copy(states[i], z)
        left = times[i, 1]
        while left > 0.0:
            step = carry(code, numbers, modes[i], order, tol, left, z, frame, J, T)
            if not (step == left or step > SHORTEST * times[i, 1]):
                return i
            orthonormalise(frame, size, growth)
            left -= step
    return -1


def growth_along(run: Trajectory, rows: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows (m, n) carried to the end of a run, orthonormal in units of `size` (n,), and their growth.

    The growth (m,) is the logarithm of a factor: -inf where an event takes a direction away.
    """
    growth, rows = np.zeros(len(rows)), rows.copy()
    for part, event in pieces(run):
        carry_rows(grow_steps, run, part, rows, size, growth)
        if event is not None:
            rows = _through(rows @ saltation_at(run, event).T, size, growth)
    return rows, growth


def _through(rows: np.ndarray, size: np.ndarray, growth: np.ndarray) -> np.ndarray:
    """Orthonormalise after an event; what it takes away is replaced by any vector, as the log of 0 tells."""
    columns = (rows / size).T
    frame, upper = np.linalg.qr(columns)
    kept, lengths = np.abs(np.diag(upper)), np.linalg.norm(columns, axis=0)
    with np.errstate(divide="ignore"):
        growth += np.log(np.where(kept > LOST * lengths, kept, 0.0))
    return np.ascontiguousarray(frame.T * size)
