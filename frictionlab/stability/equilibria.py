"""Sliding equilibria of a model: all of them, through one scalar polynomial in the gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.models.symbols import numbers, structure

from .automata import automaton_of, no_equilibrium, steady_states, values_of
from .automata import residual as left_over
from .bracket import scanned
from .pressed import FINEST, excess_polynomial, polished, reach
from .real_roots import real_roots
from .statics import Statics, by_gap, residual, statics_of

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
        F_N and F_T, N.  Of an automaton, NaN where its mode has no such output, as for the gap.
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

    Where what is left for the gap is a polynomial, none is missed: so it is with all laws of the package but
    HertzContact, PressureDependent and MovingLoad("normal").  For those, and for others of your own, the
    gaps up to three times that of the unloaded contact are searched for changes of sign.

    Parameters
    ----------
    model : Model or HybridAutomaton
        Where the model has no `statics` (SliderOnBelt has), the equilibria inside the guards of a mode, of
        the first mode that has any, by their distance from the origin; they are searched with Newton's method
        from starts in all decades, and those that rounding can tell apart are told apart.  Modes of a model
        that hold something fast, such as stick, are left out.

    Returns
    -------
    tuple of Equilibrium

    Raises
    ------
    ValueError
        If the springs do not hold a coordinate (singular stiffness matrix).
    """
    if not by_gap(model):
        return _of_automaton(model)
    values = numbers(model)
    statics = statics_of(structure(model), values, model.coordinates)
    return tuple(_equilibrium(statics, values, gap) for gap in _gaps(statics, values))


def equilibrium(model: Any) -> Equilibrium:
    """The equilibrium of steady sliding with F_N > 0; of several the one with the smallest gap.

    That is the one whose gap grows from zero with the preload.

    Parameters
    ----------
    model : Model or HybridAutomaton
        See :func:`equilibria`.

    Returns
    -------
    Equilibrium

    Raises
    ------
    ValueError
        If there is none.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.equilibrium(fl.SliderOnBelt(mu_k=0.3)).q.round(4).tolist()
    [-0.0042, -0.0304, -0.0036, -0.0061, -0.0001]
    """
    found = equilibria(model)
    if not by_gap(model):
        if not found:
            raise no_equilibrium(model)
        return found[0]
    # A law with even powers may press where there is no contact.
    pressed = [e for e in found if e.normal_force > 0 and e.gap > 0]
    if pressed:
        return min(pressed, key=lambda e: e.gap)
    forces = ", ".join(f"{e.normal_force:.4g} N" for e in found) or "none"
    raise ValueError(
        f"there must be an equilibrium with F_N > 0, got normal forces: {forces}: "
        f"raise the preload F ({model.F:g} N), or change friction or stiffnesses"
    )


def _of_automaton(model: Any) -> tuple[Equilibrium, ...]:
    automaton = automaton_of(model)
    mode, flow, points = steady_states(model)
    n, values = automaton.coordinates or len(automaton.states), values_of(automaton)
    outputs = [mode.outputs.get(name, sympy.nan) for name in ("gap", "normal_force", "friction_force")]
    evaluated = flow.compiled(outputs)
    return tuple(
        Equilibrium(x[:n], *map(float, evaluated(*x, *values)), residual=left_over(flow, x, values))
        for x in points.T
    )


def _gaps(statics: Statics, values: Sequence[float]) -> list[float]:
    excess = excess_polynomial(statics, values)
    if excess is None:
        return _searched(statics, values)
    with np.errstate(all="ignore"):  # at a double root the slope vanishes
        return [float(g) for g in polished(statics, values, np.array(real_roots(excess[:, 0])))]


def _searched(statics: Statics, values: Sequence[float]) -> list[float]:
    """Gaps at which the equation changes its sign, on a grid that is finer towards zero."""
    finest = FINEST * float(reach(statics, values))

    def excess(s: Any) -> Any:
        found = statics.excess(finest * np.sinh(s), *values)
        return np.where(np.isfinite(found), found, np.nan)  # a law may overflow far from the root

    with np.errstate(all="ignore"):
        found = scanned(excess, np.arcsinh(1 / FINEST))
        return [float(finest * np.sinh(s)) for s in found]


def _equilibrium(statics: Statics, values: Sequence[float], gap: float) -> Equilibrium:
    q: Any = np.array(statics.coordinates(gap, *values), dtype=float)
    normal, friction = map(float, statics.forces(gap, *values))
    left = float(residual(statics, q, values))
    if not left < TOLERANCE:
        raise ValueError(
            f"the equilibrium at a gap of {gap:.6g} m must satisfy the static equations to {TOLERANCE:g}, "
            f"got {left:.2g}: the stiffnesses differ by too many orders of magnitude"
        )
    return Equilibrium(q, gap, normal, friction, left)
