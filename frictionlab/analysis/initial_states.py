"""Initial states: what "rest", "near" and arrays stand for, of models and of automata, and their checks."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.models import Model
from frictionlab.models.coercion import automaton_of
from frictionlab.stability import equilibrium
from frictionlab.validation import abbreviate, check_choice, float_array

NEAR_EQUILIBRIUM_FACTOR = 1.01  # "near": the equilibrium displaced by one percent


def model_initial_state(model: Any, x0: Any, automaton: Any = None) -> Any:
    """The state that a name stands for; of an array the states it leaves out are zero.

    Give the model's automaton where it is at hand, to save its assembly.
    """
    if not isinstance(model, Model):  # an automaton, whose start is an array
        return x0
    automaton = model.automaton() if automaton is None else automaton
    n, names = len(model.coordinates), [symbol.name for symbol in automaton.states]
    if not isinstance(x0, str):
        return np.append(x0, np.zeros(len(names) - 2 * n)) if np.shape(x0) == (2 * n,) else x0
    check_choice("x0", x0, ("rest", "near"), "or give numbers, one for each state")
    start = np.zeros(len(names))
    if x0 == "near":
        start[:n] = NEAR_EQUILIBRIUM_FACTOR * equilibrium(model).q
        return start
    for name, value in model.release().items():
        start[names.index(name)] = value
    return start


def initial_state_of(model: Any, x0: Any) -> np.ndarray:
    """The initial state (n,) that :func:`simulate` would begin with; raises for one that it refuses."""
    return validate_initial_state(model, x0, automaton_of(model))


def validate_initial_state(model: Any, x0: Any, automaton: HybridAutomaton) -> np.ndarray:
    """The initial state of a model, or of an automaton, that :func:`simulate` would take; else ValueError."""
    names, size = ", ".join(map(str, automaton.states)), len(automaton.states)
    rule = f"a finite number for each of the states {names}"
    start = float_array("x0", resolve_initial_state(model, x0, automaton), f"give {rule}")
    if start.shape != (size,) or not np.isfinite(start).all():
        raise ValueError(f"x0 must hold {rule}, got {abbreviate(x0)}: give {size} numbers, in this order")
    return start


def resolve_initial_state(model: Any, x0: Any, automaton: HybridAutomaton | None = None) -> Any:
    """The state (2n,) that a name stands for, of a model or an automaton."""
    if isinstance(model, HybridAutomaton) and isinstance(x0, str):
        check_choice("x0", x0, ("rest",), "or give numbers, one for each state")
        return np.zeros(len(model.states))
    return model_initial_state(model, x0, automaton)
