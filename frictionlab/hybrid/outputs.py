"""Named quantities of a trajectory, computed from states by the formulas of each mode."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.hybrid.formulas import formula


@lru_cache(maxsize=1024)
def _formula(mode: Mode, name: str, states: tuple, parameters: tuple) -> Callable[..., np.ndarray]:
    return formula([*states, *parameters], mode.outputs[name])


def evaluate(automaton: HybridAutomaton, name: str, states: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Values (N,) of output `name` at `states` (N, n), each by the formula of its mode."""
    values = np.empty(len(states))
    parameters = tuple(automaton.parameters)
    for i in np.unique(modes):
        chosen = modes == i
        function = _formula(automaton.modes[i], name, automaton.states, parameters)
        values[chosen] = function(*states[chosen].T, *automaton.parameters.values())
    return values
