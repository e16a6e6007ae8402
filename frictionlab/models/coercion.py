"""Models and automata as arguments, or as files have them: the model or the automaton, or an error that names
the cure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import structure_of
from frictionlab.validation import unknown_parameter

from .composition import owner_among_laws
from .model import Model
from .serialisation import loaded_class, value_from_data
from .structure_data import Structure
from .symbols import automaton_of_structure, symbol


def require_model(
    model: Any, kinds: str = "a model such as SliderOnBelt", cure: str = "make one, such as fl.SliderOnBelt()"
) -> Model:
    """The model itself; TypeError, with the `kinds` that are taken, for anything else."""
    if isinstance(model, Model):
        return model
    if isinstance(model, type) and issubclass(model, Model):
        got, cure = f"the class {model.__name__}", f"write {model.__name__}()"
    else:
        got = repr(model)
    raise TypeError(f"model must be {kinds}, got {got}: {cure}")


def check_parameter_name(model: Any, name: Any) -> None:
    """Raise TypeError unless it names a parameter of the model or automaton, and suggest the nearest."""
    of_model = isinstance(model, Model)
    known = list(model.parameters) if of_model else [each.name for each in automaton_of(model).parameters]
    if name not in known:
        hint = owner_among_laws(name, model.roles, model.components) if of_model else ""
        raise unknown_parameter(type(model).__name__, name, known, hint)


def automaton_of(model: Any) -> HybridAutomaton:
    """The automaton of a model, or the automaton itself.

    Raises
    ------
    TypeError
        If it is neither.
    """
    if isinstance(model, HybridAutomaton):
        return model
    return require_model(model, "a model such as SliderOnBelt or a HybridAutomaton").automaton()


# What deriving may raise where the values of a structure are others than any model's.
NO_STRUCTURE = ValueError, TypeError, AttributeError, LookupError, ArithmeticError, RecursionError


def automaton_from_structure_data(data: Any, parameters: Mapping[str, float]) -> HybridAutomaton:
    """The automaton, with these numbers, of the model whose structure `structure_to_data` described.

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
    needed = dict.fromkeys((*key.parameters, *found.values))
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
