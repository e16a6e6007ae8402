"""The stick-slip cycle of Hoffmann's model with loss of contact, by scipy and the equations as printed."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

K1, K2, K3, A1, A2, F, V, STATIC = 1.0, 0.5, 4 / 3, np.pi / 6, 5 * np.pi / 6, 1.0, 1.0, 1.0
K11 = K1 * np.cos(A1) ** 2 + K2 * np.cos(A2) ** 2
K12 = K1 * np.sin(A1) * np.cos(A1) + K2 * np.sin(A2) * np.cos(A2)
K22 = K1 * np.sin(A1) ** 2 + K2 * np.sin(A2) ** 2  # without the contact's spring
EXACT = {"rtol": 1e-12, "atol": 1e-13}


def _forces(z, c):
    """Along and across, on a unit mass, without the belt's."""
    x, y, u, w = z
    return -c * u - K11 * x - K12 * y, F - c * w - K12 * x - K22 * y


def _stay(rates, z, *ends):
    """How long a mode lasts, its last state, and which of its ends, falling through zero, has come."""
    for end in ends:
        end.terminal, end.direction = True, -1
    run = solve_ivp(rates, (0.0, 50.0), z, method="DOP853", events=ends, **EXACT)
    return run.t[-1], run.y[:, -1], next(i for i, t in enumerate(run.t_events) if len(t))


def _sticks(z, c):
    def rates(_, z):
        return V, z[3], 0.0, _forces((z[0], z[1], V, z[3]), c)[1] - K3 * z[1]

    return _stay(rates, z, lambda _, z: STATIC * K3 * z[1] + _forces((z[0], z[1], V, z[3]), c)[0])


def _slips(z, c, kinetic):
    def rates(_, z):
        along, across = _forces(z, c)
        return z[2], z[3], along + kinetic * K3 * z[1], across - K3 * z[1]

    return _stay(rates, z, lambda _, z: z[1], lambda _, z: V - z[2])


def _flies(z, c):
    def rates(_, z):
        return z[2], z[3], *_forces(z, c)

    return _stay(rates, z, lambda _, z: -z[1])


def by_differences(z, c, kinetic, h=1e-4):
    """Derivative (3, 3) of the map from onset to onset."""
    ends = [(cycle(z + d, c, kinetic)[0], cycle(z - d, c, kinetic)[0]) for d in h * np.eye(3)]
    return np.column_stack([(after - before) / (2 * h) for after, before in ends])


def cycle(z, c, kinetic):
    """From an onset of stick (x, y, y') through slip, flight and slip to the next: its state, four times."""
    t1, z, _ = _sticks([z[0], z[1], V, z[2]], c)
    t2, z, lost = _slips(z, c, kinetic)
    assert lost == 0
    z[1] = -1e-300  # just beyond zero, so that an end that falls through it does not come at once
    t3, z, _ = _flies(z, c)
    z[1] = 1e-300
    t4, z, landed = _slips(z, c, kinetic)
    assert landed == 1
    return z[[0, 1, 3]], (t1, t2, t3, t4)
