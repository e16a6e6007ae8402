"""Checks of a law by itself: signs of its forces, the same values for numbers, arrays and symbols; and those
that laws and models share: parameters with meaning and range, a repr and a dictionary that make the object
again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.components.component import Component, Parameter, parameters_of, structure_of
from frictionlab.models.serialisation import component_from_dict, component_to_dict
from frictionlab.models.symbols import structure_of_component, symbol, symbolic_copy

PENETRATIONS = np.linspace(1e-4, 0.1, 7)
SPEEDS = np.linspace(0.0, 3.0, 7)
FORCES = np.array([1.0, 50.0, 1e3])
LAW_RTOL = 1e-12


def fail(subject: Any, rule: str, got: Any) -> None:
    """Raise AssertionError: what is checked, the rule, and what there is instead."""
    raise AssertionError(f"{subject!r}: {rule}, got {got!r}")


def check_parameters(subject: Component, known: Mapping[str, Parameter]) -> None:
    """Every parameter has a symbol, a meaning and a range that holds its default."""
    for name, about in known.items():
        if not about.meaning:
            fail(subject, f"parameter {name} must have a meaning: write parameter(..., meaning=...)", "")
        if about.range is None:
            fail(subject, f"parameter {name} must have a range for its slider", None)
        low, high = about.range or (0.0, 0.0)
        if about.default is not None and not low <= about.default <= high:
            fail(subject, f"the range of {name} must hold its default", (about.range, about.default))


def check_round_trip(subject: Component) -> None:
    """The repr is an expression that makes the object again, and so does the dictionary."""
    again = eval(repr(subject), _class_names(subject))
    if again != subject:
        fail(subject, "its repr must make it again", again)
    again = component_from_dict(component_to_dict(subject), type(subject))
    if again != subject or hash(again) != hash(subject):
        fail(subject, "its dictionary must make it again", again)


def _class_names(subject: Component) -> dict[str, type]:
    """The classes that a repr may name."""
    found: dict[str, type] = {type(subject).__name__: type(subject)}
    waiting = [getattr(subject, name) for name in structure_of(type(subject))]
    while waiting:
        value = waiting.pop()
        if isinstance(value, tuple):
            waiting += value
        elif isinstance(value, Component):
            found |= _class_names(value)
        elif isinstance(value, Enum):
            found[type(value).__name__] = type(value)
    return found


def check_law(law: Component) -> None:
    """Check a contact, friction or impact law.

    Its parameters are described, its repr makes it again, its methods give for symbols what they give for
    numbers and arrays, and the forces have the signs that the modes of contact rely on.

    Parameters
    ----------
    law : ContactLaw, FrictionLaw or ImpactLaw

    Raises
    ------
    AssertionError
        With the rule that the law breaks, and what it gives instead.
    TypeError
        For anything else than such a law.
    """
    kind = next((kind for kind in LAW_CHECKS if isinstance(law, kind)), None)
    if kind is None:
        raise TypeError(f"law must be a ContactLaw, FrictionLaw or ImpactLaw, got {law!r}")
    check_parameters(law, parameters_of(type(law)))
    check_round_trip(law)
    LAW_CHECKS[kind](law)


def _check_contact(law: Any) -> None:
    force = _consistent_values(law, "force", PENETRATIONS)
    if not (force >= 0.0).all():
        fail(law, "force(penetration) must not be negative where the bodies press on each other", force)


def _check_friction(law: Any) -> None:
    speed, normal = map(np.ravel, np.meshgrid(SPEEDS, FORCES))
    kinetic, limit = (
        _consistent_values(law, "kinetic", normal, speed),
        _consistent_values(law, "static_limit", normal),
    )
    if not (kinetic >= 0.0).all():
        fail(law, "kinetic(normal_force, speed) must not be negative, its direction is the mode's", kinetic)
    slow = speed == 0.0
    if not (kinetic[slow] <= limit[slow] * (1 + LAW_RTOL)).all():
        fail(law, "kinetic(normal_force, 0) must not exceed static_limit(normal_force)", kinetic[slow])


def _check_impact(law: Any) -> None:
    rate, compliance = map(np.ravel, np.meshgrid(SPEEDS, [0.5, 2.0]))
    impulse = _consistent_values(law, "impulse", rate, rate, compliance)
    after = rate - compliance * impulse
    if not (impulse >= 0.0).all():
        fail(law, "impulse(...) must not be negative: bodies do not pull on each other", impulse)
    if not ((after <= LAW_RTOL) & (after >= -rate - LAW_RTOL)).all():
        fail(law, "the gap rate after an impact must be from -1 times that before to 0", after)


def _consistent_values(law: Any, method: str, *arguments: Any) -> Any:
    """A method's values at arrays of arguments, which must be those of its symbolic copy and of numbers."""
    values = np.broadcast_to(getattr(law, method)(*arguments), arguments[0].shape)
    symbols = [sp.Symbol(f"argument{i}", real=True) for i in range(len(arguments))]
    reduced = law.reduced()
    numbers = {symbol(name): getattr(reduced, name) for name in parameters_of(type(reduced))}
    formula: Any = sp.sympify(
        getattr(symbolic_copy(structure_of_component(law)), method)(*symbols), strict=True
    ).subs(numbers)
    for i, row in enumerate(zip(*arguments, strict=True)):
        exact = float(formula.subs(dict(zip(symbols, map(float, row), strict=True))))
        single = float(getattr(law, method)(*map(float, row)))
        if not np.allclose([values[i], single], exact, rtol=LAW_RTOL, atol=0.0):
            rule = f"{method} must give the same for symbols ({exact}), numbers and arrays at {row}"
            fail(law, rule, (single, values[i]))
    return values


LAW_CHECKS: dict[type, Callable[[Any], None]] = {
    ContactLaw: _check_contact,
    FrictionLaw: _check_friction,
    ImpactLaw: _check_impact,
}
