"""The mechanics of a model as expressions: gap, contact forces, and the rest of the forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from .structure import structure_matrices


@dataclass(frozen=True, eq=False)
class Scene:
    """What every mode is written with.  `q` and `v` are symbols, or functions of time.

    Nothing is expanded: equal subexpressions (the gap above all) stay equal, so that they cost once.
    """

    model: Any
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    mass: tuple[Any, ...]
    load: tuple[Any, ...]
    internal: tuple[Any, ...]
    gap: Any
    normal: tuple[Any, ...]
    tangent: tuple[Any, ...]
    gap_rate: Any
    material_rate: Any
    relative_velocity: Any
    normal_force: Any

    @property
    def compliance(self) -> Any:
        """W_N^T M^-1 W_N (1/kg), the denominator of Eq. (14)."""
        return sum(w**2 / m for w, m in zip(self.normal, self.mass, strict=True))

    def forces(self, normal_force: Any) -> list[Any]:
        """Right-hand sides of Eq. (1) but for the inertia and the friction force."""
        parts = zip(self.load, self.internal, self.normal, strict=True)
        return [f - r + w * normal_force for f, r, w in parts]


def scene(model: Any, q: Sequence[Any], v: Sequence[Any]) -> Scene:
    """The mechanics of a symbolic copy of a model, at coordinates `q` and velocities `v`."""
    matrices = structure_matrices(model, model.coordinates)
    gap, normal, tangent = model.geometry.gap(*q), model.geometry.normal(*q), model.geometry.tangent(*q)
    return Scene(
        model=model,
        q=tuple(q),
        v=tuple(v),
        mass=matrices.mass,
        load=matrices.load,
        internal=tuple(
            _dot(c, v) + _dot(k, q) for c, k in zip(matrices.damping, matrices.stiffness, strict=True)
        ),
        gap=gap,
        normal=normal,
        tangent=tangent,
        gap_rate=sum(sympy.diff(gap, x) * rate for x, rate in zip(q, v, strict=True)),
        material_rate=-_dot(normal, v),
        relative_velocity=model.v - _dot(tangent, v),
        normal_force=model.contact.force(gap),
    )


def _dot(row: Sequence[Any], values: Sequence[Any]) -> Any:
    return sum(a * b for a, b in zip(row, values, strict=True))
