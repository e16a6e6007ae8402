"""A model's structure as data that JSON can hold, and back: what its automaton is derived from.

Files hold it for runs of an automaton whose modes are derived on demand, which cannot hold all of its modes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import structure_of

from .model import Model
from .serialisation import class_path, loaded_class, value_from_data, value_to_data
from .symbols import Structure, automaton_of_structure, parameter_symbols, symbol

# What deriving may raise where the values of a structure are others than any model's.
NO_STRUCTURE = ValueError, TypeError, AttributeError, LookupError, ArithmeticError, RecursionError


def structure_to_data(key: Structure) -> dict[str, Any]:
    """Classes of a model and its components, and those of their fields that are no parameters.

    Raises
    ------
    TypeError
        For a field that no file can hold.
    """
    names, owner = structure_of(key.component), key.component.__name__
    values = {
        name: structure_to_data(value)
        if isinstance(value, Structure)
        else value_to_data(value, f"{owner}.{name}")
        for name, value in zip(names, key.values, strict=True)
    }
    return {"class": class_path(key.component), "structure": values}


def automaton_from_structure_data(data: Any, parameters: Mapping[str, float]) -> HybridAutomaton:
    """The automaton, with these numbers, of the model whose structure :func:`structure_to_data` described.

    Raises
    ------
    ValueError
        If the data is malformed, or a class in it is not loaded.
    """
    try:
        key = _structure_from_data(data, Model)
        found = automaton_of_structure(key)
    except NO_STRUCTURE as error:
        raise ValueError(f"the model of its automaton cannot be made, {error}") from error
    needed = dict.fromkeys(each.name for each in (*parameter_symbols(key), *found.parameters))
    if missing := [name for name in needed if name not in parameters]:
        raise ValueError(f"it lacks the parameters {', '.join(missing)}")
    numbers = {symbol(name): value for name, value in parameters.items()}
    return HybridAutomaton(found.states, found.modes, numbers, found.coordinates)


def _structure_from_data(data: Any, base: type) -> Structure:
    if not isinstance(data, Mapping) or not isinstance(data.get("structure"), Mapping):
        raise ValueError(f"a {base.__name__} must be a mapping with 'class' and 'structure', got {data!r}")
    cls, values = loaded_class(data.get("class"), base), data["structure"]
    names, roles = structure_of(cls), getattr(cls, "roles", {})
    if sorted(values) != sorted(names):
        raise ValueError(f"a {cls.__name__} has {', '.join(names)}, got {', '.join(values)}")
    return Structure(
        cls,
        tuple(
            _structure_from_data(values[name], roles[name])
            if name in roles
            else value_from_data(values[name])
            for name in names
        ),
    )
