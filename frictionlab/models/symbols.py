"""Symbols, copies of models whose parameters are symbols, and the automata that are derived from these.

A model is derived once for its *structure*: the classes of its components and those of their fields that are
no parameters.  The symbolic copy runs no checks of values, as symbols have none.  Methods of its laws that
cannot take symbols raise an error that says so.  `automaton_of_model` puts the numbers back.

Sympy's `diff` tries every symbol on every term, n^2 times for a chain of n springs.  `gradient` takes the
derivatives of a term only by the symbols that it contains.  They are the same expressions.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from contextlib import suppress
from functools import cache, lru_cache, partial, wraps
from inspect import signature
from typing import TYPE_CHECKING, Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.expressions import multiply_out, unsorted_product
from frictionlab.automaton.hybrid_automaton import Late, late_automaton
from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.components.component import Component, parameters_of, structure_of
from frictionlab.lazy_names import sympy
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas
from frictionlab.tape.undefined_parts import doubtful_parts, undefined_words
from frictionlab.validation import abbreviate

from .serialisation import Structure, derivations_of, loaded_class, structure_of_component, value_from_data

if TYPE_CHECKING:
    from frictionlab.models.model import Model

LAW_METHODS = ("force", "kinetic", "static_limit", "impulse", "friction")
LOGGER = logging.getLogger(__name__)
# Up to so many modes of a model with several contacts are all derived and kept; where there are more, each is
# derived when a run first tries to enter it.
MOST_KEPT_MODES = 27
# Errors that deriving may raise where a structure, read from a file, is that of no model.
NO_STRUCTURE = ValueError, TypeError, AttributeError, LookupError, ArithmeticError, RecursionError
Derivatives = dict[Any, Any]  # symbol -> derivative by it; zeros are left out


@cache
def symbol(name: str) -> Any:
    """The real symbol of a state or a parameter; a velocity is its coordinate's name with a prime."""
    return sympy.Symbol(name, real=True)


def symbolic_copy(key: Structure) -> Any:
    """A component of this structure, with symbols as values of its parameters."""
    copy = object.__new__(key.component)
    for name in parameters_of(key.component):
        object.__setattr__(copy, name, symbol(name))
    for name, value in zip(structure_of(key.component), key.values, strict=True):
        object.__setattr__(copy, name, symbolic_copy(value) if isinstance(value, Structure) else value)
    explain_errors(copy)
    return copy


def parameter_symbols(key: Structure) -> tuple[Any, ...]:
    """Symbols of all parameters of a structure, in the order of :func:`structure_values`."""
    return tuple(map(symbol, key.parameters))


def structure_values(model: Model) -> tuple[float, ...]:
    """Values of the parameters of the model's structure, in the order of :func:`parameter_symbols`."""
    values = model.parameters
    return tuple(values[name] for name in structure_of_component(model).parameters)


def check_laws(key: Structure, values: Mapping[str, float]) -> None:
    """Raise ValueError if a law of this structure has no real value at these values of its parameters."""
    parts, formulas = _doubtful_parts(key)
    numbers = formulas.numbers(*(values[name] for name in key.parameters))
    for (place, text, names), number in zip(parts, numbers.tolist(), strict=True):
        if not math.isfinite(number):
            raise ValueError(
                f"{place} of this {key.component.__name__} has {undefined_words(text, names, values)}: "
                "give it another value; in a law of your own, fl.parameter(..., minimum=...) says which are "
                "allowed"
            )


@cache
def _doubtful_parts(key: Structure) -> tuple[list[Any], Formulas]:
    """Parts of the laws' formulas that may have no value, and these values as formulas of the parameters.

    Of each part there are the name of the law's method, its text and the names of its parameters.
    """
    derivations = derivations_of(key, key.parameters)

    def parts() -> list[tuple[str, Any]]:
        known = frozenset(parameter_symbols(key))
        return [(place, part) for place, law in _law_formulas(key) for part in doubtful_parts(law, known)]

    words = derivations.value(
        "laws", lambda: [[place, str(part), sorted(map(str, part.free_symbols))] for place, part in parts()]
    )
    values = kept_formulas(
        derivations, "laws", lambda: formulas_of(parameter_symbols(key), [part for _, part in parts()])
    )
    return words, values


