"""Copies of models whose parameters are symbols, and what their laws are at values of these.

The copy runs no checks of values, as symbols have none.  Methods of its laws that cannot take symbols raise
an error that says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from copy import copy
from dataclasses import fields, replace
from functools import cache, wraps
from inspect import signature
from typing import Any

from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.components.component import (
    Component,
    StructureKey,
    laws_of_expressions,
    parameters_of,
    structure_of,
)
from frictionlab.components.surroundings import surroundings_of
from frictionlab.lazy_names import sympy
from frictionlab.models.symbols import parameter_symbols, symbol
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas
from frictionlab.tape.undefined_parts import doubtful_parts, undefined_words
from frictionlab.validation import abbreviate, with_article

from .kept_structures import derivations_of

LAWS = ContactLaw, FrictionLaw, ImpactLaw
LAW_METHODS = (
    "force",
    "rates",
    "rates_in_separation",
    "state_limit",
    "kinetic",
    "static_limit",
    "impulse",
    "friction",
)
# How numpy, math and sympy begin their errors where a number is wanted of a symbol.
NO_NUMBER = (
    "loop of ufunc does not support",
    "ufunc '",
    "Cannot convert",
    "Cannot cast array data",
    "cannot determine truth value",
)
MAY_BE_NONE = "rates_in_separation", "state_limit"
OF_STATES = "rates", *MAY_BE_NONE


def symbolic_copy(key: StructureKey) -> Any:
    """A component of this structure, with symbols as values of its parameters.

    Raises
    ------
    ValueError
        If its class uses numbers or methods that have changed since: they would give the equations of another
        structure.
    """
    if surroundings_of(key.component) != key.surroundings:
        raise ValueError(
            f"{with_article(key.component)} must be as it was when this model was made, but it uses numbers "
            "or methods that have changed: make the model anew"
        )
    law = object.__new__(key.component)
    for name in parameters_of(key.component):
        object.__setattr__(law, name, symbol(name))
    for name, value in zip(structure_of(key.component), key.values, strict=True):
        object.__setattr__(law, name, symbolic_copy(value) if isinstance(value, StructureKey) else value)
    explain_errors(law)
    return law


def check_laws(key: StructureKey, values: Mapping[str, float]) -> None:
    """Raise ValueError if a law of this structure has no real value at these values of its parameters."""
    parts, formulas = _doubtful_parts(key)
    if not parts:
        return
    numbers = formulas.numbers(*(values[name] for name in key.parameters))
    for (place, text, names), number in zip(parts, numbers.tolist(), strict=True):
        if not math.isfinite(number):
            raise ValueError(
                f"{place} of this {key.component.__name__} has {undefined_words(text, names, values)}: "
                "give it another value; in a law of your own, fl.parameter(..., minimum=...) says which are "
                "allowed"
            )


@cache
def _doubtful_parts(key: StructureKey) -> tuple[list[Any], Formulas]:
    """Parts of the laws' formulas that may have no value, and these values as formulas of the parameters.

    Of each part there are the name of the law's method, its text and the names of its parameters.
    """
    derivations = derivations_of(key)

    def parts() -> list[tuple[str, Any]]:
        known, laws = frozenset(parameter_symbols(key)), symbolic_copy(key).components.values()
        return [(place, part) for place, law in law_formulas(laws) for part in doubtful_parts(law, known)]

    words = derivations.value(
        "laws", lambda: [[place, str(part), sorted(map(str, part.free_symbols))] for place, part in parts()]
    )
    values = kept_formulas(
        derivations, "laws", lambda: formulas_of(parameter_symbols(key), [part for _, part in parts()])
    )
    return words, values


def law_formulas(laws: Iterable[Any]) -> tuple[tuple[str, Any], ...]:
    """What the methods of symbolic copies of laws return, each with its name, such as "Coulomb.kinetic"."""
    formulas: list[tuple[str, Any]] = []
    for law in laws:
        for name in LAW_METHODS if isinstance(law, LAWS) else ():
            with suppress(AttributeError, NotImplementedError, TypeError):  # deriving raises it if it matters
                method = getattr(law, name)
                given = method(*map(_positive, signature(method).parameters))
                parts = given.values() if isinstance(given, Mapping) else () if given is None else (given,)
                formulas += [(f"{type(law).__name__}.{name}", formula) for formula in parts]
    return tuple(formulas)


def _positive(argument: str) -> Any:
    return sympy.Dummy(argument, positive=True)


def explain_errors(law: Component) -> None:
    """Make the methods of a law's symbolic copy raise errors that name law and method, once."""
    for name in LAW_METHODS if isinstance(law, LAWS) else ():
        if hasattr(law, name) and name not in vars(law):
            object.__setattr__(law, name, _with_explanation(getattr(law, name), type(law).__name__, name))


def with_explained_errors(contact: Any) -> Any:
    """A contact whose laws take symbols as symbolic copies do, also laws that are made in `mechanics`."""
    laws = {one.name: getattr(contact, one.name) for one in fields(contact)}
    laws = {name: copy(law) for name, law in laws.items() if isinstance(law, LAWS)}
    for law in laws.values():
        explain_errors(law)
    return replace(contact, **laws)


def _with_explanation(method: Callable[..., Any], law: str, name: str) -> Callable[..., Any]:
    @wraps(method)
    def explained(*arguments: Any) -> Any:
        try:
            with laws_of_expressions([]):  # a law may make another law of symbols, and return its formula
                value = method(*arguments)
        except (TypeError, AttributeError) as error:
            if not takes(method, arguments):
                raise TypeError(
                    f"{law}.{name} must take {len(arguments)} arguments beside self, got "
                    f"{name}{signature(method)}: write those of its base's method"
                ) from error
            if not wants_number(error):
                raise
            raise TypeError(
                f"{law}.{name} must be a formula that takes symbols too, and fails with them "
                f"({error}): write it with + - * / ** and fl.functions (exp, tanh, ...), without if, min, "
                "max, math or numpy; where a law changes write fl.functions.piecewise, minimum, maximum, "
                "absolute or interpolate"
            ) from error
        if value is None and name not in MAY_BE_NONE:
            raise TypeError(
                f"{law}.{name} must return a force, an impulse or rates, got None: write return in front"
            )
        parts = (value,)
        if isinstance(value, Mapping) and name in OF_STATES:
            parts = value.values()
        elif name.startswith("rates"):  # what is no mapping is refused with the names of the states
            parts = ()
        for one in parts:
            if one is not None and not _is_formula(one):
                raise TypeError(
                    f"{law}.{name} must return a formula, got {abbreviate(one)}: write it with the arguments "
                    "and the parameters, without quotes and arrays"
                )
        return value

    return explained


def takes(method: Callable[..., Any], arguments: tuple[Any, ...]) -> bool:
    """Whether a method can be called with these arguments."""
    try:
        signature(method).bind(*arguments)
    except TypeError:
        return False
    return True


def wants_number(error: TypeError | AttributeError) -> bool:
    """Whether an error is one of numpy, math or sympy, which want a number and were given a symbol."""
    if isinstance(error, AttributeError):
        return hasattr(error.obj, "free_symbols")
    return str(error).startswith(NO_NUMBER)


def _is_formula(given: Any) -> bool:
    try:
        return isinstance(sympy.sympify(given, strict=True), sympy.Expr)
    except (sympy.SympifyError, TypeError, ValueError):
        return False
