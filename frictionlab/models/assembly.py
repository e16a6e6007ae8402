"""The assembly of a model into a hybrid automaton, once for every structure."""

from __future__ import annotations

import logging
import time
from functools import lru_cache
from typing import Any

from frictionlab.automaton import HybridAutomaton

from .symbols import Structure, check_laws, structure_of_component, symbol, symbolic_copy

LOGGER = logging.getLogger(__name__)


def state_symbols(coordinates: tuple[str, ...]) -> tuple[Any, ...]:
    """Symbols of the coordinates, then of their velocities."""
    return tuple(symbol(name) for name in (*coordinates, *(name + "'" for name in coordinates)))


@lru_cache(maxsize=256)
def automaton_of_structure(key: Structure) -> HybridAutomaton:
    """States and modes of a structure, without the numbers."""
    begin = time.perf_counter()
    model = symbolic_copy(key)
    derived = model.derive()
    seconds = time.perf_counter() - begin
    LOGGER.info("derived the automaton of %s in %.2g s", type(model).__name__, seconds)
    return derived


def automaton_of_model(model: Any) -> HybridAutomaton:
    """The automaton of a model; models of one structure share their `modes` object.

    Raises
    ------
    ValueError
        Where a law has no real value at the values of the parameters.
    """
    check_laws(model)
    derived = automaton_of_structure(structure_of_component(model))
    numbers = {symbol(name): value for name, value in model.parameters.items()}
    numbers |= dict(derived.parameters)
    return HybridAutomaton(derived.states, derived.modes, numbers, derived.coordinates)
