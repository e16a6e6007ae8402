"""The assembly of a model into a hybrid automaton, once for every structure."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from frictionlab.automaton import HybridAutomaton, Mode

from .chatter import SHORTEST, chatter
from .modes import build
from .scene import Scene, scene
from .symbols import Structure, structure, symbol, symbolic


def states(coordinates: tuple[str, ...]) -> tuple[Any, ...]:
    """Symbols of the coordinates, then of their velocities."""
    return tuple(symbol(name) for name in (*coordinates, *(name + "'" for name in coordinates)))


@lru_cache(maxsize=256)
def derive(key: Structure) -> Scene:
    """The mechanics of a structure in its state symbols."""
    model = symbolic(key)
    x = states(model.coordinates)
    n = len(model.coordinates)
    return scene(model, x[:n], x[n:])


@lru_cache(maxsize=256)
def assemble(key: Structure) -> HybridAutomaton:
    """States and modes of a structure, without the numbers."""
    return symbolic(key).derive()


def slider_automaton(model: Any) -> HybridAutomaton:
    """The automaton of a symbolic copy of the slider on a belt: one mode for each of its interface."""
    mechanics, numbers = derive(structure(model)), {}
    modes: tuple[Mode, ...] = tuple(build(mechanics, name) for name in mechanics.model.interface.modes)
    limit = chatter(mechanics)
    if limit is not None:
        modes, numbers = (*modes, limit), {SHORTEST: 0.0}
    return HybridAutomaton((*mechanics.q, *mechanics.v), modes, numbers, len(mechanics.q))


def automaton(model: Any) -> HybridAutomaton:
    """The automaton of a model; models of one structure share their `modes` object."""
    derived = assemble(structure(model))
    numbers = {symbol(name): value for name, value in model.parameters.items()}
    numbers |= dict(derived.parameters)
    return HybridAutomaton(derived.states, derived.modes, numbers, derived.coordinates)
