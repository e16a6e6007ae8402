"""Motions without kinetic energy, for which a singular mass matrix gives no accelerations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEAST_SHARE = 1e-13  # of the masses of its coordinates; the energy of a motion below it is a rounding error
SEED = 37  # of the places at which masses that depend on place are looked at


def motion_without_energy(mass: NDArray[np.float64], least: float = -np.inf) -> list[int]:
    """The coordinates of a motion whose energy, as a share of that of its parts, is zero to rounding.

    From `least` on; so a motion of negative energy counts by default.
    """
    size = np.sqrt(np.abs(np.diag(mass)))
    if not size.all():
        return [int(i) for i in np.flatnonzero(size == 0.0)]
    shares, motions = np.linalg.eigh(mass / size[:, None] / size)
    if not least <= shares[0] <= LEAST_SHARE * len(mass):
        return []
    part = np.abs(motions[:, 0])
    return [int(i) for i in np.flatnonzero(part > part.max() * 1e-6)]
