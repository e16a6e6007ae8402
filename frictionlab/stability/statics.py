"""The static equations of sliding, K q = f + W_N F_N + W_T F_T, solved for q at a given gap by sympy.

The gap determines F_N, that determines F_T, and both determine q.  What remains is one scalar equation:
the gap of that q is the given one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.models.structure import structure_matrices
from frictionlab.models.symbols import Structure, parameter_symbols, symbol, symbolic

Array = NDArray[np.float64]
GAP = sympy.Symbol("compression", real=True)
SINGULAR = 1e-13


class Statics(NamedTuple):
    """Functions of the gap and then of all parameters: numbers, arrays or, for some, polynomials.

    Parameters
    ----------
    coordinates : callable
        q, from all equations but the one that `excess` leaves over; a list (n,).
    excess, slope : callable
        The scalar equation, zero at the gap of an equilibrium, and its derivative.
    forces : callable
        F_N and F_T, N.
    residual : callable of (*q, *parameters)
        The static equations (n,), and the terms in them that tell their size.
    """

    coordinates: Callable[..., Any]
    excess: Callable[..., Any]
    slope: Callable[..., Any]
    forces: Callable[..., Any]
    residual: Callable[..., Any]


@cache
def derived(key: Structure, hung: bool = False) -> Statics:
    """The statics of a structure.

    `hung`: only the contact holds the slider's height, since k3 = 0.
    """
    copy, p = symbolic(key), parameter_symbols(key)
    normal, friction = _forces(copy, GAP)
    matrices = structure_matrices(copy, copy.coordinates)
    q = _deflections(copy, matrices, hung, normal, friction)
    if hung:
        # The gap is what the slider's height takes from it: slope -1.
        height = copy.coordinates.index("y1")
        q[height] = copy.geometry.gap(*q) - GAP
        excess = _loads(copy, matrices, q, normal, friction)[height]
    else:
        excess = copy.geometry.gap(*q) - GAP
    free = [symbol(name) for name in copy.coordinates]
    arguments = [GAP, *p]
    return Statics(
        _compiled(arguments, q),
        _compiled(arguments, excess),
        _compiled(arguments, sympy.diff(excess, GAP)),
        _compiled(arguments, [normal, friction]),
        _compiled([*free, *p], _balance(copy, matrices, free)),
    )


def _forces(copy: Any, gap: Any) -> tuple[Any, Any]:
    """F_N, Eq. (2), and F_T while sliding at the belt's speed, Eq. (3)."""
    normal = copy.contact.force(gap)
    return normal, sympy.sign(copy.v) * copy.friction.kinetic(normal, abs(copy.v))


def _deflections(copy: Any, matrices: Any, hung: bool, normal: Any, friction: Any) -> list[Any]:
    free, q = [symbol(name) for name in copy.coordinates], [sympy.S.Zero] * len(copy.coordinates)
    stiffness = sympy.Matrix(matrices.stiffness)
    lever = sympy.Matrix(copy.geometry.normal(*free)).jacobian(free)
    skipped = copy.coordinates.index("y1") if hung else None
    flexibility, passes = _flexibility(stiffness, skipped), 2
    # With the paper's W_N the lever depends on coordinates that its moment does not move: two passes do.
    if not (flexibility * lever * flexibility * lever).is_zero_matrix:
        flexibility, passes = _flexibility(stiffness - normal * lever, skipped), 1
    for _ in range(passes):
        q = list(flexibility * sympy.Matrix(_loads(copy, matrices, q, normal, friction)))
    return q


def _loads(copy: Any, matrices: Any, q: Sequence[Any], normal: Any, friction: Any) -> list[Any]:
    rows = zip(matrices.load, copy.geometry.normal(*q), copy.geometry.tangent(*q), strict=True)
    return [f + w * normal + t * friction for f, w, t in rows]


def _flexibility(stiffness: Any, hung: int | None) -> Any:
    """Inverse of K, block by block, with zeros for the coordinate that the contact alone holds."""
    inverse = sympy.zeros(*stiffness.shape)
    for block in sympy.SparseMatrix(stiffness).connected_components():
        held = [i for i in block if i != hung]
        if held:
            part = stiffness.extract(held, held)
            inverse_part = part.adjugate() / sympy.factor(part.det())
            for row, i in enumerate(held):
                for column, j in enumerate(held):
                    inverse[i, j] = inverse_part[row, column]
    return inverse


