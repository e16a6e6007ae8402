"""The structure's matrices M, C, K and its constant load f, by differentiating its energies."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import sympy

from .energies import dissipation, kinetic_energy, potential_energy
from .symbols import symbol

ALL = ("x1", "y1", "x2", "y2", "phi")


@dataclass(frozen=True, eq=False)
class StructureMatrices:
    """M q'' + C q' + K q = f + contact forces, as nested tuples of expressions in the parameters."""

    mass: tuple[Any, ...]
    damping: tuple[tuple[Any, ...], ...]
    stiffness: tuple[tuple[Any, ...], ...]
    load: tuple[Any, ...]


def structure_matrices(p: Any, coordinates: tuple[str, ...]) -> StructureMatrices:
    """Matrices of the structure without its contact, Eqs. (1) and (18).

    Parameters
    ----------
    p : object
        The parameters (symbols or numbers) as attributes.
    coordinates : tuple of str
        Those that the model keeps; the others are zero.
    """
    q = [symbol(name) for name in coordinates]
    at = SimpleNamespace(**{name: symbol(name) if name in coordinates else 0 for name in ALL})
    elastic = _gradient(potential_energy(p, at), q)
    return StructureMatrices(
        mass=_diagonal(_jacobian(_gradient(kinetic_energy(p, at), q), q)),
        damping=_jacobian(_gradient(dissipation(p, at), q), q),
        stiffness=_jacobian(elastic, q),
        load=tuple(-row.subs(dict.fromkeys(q, 0)) for row in elastic),
    )


def _gradient(energy: Any, q: list[Any]) -> list[Any]:
    return [sympy.diff(energy, x) for x in q]


def _jacobian(gradient: list[Any], q: list[Any]) -> tuple[tuple[Any, ...], ...]:
    # Second derivatives of a quadratic form: symmetric, so half of them do.
    upper = {(i, j): sympy.diff(gradient[i], q[j]) for j in range(len(q)) for i in range(j + 1)}
    return tuple(tuple(upper[min(i, j), max(i, j)] for j in range(len(q))) for i in range(len(q)))


def _diagonal(matrix: tuple[tuple[Any, ...], ...]) -> tuple[Any, ...]:
    # The assembly divides each equation by its own mass, and stick solves two of them by hand.
    if any(entry != 0 for i, row in enumerate(matrix) for j, entry in enumerate(row) if i != j):
        raise NotImplementedError(
            "the kinetic energy couples coordinates; the assembly needs a diagonal mass matrix"
        )
    return tuple(row[i] for i, row in enumerate(matrix))
