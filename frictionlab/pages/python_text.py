"""Python that makes a model and its run, as explorers and pages copy it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import fields
from functools import cache
from typing import Any

import frictionlab
from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import Component
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models.serialisation import is_public
from frictionlab.pages.scene import MARK, Shown


class Place(str):
    """The name of a value that a page puts in."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"{MARK}{self}{MARK}"


def python_text(
    model: Shown, t_end: Any, x0: Any, method: Method, values: Mapping[str, Any] | None = None
) -> str:
    """Python that makes a model and its run; `values` take the places of the model's own.

    An automaton has a name in it, and a law that is not the package's own an import line.

    >>> import frictionlab as fl
    >>> print(python_text(fl.MassOnBelt(mu_k=0.4), 20.0, "rest", fl.Taylor()))
    import frictionlab as fl
    model = fl.MassOnBelt(mu_k=0.4)
    run = fl.simulate(model, 20.0, x0='rest')
    """
    if isinstance(model, HybridAutomaton):  # any text may be the name of its parameter
        call = f"automaton.replace(**{dict(values or model.values)!r})  # the automaton that is shown"
        imports = []
    else:
        given = ", ".join(f"{name}={value!r}" for name, value in (values or {}).items())
        call = f"{_model_call(model)}.replace({given})" if given else _model_call(model)
        imports = list(_import_lines(model))
    start = x0 if isinstance(x0, str) else list(x0)
    run = f"run = fl.simulate(model, {t_end!r}, x0={start!r}{_method_argument(method)})"
    return "\n".join(["import frictionlab as fl", *imports, f"model = {call}", run])


def _model_call(model: Component) -> str:
    """Python that makes the model, where names of the package have their prefix."""
    names = re.compile(r"\b([A-Z]\w*)\(")
    return names.sub(lambda m: f"fl.{m[0]}" if m[1] in frictionlab.__all__ else m[0], repr(model))


@cache
def _method_argument(method: Method) -> str:
    """The method as an argument, with the options that differ from its defaults."""
    usual = type(method)()
    differs = [f.name for f in fields(method) if getattr(method, f.name) != getattr(usual, f.name)]
    values = ", ".join(f"{name}={getattr(method, name)!r}" for name in differs)
    return "" if method == Taylor() else f", method=fl.{type(method).__name__}({values})"


def _import_lines(model: Component) -> Iterator[str]:
    """Import lines for the model and for laws that are not the package's own."""
    for cls in dict.fromkeys(_component_classes(model)):
        if is_public(cls):
            continue
        if cls.__module__ == "__main__":
            yield f"# run the cell that defines {cls.__name__} first"
        elif f"{cls.__name__}(" in repr(model):
            yield f"from {cls.__module__} import {cls.__name__}"


def _component_classes(component: Component) -> Iterator[type]:
    yield type(component)
    for value in getattr(component, "components", {}).values():
        yield from _component_classes(value)
