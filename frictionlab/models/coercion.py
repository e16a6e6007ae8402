"""Models and automata as arguments: the model or the automaton itself, or an error that names the cure."""

from __future__ import annotations

from typing import Any

from frictionlab.automaton import HybridAutomaton

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
