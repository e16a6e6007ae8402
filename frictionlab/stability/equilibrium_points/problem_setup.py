"""The `EquilibriumProblem` of a model or an automaton, at the default equilibrium, a given one, or all in a
range of a parameter.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.models import Model
from frictionlab.models.coercion import automaton_of
from frictionlab.stability.equilibrium_problem import EquilibriumProblem

from .automaton_equilibria import (
    first_mode_equilibria,
    nearest_equilibrium_problem,
    no_equilibrium_error,
    problem_from_equilibrium,
)
from .batch_equilibria import sliding_problem
from .equilibria import Equilibrium, equilibria
from .static_equations import by_penetration

EQUILIBRIUM_RTOL = 1e-12  # share of a coordinate: an equilibrium computed again is the same but for rounding

Array = NDArray[np.float64]
# Values at which all equilibria are looked for: one branch may live between two of them.
BRANCH_SEARCH_POINTS = 9
SAME_BRANCH_RTOL = 1e-6  # share of a state to which two branches agree
SAME_BRANCH_ROUNDING = 1e-12  # share of the largest state: what differs by less differs by rounding


def equilibrium_problem(model: Any, equilibrium: Equilibrium | None = None) -> EquilibriumProblem:
    """The problem of a model or an automaton, at its default equilibrium or at a given one.

    Raises
    ------
    TypeError
        If it is neither.
    ValueError
        If the equilibrium is not one of the model.
    """
    near = None if equilibrium is None else _check_equilibrium(model, equilibrium)
    if by_penetration(model):
        return sliding_problem(model, near)
    return nearest_equilibrium_problem(model, near)


def _check_equilibrium(model: Any, equilibrium: Any) -> NDArray[np.float64]:
    """The coordinates of one of the model's equilibria, checked to have F_N > 0 where there is a contact."""
    known = equilibria(model)
    if not isinstance(equilibrium, Equilibrium) or not any(_same_equilibrium(e, equilibrium) for e in known):
        raise ValueError(
            f"equilibrium must be one of the {len(known)} of the model, got {equilibrium!r}: "
            "take one from equilibria(model)"
        )
    if by_penetration(model) and not equilibrium.normal_force > 0:
        raise ValueError(
            f"equilibrium must have F_N > 0, got {equilibrium.normal_force:.4g} N: there is no contact"
        )
    return equilibrium.q


def _same_equilibrium(one: Equilibrium, other: Equilibrium) -> bool:
    return one.q.shape == other.q.shape and np.allclose(one.q, other.q, rtol=EQUILIBRIUM_RTOL, atol=0.0)


def equilibrium_branches(model: Any, parameter: str, bounds: tuple[float, float]) -> list[EquilibriumProblem]:
    """The equilibria inside the guards of a mode at some values in the range, each followed from there.

    Where they follow from the penetration (`by_penetration`) the one with the smallest penetration.

    Raises
    ------
    ValueError
        If there is none in the range.
    """
    if by_penetration(model):
        return [equilibrium_problem(model)]
    automaton = automaton_of(model)
    at, found = np.linspace(*bounds, BRANCH_SEARCH_POINTS), []
    # states (m, BRANCH_SEARCH_POINTS) of each branch, NaN where it does not exist
    branch_states: list[Array] = []
    for i, value in enumerate(at):
        changed = {parameter: float(value)}
        mode, flow, points = first_mode_equilibria(automaton.replace(**changed), isinstance(model, Model))
        for x in points.T:
            if any(
                problem.flow is flow and _same_state(way[:, i], x)
                for problem, way in zip(found, branch_states)
            ):
                continue
            found.append(problem_from_equilibrium(model, automaton, mode, flow, x, **changed))
            branch_states.append(found[-1].solve(*found[-1].at({parameter: at})))
    if not found:
        raise no_equilibrium_error(model)
    return found


def _same_state(x: Array, other: Array) -> bool:
    size = np.fmax(np.abs(x), np.abs(other))
    return bool((np.abs(x - other) <= SAME_BRANCH_RTOL * size + SAME_BRANCH_ROUNDING * size.max()).all())