def _balance(copy: Any, matrices: Any, q: Sequence[Any]) -> list[Any]:
    elastic = list(sympy.Matrix(matrices.stiffness) * sympy.Matrix(q))
    normal, friction = _forces(copy, copy.geometry.gap(*q))
    rows = zip(_loads(copy, matrices, q, normal, friction), elastic, strict=True)
    return [*(load - held for load, held in rows), *elastic, *matrices.load, normal]


def _compiled(arguments: list[Any], expression: Any) -> Callable[..., Any]:
    return sympy.lambdify(arguments, expression, modules="numpy", cse=True)


def residual(statics: Statics, q: Sequence[Any], values: Sequence[Any]) -> Array:
    """Largest force left over at `q`, relative to the largest in the equations."""
    n = len(q)
    rows = np.abs(np.stack(np.broadcast_arrays(*statics.residual(*q, *values), np.zeros(np.shape(q[0])))))
    largest = rows[n:].max(axis=0)
    return rows[:n].max(axis=0) / np.where(largest > 0, largest, 1.0)


def statics_of(key: Structure, values: Sequence[float], coordinates: Sequence[str]) -> Statics:
    """The statics that fit the values of the parameters.

    Raises
    ------
    ValueError
        If coordinates other than the slider's height are not held by the structure.
    """
    stiffness = _stiffness(key, values)
    hung = not stiffness[:, coordinates.index("y1")].any()
    held = _held(coordinates, hung)
    _refuse_singular(stiffness[np.ix_(held, held)], [coordinates[i] for i in held])
    return derived(key, hung)


def each_statics(
    key: Structure, values: Sequence[Any], coordinates: Sequence[str], count: int
) -> Iterator[tuple[Statics, Any]]:
    """The statics that fit, and which of `count` values of the parameters; none fit where one is not held.

    Raises
    ------
    ValueError
        If a coordinate is not held whatever the values.
    """
    stiffness = _stiffness(key, values)
    if stiffness.ndim == 2:
        yield statics_of(key, values, coordinates), np.ones(count, dtype=bool)
        return
    without = ~stiffness[:, :, coordinates.index("y1")].any(axis=1)
    for hung in (False, True):
        held = _held(coordinates, hung)
        firm = _weakest(stiffness[:, held][:, :, held])[0] > SINGULAR
        if (chosen := firm & (without == hung)).any():
            yield derived(key, hung), chosen


def _held(coordinates: Sequence[str], hung: bool) -> list[int]:
    return [i for i, name in enumerate(coordinates) if not (hung and name == "y1")]


def _stiffness(key: Structure, values: Sequence[Any]) -> Array:
    """K (n, n), or (N, n, n) where a parameter in it is an array."""
    rows = _compiled_stiffness(key)(*values)
    entries = np.broadcast_arrays(*(entry for row in rows for entry in row))
    stacked = np.stack(entries, axis=-1).astype(float)
    return stacked.reshape(*stacked.shape[:-1], len(rows), len(rows))


@cache
def _compiled_stiffness(key: Structure) -> Callable[..., Any]:
    copy = symbolic(key)
    return _compiled(list(parameter_symbols(key)), structure_matrices(copy, copy.coordinates).stiffness)


def _weakest(stiffness: Array) -> tuple[Any, Any]:
    """Smallest eigenvalue of matrices (..., n, n) whose diagonals are scaled to 1, and its vector."""
    size = np.sqrt(np.einsum("...ii->...i", stiffness))
    size[size == 0] = 1.0
    values, vectors = np.linalg.eigh(stiffness / (size[..., :, None] * size[..., None, :]))
    return values[..., 0], vectors[..., 0]


def _refuse_singular(stiffness: Array, names: Sequence[str]) -> None:
    value, vector = _weakest(stiffness)
    if value > SINGULAR:
        return
    loose = [name for name, part in zip(names, vector, strict=True) if abs(part) > 0.1]
    raise ValueError(
        f"no static equilibrium can be computed: the springs do not hold {', '.join(loose)} "
        "(singular stiffness matrix); give the springs there a positive stiffness"
    )
