"""The static equations of sliding, K q = f + W_N F_N + W_T F_T, solved for q at a given gap.

The gap determines F_N, that determines F_T, and both determine q.  What remains is one scalar equation:
the gap of that q is the given one.  Numbers and polynomials of the gap go through the same lines.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .laws import contact_force, sliding_force
from .matrices import stiffness_and_load

Array = NDArray[np.float64]
SINGULAR = 1e-13


@dataclass(frozen=True, eq=False)
class Statics:
    """Static equations of a model: its geometry, the belt's speed, the two laws, K and f.

    `held` are the coordinates that the structure holds; `hung` is the one, if any, that only the contact
    holds: the slider's height where k3 = 0.
    """

    geometry: Any
    speed: float
    force: Callable[[Any], Any]
    kinetic: Callable[[Any, float], Any]
    stiffness: Array
    load: Array
    flexibility: Array
    held: tuple[int, ...]
    hung: int | None

    def friction(self, normal_force: Any) -> Any:
        """F_T (N) while sliding at the belt's speed, Eq. (3)."""
        return float(np.sign(self.speed)) * self.kinetic(normal_force, abs(self.speed))

    def coordinates(self, gap: Any) -> list[Any]:
        """q at a gap, from all equations but the one that :meth:`excess` leaves over."""
        normal_force = self.force(gap)
        friction = self.friction(normal_force)
        # The lever in W_N depends on coordinates that its moment does not move: two passes are exact.
        q: list[Any] = [0.0] * len(self.load)
        for _ in range(2):
            q = self._deflections(
                self._loads(self.geometry.normal(*q), normal_force, self.geometry.tangent(*q), friction)
            )
        if self.hung is not None:
            # The gap is what the slider's height takes from it: slope -1.
            q[self.hung] = self.geometry.gap(*q) - gap
        return q

    def excess(self, gap: Any) -> Any:
        """The scalar equation: zero at the gap of an equilibrium."""
        q = self.coordinates(gap)
        if self.hung is None:
            return self.geometry.gap(*q) - gap
        return self.load[self.hung] + self.geometry.normal(*q)[self.hung] * self.force(gap)

    def unloaded_gap(self) -> float:
        """The gap (m) that the load would make if there were no contact forces."""
        q = self._deflections([float(f) for f in self.load])
        return float(self.geometry.gap(*q))

    def residual(self, q: Array) -> float:
        """Largest force left over at `q`, relative to the largest in the equations."""
        normal_force = float(self.force(self.geometry.gap(*q)))
        contact = self._loads(
            self.geometry.normal(*q), normal_force, self.geometry.tangent(*q), self.friction(normal_force)
        )
        elastic = self.stiffness @ q
        largest = max(np.abs(elastic).max(), np.abs(self.load).max(), abs(normal_force))
        return float(np.abs(np.array(contact, dtype=float) - elastic).max() / largest) if largest else 0.0

    def _loads(
        self, normal: Sequence[Any], normal_force: Any, tangent: Sequence[Any], friction: Any
    ) -> list[Any]:
        rows = zip(self.load, normal, tangent, strict=True)
        return [float(f) + n * normal_force + t * friction for f, n, t in rows]

    def _deflections(self, loads: list[Any]) -> list[Any]:
        q: list[Any] = [0.0] * len(loads)
        for row, i in zip(self.flexibility, self.held, strict=True):
            q[i] = sum(float(a) * loads[j] for a, j in zip(row, self.held, strict=True) if a != 0)
        return q


def statics(model: Any) -> Statics:
    """The static equations of a model.

    Raises
    ------
    ValueError
        If coordinates other than the slider's height are not held by the structure.
    """
    stiffness, load = stiffness_and_load(model)
    hung = _hung(stiffness, model.coordinates)
    held = tuple(i for i in range(len(load)) if i != hung)
    block = stiffness[np.ix_(held, held)]
    _refuse_singular(block, [model.coordinates[i] for i in held])
    laws = contact_force(model), sliding_force(model)
    return Statics(
        model.geometry,
        model.v,
        *laws,
        stiffness,
        load,
        np.asarray(np.linalg.inv(block), dtype=np.float64),
        held,
        hung,
    )


def _hung(stiffness: Array, coordinates: Sequence[str]) -> int | None:
    height = coordinates.index("y1")
    return None if stiffness[height].any() else height


def _refuse_singular(stiffness: Array, names: Sequence[str]) -> None:
    size = np.sqrt(np.diag(stiffness))
    size[size == 0] = 1.0
    values, vectors = np.linalg.eigh(stiffness / np.outer(size, size))
    if values[0] > SINGULAR:
        return
    loose = [name for name, part in zip(names, vectors[:, 0], strict=True) if abs(part) > 0.1]
    raise ValueError(
        f"no static equilibrium can be computed: the springs do not hold {', '.join(loose)} "
        "(singular stiffness matrix); give the springs there a positive stiffness"
    )
