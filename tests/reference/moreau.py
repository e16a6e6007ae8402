"""Moreau's time-stepping scheme for contacts, rigid or rubbing, of a system with constant M and directions.

The impulses of all contacts in a step solve Newton's and Coulomb's laws together, by projection, contact by
contact.  No event is located, so that the error falls with the step; nothing is shared with the package.
Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, Springer 1988.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RigidSystem:
    """M q'' = forces(q) + W_N lambda_N + W_T lambda_T with gaps(q) >= 0; rows of W are contacts."""

    masses: np.ndarray
    forces: Callable[[np.ndarray], np.ndarray]
    gaps: Callable[[np.ndarray], np.ndarray]
    normals: np.ndarray
    tangents: np.ndarray
    restitution: np.ndarray
    friction: float


def time_steps(system: RigidSystem, q: np.ndarray, v: np.ndarray, t_end: float, h: float) -> np.ndarray:
    """Rows t, q, v, one for each step."""
    inverse, rows = np.linalg.inv(system.masses), [np.concatenate([[0.0], q, v])]
    for k in range(round(t_end / h)):
        middle = q + 0.5 * h * v
        closed = np.flatnonzero(system.gaps(middle) <= 0.0)
        free = v + h * inverse @ system.forces(middle)
        v = free if not len(closed) else _with_impulses(system, inverse, closed, free, v)
        q = middle + 0.5 * h * v
        rows.append(np.concatenate([[(k + 1) * h], q, v]))
    return np.array(rows)


def _with_impulses(system, inverse, closed, free, before):
    """Velocities after the impulses that bring all closed contacts to their laws."""
    new, normal, tangent = free.copy(), np.zeros(len(closed)), np.zeros(len(closed))
    for _ in range(500):
        last = new.copy()
        for j, i in enumerate(closed):
            w, along = system.normals[i], system.tangents[i]
            missed = w @ new + system.restitution[i] * min(w @ before, 0.0)
            pushed = max(normal[j] - missed / (w @ inverse @ w), 0.0)
            new += inverse @ w * (pushed - normal[j])
            normal[j] = pushed
            limit = system.friction * normal[j]
            rubbed = np.clip(tangent[j] - (along @ new) / (along @ inverse @ along), -limit, limit)
            new += inverse @ along * (rubbed - tangent[j])
            tangent[j] = rubbed
        if np.abs(new - last).max() < 1e-13 * np.abs(new).max():
            break
    return new


@dataclass(frozen=True)
class RubbingSystem:
    """M q'' + C q' + K q = T^T F with |F| <= limits, and F along v - T q' in slip; rows of T are contacts."""

    masses: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    tangents: np.ndarray
    limits: np.ndarray
    v: float


def rubbing_steps(system: RubbingSystem, q: np.ndarray, v: np.ndarray, t_end: float, h: float) -> np.ndarray:
    """The state at the end; the midpoint rule for what is smooth."""
    M, C, K, T = system.masses, system.damping, system.stiffness, system.tangents
    inverse = np.linalg.inv(M + h / 2 * C + h * h / 4 * K)
    compliance, limit, impulse = T @ inverse @ T.T, h * system.limits, np.zeros(len(T))
    for _ in range(round(t_end / h)):
        free = v - h * inverse @ (K @ (q + h / 2 * v) + C @ v)
        wanted = system.v - T @ free
        for _ in range(2000):
            last = impulse.copy()
            for i in range(len(T)):
                missed = wanted[i] - compliance[i] @ impulse
                impulse[i] = np.clip(impulse[i] + missed / compliance[i, i], -limit[i], limit[i])
            if np.abs(impulse - last).max() < 1e-13 * limit.max():
                break
        new = free + inverse @ T.T @ impulse
        q, v = q + h / 2 * (v + new), new
    return np.concatenate([q, v])
