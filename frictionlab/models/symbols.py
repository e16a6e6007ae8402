"""Symbols, and the copy of a model that has them for values.

A model is derived once for its *structure*: the classes of its components and those of their fields that
are no parameters.  The copy made here runs no checks, since there is nothing to check about a symbol.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import sympy

from frictionlab.components.component import Component
from frictionlab.components.parameter import parameters_of, structure_of

from .explained import explain


@cache
def symbol(name: str) -> sympy.Symbol:
    """The real symbol of a state or a parameter; a velocity is its coordinate's name with a prime."""
    return sympy.Symbol(name, real=True)


class Structure(NamedTuple):
    """A component without its numbers; the key under which derivations are remembered."""

    component: type
    values: tuple[Any, ...]


def structure(component: Component) -> Structure:
    """The structure of a component, and of the components it is made of."""
    reduced = component.reduced()
    values = (getattr(reduced, name) for name in structure_of(type(reduced)))
    return Structure(type(reduced), tuple(structure(v) if isinstance(v, Component) else v for v in values))


def symbolic(key: Structure) -> Any:
    """A component of that structure with the symbols of its parameters for values."""
    copy = object.__new__(key.component)
    for name in parameters_of(key.component):
        object.__setattr__(copy, name, symbol(name))
    for name, value in zip(structure_of(key.component), key.values, strict=True):
        object.__setattr__(copy, name, symbolic(value) if isinstance(value, Structure) else value)
    explain(copy)
    return copy


def parameter_symbols(key: Structure) -> tuple[sympy.Symbol, ...]:
    """Symbols of all parameters of a structure, in the order of :func:`numbers`."""
    return tuple(map(symbol, _names(key)))


def numbers(model: Any) -> tuple[float, ...]:
    """Values of the parameters that the model's structure has, in one order."""
    values = model.parameters
    return tuple(values[name] for name in _names(structure(model)))


@cache
def _names(key: Structure) -> tuple[str, ...]:
    return tuple(symbolic(key).parameters)


def multiplied_out(expr: Any) -> Any:
    """Products of sums as sums of products; what stands within a law's function stays as it is.

    Taken apart, exp(v - x') is exp(v) exp(-x'), of which one factor may be above the largest number.
    """
    return sympy.expand(expr, power_exp=False, power_base=False, log=False)