def _law_formulas(key: Structure) -> tuple[tuple[str, Any], ...]:
    """What the methods of the laws return, each with its name, such as "Coulomb.kinetic"."""
    formulas: list[tuple[str, Any]] = []
    for law in symbolic_copy(key).components.values():
        for name in LAW_METHODS if isinstance(law, (ContactLaw, FrictionLaw, ImpactLaw)) else ():
            with suppress(AttributeError, NotImplementedError, TypeError):  # deriving raises it if it matters
                method = getattr(law, name)
                formula = method(*map(_positive, signature(method).parameters))
                formulas.append((f"{type(law).__name__}.{name}", formula))
    return tuple(formulas)


def _positive(argument: str) -> Any:
    return sympy.Dummy(argument, positive=True)


def expand_products(expr: Any) -> Any:
    """Expand products of sums, unless that is too long; arguments of a law's functions stay as they are.

    Otherwise exp(-((v - x')/v_s)^2) would become a product of exponentials, of which one overflows and
    another is zero.
    """
    given = sympy.sympify(expr, strict=True)
    functions = {part: sympy.Dummy() for part in given.atoms(sympy.Function, sympy.Pow) if _is_function(part)}
    back = {dummy: part for part, dummy in functions.items()}
    return multiply_out(given.xreplace(functions)).xreplace(back)


def _is_function(part: Any) -> bool:
    return not part.is_Pow or not part.exp.is_Integer


def explain_errors(copy: Component) -> None:
    """Make the methods of a law's symbolic copy raise errors that name law and method."""
    for name in LAW_METHODS if isinstance(copy, (ContactLaw, FrictionLaw, ImpactLaw)) else ():
        if hasattr(copy, name):
            object.__setattr__(copy, name, _with_explanation(getattr(copy, name), type(copy).__name__))


def _with_explanation(method: Callable[..., Any], law: str) -> Callable[..., Any]:
    @wraps(method)
    def explained(*arguments: Any) -> Any:
        try:
            value = method(*arguments)
        except TypeError as error:
            raise TypeError(
                f"{law}.{method.__name__} must be a formula that takes symbols too, and fails with them "
                f"({error}): write it with + - * / ** and fl.functions (exp, tanh, ...), without if, min, "
                "max, math or numpy; what changes at a value is a mode of its own"
            ) from error
        if value is None:
            raise TypeError(
                f"{law}.{method.__name__} must return a force or an impulse, got None: write return in front"
            )
        return value

    return explained


def state_symbols(coordinates: tuple[str, ...]) -> tuple[Any, ...]:
    """Symbols of the coordinates, then of their velocities."""
    return tuple(symbol(name) for name in (*coordinates, *(name + "'" for name in coordinates)))


@lru_cache(maxsize=256)
def automaton_of_structure(key: Structure) -> HybridAutomaton:
    """The automaton of a structure, without values of the model's parameters."""
    begin = time.perf_counter()
    model = symbolic_copy(key)
    derived = model.derive()
    seconds = time.perf_counter() - begin
    LOGGER.info("derived the automaton of %s in %.2g s", type(model).__name__, seconds)
    return derived


def automaton_of_model(model: Model) -> HybridAutomaton:
    """The automaton of a model; models of one structure share their `modes` object.

    Raises
    ------
    ValueError
        Where a law has no real value at the values of the parameters.
    """
    key, parameters = structure_of_component(model), model.parameters
    check_laws(key, parameters)
    derivations = derivations_of(key, tuple(parameters))
    known = derivations.get("automaton")
    if known is None:
        derived = automaton_of_structure(key)
        modes: Any = derived.modes
        if not derivations.keeps or (derived.on_demand and modes.names.more_than(MOST_KEPT_MODES)):
            numbers = {symbol(name): value for name, value in parameters.items()}
            numbers |= dict(derived.parameters)
            return HybridAutomaton(derived.states, derived.modes, numbers, derived.coordinates)
        known = _outline(derived)
        derivations.keep("automaton", known)
    values = {**parameters, **known["parameters"]}
    return late_automaton(Late(known, values, partial(_automaton_with_values, key), derivations))


