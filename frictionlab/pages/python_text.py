"""Python that makes a model and its run, as explorers and pages copy it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from functools import cache
from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import Component, value_repr
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models.model import Model, differences
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

    An automaton and a structure have a name in it, and what is not the package's own an import line.

    >>> import frictionlab as fl
    >>> print(python_text(fl.MassOnBelt(mu_k=0.4), 20.0, "rest", fl.Taylor()))
    import frictionlab as fl
    model = fl.MassOnBelt(mu_k=0.4)
    run = fl.simulate(model, 20.0, x0='rest')
    """
    classes: list[type] = [type(method)]
    if isinstance(model, HybridAutomaton):  # any text may be the name of its parameter
        what = "automaton" if model.source is None else "structure"
        given = ", ".join(f"{n!r}: {value_repr(value)}" for n, value in (values or model.values).items())
        call = f"{what}.replace(**{{{given}}})  # the {what} that is shown"
    else:
        call = _expression(model, classes)
        if values:
            given = ", ".join(f"{name}={value_repr(value)}" for name, value in values.items())
            call += f".replace({given})"
    start = repr(x0) if isinstance(x0, str) else f"[{', '.join(map(value_repr, x0))}]"
    run = f"run = fl.simulate(model, {value_repr(t_end)}, x0={start}{_method_argument(method)})"
    return "\n".join(["import frictionlab as fl", *_import_lines(classes), f"model = {call}", run])


def _name_of(cls: type) -> str:
    """The class as its user writes it: the package's own have a prefix, whatever others are called."""
    return f"fl.{cls.__name__}" if is_public(cls) else cls.__name__


def _expression(value: Any, classes: list[type]) -> str:
    """Python that makes a model, a law, or a field of theirs, whose classes are added to `classes`."""
    if isinstance(value, tuple):
        parts = (_expression(each, classes) for each in value)
        return f"({', '.join(parts)}{',' * (len(value) == 1)})"
    if not isinstance(value, Component):
        return value_repr(value)
    classes.append(type(value))
    if isinstance(value, Model):
        fields_shown = differences(value)
    else:
        fields_shown = {field.name: getattr(value, field.name) for field in fields(value)}
    given = ", ".join(f"{name}={_expression(each, classes)}" for name, each in fields_shown.items())
    return f"{_name_of(type(value))}({given})"


@cache
def _method_argument(method: Method) -> str:
    """The method as an argument, with the options that differ from its defaults."""
    options = [(f.name, getattr(method, f.name), f.default) for f in fields(method)]
    values = ", ".join(f"{name}={value_repr(value)}" for name, value, usual in options if value != usual)
    return "" if method == Taylor() else f", method={_name_of(type(method))}({values})"


def _import_lines(classes: Iterable[type]) -> Iterator[str]:
    """Import lines for classes that are not the package's own."""
    for cls in dict.fromkeys(classes):
        if cls.__module__ == "__main__":
            yield f"# run the cell that defines {cls.__name__} first"
        elif not is_public(cls):
            yield f"from {cls.__module__} import {cls.__name__}"
