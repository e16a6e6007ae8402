"""Sliding equilibria: all of them, through one scalar polynomial in the gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from .bracket import scanned
from .polynomial import real_roots
from .statics import Statics, statics

Array = NDArray[np.float64]
TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A state of steady sliding.

    Parameters
    ----------
    q : array (n,)
        The coordinates, m and rad.
    gap : float
        Compression of the contact, m.
    normal_force, friction_force : float
        F_N and F_T, N.
    residual : float
        Largest force or moment left over in the static equations, relative to the largest in them.
    """

    q: Array
    gap: float
    normal_force: float
    friction_force: float
    residual: float


def equilibria(model: Any) -> tuple[Equilibrium, ...]:
    """All real solutions of the static equations of sliding, Eq. (18), in ascending order of the gap.

    The contact law is taken as it is for a negative gap too, as the paper's equations do: a solution with
    F_N < 0 is an equilibrium of a bilateral contact only.  Friction has the sign of the belt's speed.

    Where the contact and friction laws are polynomials (those of the package are) none is missed.  For
    other laws the gaps up to three times that of the unloaded contact are searched for changes of sign.

    Parameters
    ----------
    model : SliderOnBelt

    Returns
    -------
    tuple of Equilibrium

    Raises
    ------
    ValueError
        If the springs do not hold a coordinate (singular stiffness matrix).
    """
    problem = statics(model)
    return tuple(_equilibrium(problem, gap) for gap in _gaps(problem))


def equilibrium(model: Any) -> Equilibrium:
    """The equilibrium of steady sliding with F_N > 0; of several the one with the smallest gap.

    That is the one whose gap grows from zero with the preload.

    Raises
    ------
    ValueError
        If there is none.
    """
    found = equilibria(model)
    pressed = [e for e in found if e.normal_force > 0]
    if pressed:
        return min(pressed, key=lambda e: e.gap)
    forces = ", ".join(f"{e.normal_force:.4g} N" for e in found) or "none"
    raise ValueError(
        f"there must be an equilibrium with F_N > 0, got normal forces: {forces}: "
        f"raise the preload F ({model.F:g} N), or change friction or stiffnesses"
    )


def residual_polynomial(problem: Statics) -> Polynomial | None:
    """gap(q(g)) - g, of degree 9 at most for Eq. (2); None where a law is no polynomial."""
    try:
        excess = problem.excess(Polynomial([0.0, 1.0]))
    except (TypeError, ValueError, AttributeError):  # sqrt, a broken power, exp or a comparison in a law
        return None
    return excess if isinstance(excess, Polynomial) else None


def _gaps(problem: Statics) -> list[float]:
    polynomial = residual_polynomial(problem)
    if polynomial is None:
        return scanned(problem.excess, 3 * abs(problem.unloaded_gap()) or 1.0)
    slope = polynomial.deriv()
    return [_polished(problem, gap, float(slope(gap))) for gap in real_roots(polynomial)]


def _polished(problem: Statics, gap: float, slope: float) -> float:
    """Newton's method on the composed equation, which does not suffer from the polynomial's cancellation."""
    left = abs(problem.excess(gap))
    for _ in range(4):
        trial = gap - problem.excess(gap) / slope if slope else gap
        if not abs(problem.excess(trial)) < left:
            break
        gap, left = trial, abs(problem.excess(trial))
    return float(gap)


def _equilibrium(problem: Statics, gap: float) -> Equilibrium:
    q = np.array([float(x) for x in problem.coordinates(gap)])
    normal = float(problem.force(gap))
    residual = problem.residual(q)
    if not residual < TOLERANCE:
        raise ValueError(
            f"the equilibrium at a gap of {gap:.6g} m must satisfy the static equations to {TOLERANCE:g}, "
            f"got {residual:.2g}: the stiffnesses differ by too many orders of magnitude"
        )
    return Equilibrium(q, gap, normal, float(problem.friction(normal)), residual)
