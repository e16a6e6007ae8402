"""Energies of slider and belt: everything the structure's matrices come from.

`p` holds the parameters as attributes, `q` and `v` the coordinates x1, y1, x2, y2, phi and their rates.
A model without the belt's rotation has phi = 0.
"""

from __future__ import annotations

from typing import Any


def kinetic_energy(p: Any, v: Any) -> Any:
    """T (J): the slider M moves in the plane, the belt m too, and it rotates with inertia J."""
    return (p.M * (v.x1**2 + v.y1**2) + p.m * (v.x2**2 + v.y2**2) + p.J * v.phi**2) / 2


def potential_energy(p: Any, q: Any) -> Any:
    """V (J): the springs, and the preload F that presses the slider down.

    k3 lies at 45 degrees and stretches by (x1 - y1)/sqrt(2); k5 and k6 hold the belt at its two wheels.
    """
    slider = p.k1 * q.x1**2 + p.k3 * (q.x1 - q.y1) ** 2 / 2
    belt = p.k4 * q.x2**2 + p.k5 * (q.y2 + p.l1 * q.phi) ** 2 + p.k6 * (q.y2 - p.l2 * q.phi) ** 2
    return (slider + belt) / 2 + p.F * q.y1


def dissipation(p: Any, v: Any) -> Any:
    """Rayleigh's dissipation function D (W): half the power that the dampers take."""
    slider = p.c1 * v.x1**2 + p.c2 * v.y1**2
    belt = p.c4 * v.x2**2 + p.c5 * (v.y2 + p.l1 * v.phi) ** 2 + p.c6 * (v.y2 - p.l2 * v.phi) ** 2
    return (slider + belt) / 2