def _automaton_with_values(key: Structure, values: Mapping[str, float]) -> HybridAutomaton:
    derived = automaton_of_structure(key)
    numbers = {symbol(name): value for name, value in values.items()}
    return HybridAutomaton(derived.states, derived.modes, numbers, derived.coordinates)


def automaton_from_structure_data(data: Any, kind: type, parameters: Mapping[str, float]) -> HybridAutomaton:
    """The automaton of a structure, with these values of its parameters.

    Parameters
    ----------
    data : mapping
        The structure, from `structure_to_data`.
    kind : type
        The base class that the model must have.
    parameters : mapping of str to float

    Raises
    ------
    ValueError
        If the data is malformed, a class in it is not loaded, or a parameter is missing.
    """
    try:
        key = _structure_from_data(data, kind)
        automaton = automaton_of_structure(key)
    except NO_STRUCTURE as error:
        raise ValueError(f"the model of its automaton cannot be made, {error}") from error
    needed = dict.fromkeys((*key.parameters, *automaton.values))
    if missing := [name for name in needed if name not in parameters]:
        raise ValueError(f"it lacks the parameters {', '.join(missing)}")
    numbers = {symbol(name): value for name, value in parameters.items()}
    return HybridAutomaton(automaton.states, automaton.modes, numbers, automaton.coordinates)


def _structure_from_data(data: Any, base: type) -> Structure:
    if not isinstance(data, Mapping) or not isinstance(data.get("structure"), Mapping):
        raise ValueError(
            f"a {base.__name__} must be a mapping with 'class' and 'structure', got {abbreviate(data)}"
        )
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


def _outline(derived: HybridAutomaton) -> dict[str, Any]:
    """What a :class:`Late` automaton knows before it is derived."""
    modes: Any = derived.modes
    return {
        "states": derived.state_names,
        "modes": tuple(derived.names),
        "regimes": [[regime.name for regime in part] for part in modes.parts] if derived.on_demand else None,
        "outputs": derived.outputs,
        "parameters": derived.values,
        "coordinates": derived.coordinates,
    }


def derivatives(expression: Any, symbols: Set[Any]) -> Derivatives:
    """The derivatives of an expression by those of the symbols that it contains."""
    expr = sympy.sympify(expression, strict=True)
    if expr.is_Symbol:
        return {expr: sympy.S.One} if expr in symbols else {}
    if expr.is_Add:
        return _sums(_terms(expr.args, symbols, lambda _, slope: slope))
    if expr.is_Mul:
        return _sums(_terms(expr.args, symbols, _product_rule(expr.args)))
    there = sorted(expr.free_symbols & symbols, key=str)
    return {x: slope for x in there if (slope := sympy.diff(expr, x)) != 0}


def gradient(expression: Any, x: Sequence[Any]) -> list[Any]:
    """The derivatives of an expression by each of `x`."""
    slopes = derivatives(expression, {*x})
    return [slopes.get(one, sympy.S.Zero) for one in x]


def _terms(
    arguments: Sequence[Any], symbols: Set[Any], term: Callable[[int, Any], Any]
) -> Iterable[tuple[Any, Any]]:
    for i, argument in enumerate(arguments):
        for x, slope in derivatives(argument, symbols).items():
            yield x, term(i, slope)


def _product_rule(factors: tuple[Any, ...]) -> Callable[[int, Any], Any]:
    def term(i: int, slope: Any) -> Any:
        if slope == 1:
            return unsorted_product([*factors[:i], *factors[i + 1 :]])
        return sympy.Mul(*factors[:i], slope, *factors[i + 1 :])

    return term


def _sums(terms: Iterable[tuple[Any, Any]]) -> Derivatives:
    parts: dict[Any, list[Any]] = {}
    for x, term in terms:
        parts.setdefault(x, []).append(term)
    sums = ((x, sympy.Add(*some)) for x, some in parts.items())
    return {x: total for x, total in sums if total != 0}
