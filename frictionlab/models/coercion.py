"""Models and automata as arguments: the model or the automaton itself, or an error that names the cure."""

from __future__ import annotations

from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.validation import unknown_parameter

from .composition import owner_among_laws
from .model import Model


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
