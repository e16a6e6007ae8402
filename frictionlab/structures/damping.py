"""Damping of a structure by few numbers: Rayleigh's two, or a ratio for each mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from frictionlab.components.component import Component, parameter
from frictionlab.structures.matrix_files import read_matrices
from frictionlab.structures.parametric_matrix import check_symmetry, parametric_matrix, paths_in
from frictionlab.validation import abbreviate, float_array

MOST_FREEDOMS = 1000  # of a full matrix
RIGID_RTOL = 1e-10  # of the largest eigenvalue: that of a rigid motion, but for rounding


@dataclass(frozen=True, repr=False)
class RayleighDamping(Component):
    """C = alpha M + beta K; circulatory forces have no part in it.

    A mode of the undamped structure with the angular frequency omega has the damping ratio
    (alpha/omega + beta omega)/2.  Both numbers are parameters of the structure.

    Parameters
    ----------
    alpha : float
        1/s, at least 0.
    beta : float
        s, at least 0.

    Examples
    --------
    >>> import frictionlab as fl
    >>> one = fl.Structure([[1.0]], [[100.0]], fl.RayleighDamping(alpha=0.2, beta=0.004))
    >>> fl.eigenvalues(one).damping_ratios.round(6).tolist()
    [0.03, 0.03]
    """

    alpha: float = parameter(
        0.0, unit="1/s", symbol=r"\alpha", meaning="damping proportional to mass", minimum=0.0
    )
    beta: float = parameter(
        0.0, unit="s", symbol=r"\beta", meaning="damping proportional to stiffness", minimum=0.0
    )


def modal_damping(M: Any, K: Any, ratios: Any = 1.0) -> NDArray[np.float64]:
    """The matrix C that gives the modes of M and K damping ratios.

    It is the sum of 2 zeta omega (M x)(M x)^T over the modes x with x M x = 1.  It is linear in the ratios:
    ``C=[("zeta", fl.modal_damping(M, K))]`` makes a parameter of a ratio that all modes have.

    Parameters
    ----------
    M, K : matrix (n, n)
        As those of :class:`Structure`, of up to 1,000 freedoms, each with a mass.
    ratios : float or array (m,)
        At least 0: of all modes, or of the m lowest ones; others are undamped.  Rigid motions are undamped.

    Returns
    -------
    array (n, n)

    Raises
    ------
    ValueError
        For matrices that are no M and K, or are too large; for ratios that are negative or too many.

    Examples
    --------
    >>> import frictionlab as fl
    >>> M, K = [[2.0, 0.0], [0.0, 1.0]], [[30.0, -10.0], [-10.0, 10.0]]
    >>> damped = fl.Structure(M, K, fl.modal_damping(M, K, [0.01, 0.03]))
    >>> fl.eigenvalues(damped).damping_ratios.round(6).tolist()
    [0.01, 0.01, 0.03, 0.03]
    """
    mass, stiffness = _full("M", M), _full("K", K)
    if mass.shape != stiffness.shape:
        raise ValueError(
            f"M and K must have the same size, got {len(mass)} and {len(stiffness)}: give matrices of the "
            "same freedoms"
        )
    cure = "give one number, or one for each of the lowest modes"
    given = float_array("ratios", ratios, cure, finite=True)
    if given.ndim > 1 or given.size > len(mass) or (given < 0.0).any():
        raise ValueError(
            f"ratios must be at least 0 and of at most {len(mass)} modes, got {abbreviate(ratios)}: {cure}"
        )
    try:
        squares, shapes = linalg.eigh(stiffness, mass)
    except np.linalg.LinAlgError:
        raise ValueError(
            "M must give each motion a mass for damping ratios, got one that is not positive: eliminate "
            "freedoms without mass"
        ) from None
    least = -RIGID_RTOL * squares[-1]
    if squares[0] < least or squares[-1] < 0.0:
        raise ValueError(
            f"K must not be negative, got a mode with the square {squares[0]:.6g} of its angular frequency: "
            "correct it, or give C"
        )
    frequencies = np.sqrt(np.where(squares > -least, squares, 0.0))
    shares = np.zeros(len(mass))
    shares[: given.size if given.ndim else None] = given
    momenta = mass @ shapes
    damping = (momenta * (2.0 * shares * frequencies)) @ momenta.T
    return 0.5 * (damping + damping.T)


def _full(name: str, given: Any) -> NDArray[np.float64]:
    matrix = parametric_matrix(name, given, {}, read_matrices(paths_in(given)))
    check_symmetry(name, matrix, 1, "correct the export")
    if matrix.size > MOST_FREEDOMS:
        raise ValueError(
            f"{name} must have at most {MOST_FREEDOMS} freedoms for damping ratios, got {matrix.size}: "
            "reduce the structure, or take RayleighDamping"
        )
    if matrix.parameters or any(one.dtype.kind == "c" for one in matrix.matrices):
        raise ValueError(
            f"{name} must be real and without parameters for damping ratios, got {abbreviate(given)}: "
            "give one real matrix"
        )
    return matrix.at({}).toarray()
