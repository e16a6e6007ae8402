"""The structure's stiffness matrix and load as numbers."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.models.structure import structure_matrices
from frictionlab.models.symbols import Structure, numbers, parameter_symbols, structure, symbolic

Array = NDArray[np.float64]


def stiffness_and_load(model: Any) -> tuple[Array, Array]:
    """K (n, n) and f (n,) of K q = f + contact forces, the left-hand side of Eq. (18)."""
    stiffness, load = _compiled(structure(model))(*numbers(model))
    return np.array(stiffness, dtype=float), np.array(load, dtype=float)


@lru_cache(maxsize=256)
def _compiled(key: Structure) -> Callable[..., Any]:
    copy = symbolic(key)
    matrices = structure_matrices(copy, copy.coordinates)
    return sympy.lambdify(parameter_symbols(key), (matrices.stiffness, matrices.load), modules="math")
