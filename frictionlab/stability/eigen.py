"""Eigenvalues of the system linearised about steady sliding, Eq. (19)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.models.assembly import assemble
from frictionlab.models.symbols import Structure, numbers, parameter_symbols, structure

from .equilibria import Equilibrium, equilibrium

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Eigenvalues:
    """Eigenvalues and modes of the linearised system.

    Parameters
    ----------
    values : complex array (2n,)
        1/s, by ascending magnitude of the imaginary part; conjugate pairs are adjacent.
    vectors : complex array (2n, 2n)
        Their vectors as columns: coordinates, then velocities.
    equilibrium : Equilibrium
        Where the system was linearised.
    """

    values: NDArray[np.complex128]
    vectors: NDArray[np.complex128]
    equilibrium: Equilibrium

    @property
    def frequencies(self) -> Array:
        """|Im|/(2 pi), Hz, (2n,)."""
        return np.abs(self.values.imag) / (2 * np.pi)

    @property
    def growth_rates(self) -> Array:
        """Real parts, 1/s, (2n,): positive ones grow."""
        return self.values.real

    @property
    def stable(self) -> bool:
        """Whether every growth rate is negative."""
        return bool((self.growth_rates < 0).all())


def eigenvalues(model: Any) -> Eigenvalues:
    """Eigenvalues at the sliding equilibrium, Eq. (19), from sympy's Jacobian of the sliding mode.

    Raises
    ------
    ValueError
        If there is no sliding equilibrium with F_N > 0, or the belt rests.
    """
    point = equilibrium(model)
    pairs: Any = np.linalg.eig(jacobian(model, point.q))
    values, vectors = pairs.eigenvalues.astype(complex), pairs.eigenvectors.astype(complex)
    # The two of a conjugate pair agree exactly in |Im| and Re.
    order = np.lexsort((values.imag, values.real, np.abs(values.imag)))
    return Eigenvalues(values[order], vectors[:, order], point)


def jacobian(model: Any, q: Array) -> Array:
    """The state matrix (2n, 2n) of steady sliding at coordinates `q` and zero velocities.

    Raises
    ------
    ValueError
        If the belt rests and the model has stick: friction has no derivative there.
    """
    n, mode = len(q), sliding_mode(model)
    rows = _compiled(structure(model), mode)(*map(float, q), *([0.0] * n), *numbers(model))
    return np.vstack([np.eye(n, 2 * n, n), np.array(rows, dtype=float)])


def sliding_mode(model: Any) -> str:
    """Name of the mode in which the model slides steadily."""
    modes = model.interface.modes
    if "slip" in modes:
        return "slip"
    if model.v == 0:
        raise ValueError("v must not be 0 for steady sliding, got 0.0: give the belt a speed")
    return "slip+" if model.v > 0 else "slip-"


@lru_cache(maxsize=256)
def _compiled(key: Structure, mode: str) -> Callable[..., Any]:
    """The lower half of the state matrix as a function of state and parameters."""
    derived = assemble(key)
    flow = next(m.flow for m in derived.modes if m.name == mode)
    arguments = parameter_symbols(key)
    rows = [[sympy.diff(row, x) for x in derived.states] for row in flow[derived.coordinates :]]
    return sympy.lambdify([*derived.states, *arguments], rows, modules="numpy", cse=True)
