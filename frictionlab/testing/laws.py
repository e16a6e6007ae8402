"""Checks of a law by itself, and in the slider on the belt."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.components.component import Component
from frictionlab.components.parameter import parameters_of
from frictionlab.models.symbols import structure, symbol, symbolic

from .text import check_parameters, check_text, refuse

GAPS = np.linspace(1e-4, 0.1, 7)
SPEEDS = np.linspace(0.0, 3.0, 7)
FORCES = np.array([1.0, 50.0, 1e3])
TOLERANCE = 1e-12


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
    kind = next((kind for kind in RULES if isinstance(law, kind)), None)
    if kind is None:
        raise TypeError(f"law must be a ContactLaw, FrictionLaw or ImpactLaw, got {law!r}")
    check_parameters(law, parameters_of(type(law)))
    check_text(law)
    RULES[kind](law)


def _contact(law: Any) -> None:
    force = _values(law, "force", GAPS)
    if not (force >= 0.0).all():
        refuse(law, "force(gap) must not be negative where the bodies press on each other", force)


def _friction(law: Any) -> None:
    speed, normal = map(np.ravel, np.meshgrid(SPEEDS, FORCES))
    kinetic, limit = _values(law, "kinetic", normal, speed), _values(law, "static_limit", normal)
    if not (kinetic >= 0.0).all():
        refuse(law, "kinetic(normal_force, speed) must not be negative, its direction is the mode's", kinetic)
    slow = speed == 0.0
    if not (kinetic[slow] <= limit[slow] * (1 + TOLERANCE)).all():
        refuse(law, "kinetic(normal_force, 0) must not exceed static_limit(normal_force)", kinetic[slow])


def _impact(law: Any) -> None:
    rate, compliance = map(np.ravel, np.meshgrid(SPEEDS, [0.5, 2.0]))
    impulse = _values(law, "impulse", rate, rate, compliance)
    after = rate - compliance * impulse
    if not (impulse >= 0.0).all():
        refuse(law, "impulse(...) must not be negative: bodies do not pull on each other", impulse)
    if not ((after <= TOLERANCE) & (after >= -rate - TOLERANCE)).all():
        refuse(law, "the gap rate after an impact must be from -1 times that before to 0", after)


def _values(law: Any, method: str, *arguments: Any) -> Any:
    """A method's values at arrays of arguments, which must be those of its symbolic copy and of numbers."""
    values = np.broadcast_to(getattr(law, method)(*arguments), arguments[0].shape)
    symbols = [sp.Symbol(f"argument{i}", real=True) for i in range(len(arguments))]
    reduced = law.reduced()
    numbers = {symbol(name): getattr(reduced, name) for name in parameters_of(type(reduced))}
    formula: Any = sp.sympify(getattr(symbolic(structure(law)), method)(*symbols)).subs(numbers)
    for i, row in enumerate(zip(*arguments, strict=True)):
        exact = float(formula.subs(dict(zip(symbols, map(float, row), strict=True))))
        single = float(getattr(law, method)(*map(float, row)))
        if not np.allclose([values[i], single], exact, rtol=TOLERANCE, atol=0.0):
            rule = f"{method} must give the same for symbols ({exact}), numbers and arrays at {row}"
            refuse(law, rule, (single, values[i]))
    return values


RULES: dict[type, Callable[[Any], None]] = {ContactLaw: _contact, FrictionLaw: _friction, ImpactLaw: _impact}
