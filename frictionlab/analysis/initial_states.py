"""Initial states of runs: what "rest", "near", a mapping or an array stands for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import by_names, state_from_mapping, state_from_x0, with_phase_in_turn
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.law_coefficients import check_law_coefficients
from frictionlab.models.mechanical.law_states_at_start import carried_to_limit, with_law_states, within_limit
from frictionlab.models.mechanical.masses import check_masses
from frictionlab.models.model import REST, Model, ModelOrAutomaton, MovingSystem, automaton_of
from frictionlab.stability.eigenproblems.displaced_equilibrium import displaced_equilibrium
from frictionlab.validation import abbreviate, check_choice, check_mapping, check_number, float_array


def initial_state_of(
    model: ModelOrAutomaton, x0: Any, automaton: HybridAutomaton | None = None
) -> np.ndarray:
    """The initial state (n,) of a run of a model or an automaton; raises for a bad `x0`.

    States of a model that a mapping leaves out are as at rest; those that an array leaves out are zero.
    States of friction laws are zero where their contacts are lost, unless the law says otherwise.  Give the
    model's automaton where it is at hand, to save its assembly.
    """
    automaton = automaton_of(model) if automaton is None else automaton
    kept = vars(model) if isinstance(model, Model) and isinstance(x0, str) and x0 == "rest" else {}
    if REST in kept:
        return kept[REST].copy()
    start = with_phase_in_turn(automaton, state_from_x0(automaton, _completed(model, x0, automaton)))
    if isinstance(model, MechanicalModel):
        check_masses(model, start)
        check_law_coefficients(model, start)
    if isinstance(model, (MechanicalModel, MovingSystem)):
        start = with_law_states(model, start, within_limit)
    kept[REST] = start
    return start.copy()


def carried_state_of(model: ModelOrAutomaton, state: np.ndarray) -> np.ndarray:
    """The initial state (n,) of a run from where one with other parameter values has ended."""
    state = with_phase_in_turn(automaton_of(model), state)
    if not isinstance(model, (MechanicalModel, MovingSystem)):
        return state
    return with_law_states(model, state, carried_to_limit)


def _completed(model: ModelOrAutomaton, x0: Any, automaton: HybridAutomaton) -> Any:
    """The state that a name stands for; a mapping or an array with the states that it leaves out."""
    if isinstance(x0, str):
        check_choice("x0", x0, ("rest", "near"), "or give numbers, one for each state")
        if x0 == "rest":
            return _state_at_rest(model, automaton)
        return model.near_equilibrium() if isinstance(model, MovingSystem) else displaced_equilibrium(model)
    x0 = by_names(x0)
    if isinstance(x0, Mapping):
        return state_from_mapping(automaton, x0, _state_at_rest(model, automaton))
    if not isinstance(model, (Model, MovingSystem)):
        return x0
    n, names = len(model.coordinates), automaton.state_names
    state = float_array("x0", x0, f"give a number for each of the states {', '.join(names)}")
    return np.append(state, np.zeros(len(names) - 2 * n)) if state.shape == (2 * n,) else state


def _state_at_rest(model: ModelOrAutomaton, automaton: HybridAutomaton) -> np.ndarray:
    names = automaton.state_names
    start = np.zeros(len(names))
    for name, value in model.release().items() if isinstance(model, Model) else ():
        start[names.index(name)] = value
    return start


def named_state(x0: Any) -> Any:
    """An initial state of any model as data that JSON can hold; names stay names.

    Raises ValueError for what is none of any model.
    """
    x0 = by_names(x0)
    if isinstance(x0, Mapping):
        check_mapping("x0", x0, "give states by their names")
        cure = "give one in SI units"
        return {name: check_number(f"x0[{abbreviate(name)}]", each, cure=cure) for name, each in x0.items()}
    if isinstance(x0, str):
        return x0
    numbers = float_array("x0", x0, "give a number for each state", finite=True)
    if numbers.ndim != 1 or not numbers.size:
        raise ValueError(f"x0 must be a list of numbers, got {abbreviate(x0)}: give one for each state")
    return numbers.tolist()
