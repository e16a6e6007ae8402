"""Borders of laws in pieces near an equilibrium.

On a border the eigenvalues of either side differ; what holds near the equilibrium holds as far as a border.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton.hybrid_automaton import module_of_pieces
from frictionlab.automaton.modes_on_demand import ModesOnDemand
from frictionlab.lazy_names import sympy
from frictionlab.models.model import ModelOrAutomaton, automaton_of
from frictionlab.tape.formulas import formulas_of

ON_BORDER_RTOL = 1e-9  # share of the state, of x and of the border within which x is on it


def borders_at(model: ModelOrAutomaton, state: NDArray[np.float64]) -> list[str]:
    """The borders of laws in pieces that a state (m,) is on, such as "x = d"."""
    automaton, pieces = automaton_of(model), module_of_pieces()
    whole = automaton.whole
    if pieces is None or whole is automaton:
        return []
    modes = whole.modes.known().modes if isinstance(whole.modes, ModesOnDemand) else whole.modes
    expressions = [one for mode in modes for one in pieces.mode_expressions(mode)]
    names, sides = [], []
    for division in pieces.divisions_of(automaton.states, expressions):
        for i, border in enumerate(division.borders):
            names.append(division.name_of_border(i))
            sides += [division.x, border]
    formulas = formulas_of([*automaton.states, *automaton.parameters], sides)
    numbers = formulas.numbers(*state, *map(float, automaton.values.values())).reshape(-1, 2)
    size = np.fmax(np.abs(numbers).max(axis=1), np.abs(state).max(initial=0.0))
    on = np.abs(numbers[:, 0] - numbers[:, 1]) <= ON_BORDER_RTOL * size
    return [name for name, there in zip(names, on, strict=True) if there]


def distances_from_borders(states: Sequence[Any], expressions: Iterable[Any]) -> list[Any]:
    """How far x is from each border of the laws in pieces in some expressions of the states."""
    pieces = module_of_pieces()
    divisions = () if pieces is None else pieces.divisions_of(states, list(expressions))
    return [sympy.Abs(one.x - border) for one in divisions for border in one.borders]
