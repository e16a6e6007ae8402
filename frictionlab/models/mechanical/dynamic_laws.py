"""Force and rates of dynamic friction laws, whose states are symbols, on either side of v_r = 0.

Such a law is written with |v_r|.  On one side this is v_r, on the other -v_r, so that each side is smooth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import sympy

from frictionlab.components.friction import FrictionLaw
from frictionlab.models.symbols import expand_products
from frictionlab.validation import abbreviate

from .mechanics import Friction


class LawValues(NamedTuple):
    """Friction force (N) of a dynamic law, and the rates of its states, in their order."""

    force: Any
    rates: tuple[Any, ...]


def values_of_law(
    law: FrictionLaw, normal_force: Any, relative_velocity: Any, states: Sequence[Any]
) -> LawValues:
    """Force and rates at any arguments, as expressions.

    Raises
    ------
    TypeError, ValueError
        Where the law gives no rates, or others than those of its states.
    """
    given = law.rates(normal_force, relative_velocity, *states)
    force = sympy.sympify(law.force(normal_force, relative_velocity, *states), strict=True)
    return LawValues(force, _in_order(law, "rates", given))


def values_of_contact(contact: Friction, states: Sequence[Any], sign: int) -> LawValues:
    """Force and rates of a contact's law where v_r has this sign."""
    return values_on_one_side(contact.law, contact.pressing, contact.relative_velocity, states, sign)


def values_on_one_side(
    law: FrictionLaw, normal_force: Any, relative_velocity: Any, states: Sequence[Any], sign: int
) -> LawValues:
    """Force and rates where v_r has this sign, without |v_r|."""
    speed = sympy.Dummy("speed", positive=True)  # sympy knows its magnitude
    there = {speed: sign * relative_velocity}
    force, rates = values_of_law(law, normal_force, sign * speed, states)
    return LawValues(force.xreplace(there), tuple(rate.xreplace(there) for rate in rates))


def rates_in_separation(contact: Friction, states: Sequence[Any]) -> tuple[Any, ...]:
    """The rates of a law's states while the bodies are apart; zeros where these return to zero at once."""
    given = contact.law.rates_in_separation(*states)
    if given is None:
        return tuple(sympy.S.Zero for _ in states)
    return _in_order(contact.law, "rates_in_separation", given)


@lru_cache(maxsize=1024)  # each event of a state asks for them
def limits_of_states(contact: Friction) -> tuple[Any, ...]:
    """The largest magnitude of each state of a contact with an elastic-plastic law; () for other laws."""
    return limits_of_law(contact.law, contact.pressing)


def limits_of_law(law: FrictionLaw, normal_force: Any) -> tuple[Any, ...]:
    """The largest magnitude of each state of an elastic-plastic law at a normal force; () for other laws."""
    limit = law.state_limit(normal_force) if law.states else None
    if limit is None:
        return ()
    if len(law.states) == 1 and not isinstance(limit, Mapping):
        return (sympy.sympify(limit, strict=True),)
    return _in_order(law, "state_limit", limit)


def zeros_at_landing(contact: Friction, states: Sequence[Any]) -> dict[Any, int]:
    """Limits -+ states of an elastic-plastic law, zero where a contact lands if nothing presses there."""
    if contact.penetration is None or not returns_to_zero(contact, states):
        return {}
    unpressed = _pressing_at_closure(contact)
    limits = zip(limits_of_states(contact), limits_of_law(contact.law, unpressed), states, strict=False)
    zeros = ((limit - state, limit + state) for limit, at_zero, state in limits if at_zero == 0)
    return {sign * zero: 1 for pair in zeros for zero in pair for sign in (1, -1)}


def _pressing_at_closure(contact: Friction) -> Any:
    """F_N (N) where the gap closes: at a penetration of zero, from which one of the symbols follows."""
    if callable(contact.normal_force):
        depth = sympy.Dummy("depth", real=True)
        return replace(contact, penetration=depth).pressing.xreplace({depth: sympy.S.Zero})
    for x in sorted(contact.penetration.free_symbols, key=str):
        slope = contact.penetration.diff(x)
        if not slope.has(x):
            return expand_products(contact.pressing.xreplace({x: x - contact.penetration / slope}))
    return contact.pressing


def check_elastic(law: FrictionLaw, states: Sequence[Any]) -> None:
    """Raise ValueError where an elastic-plastic law has |v_r|: no event ends its stick where v_r = 0."""
    velocity = sympy.Symbol("relative_velocity", real=True)
    force = sympy.Dummy("normal_force", positive=True)
    values = values_of_law(law, force, velocity, states)
    if any(
        velocity in part.free_symbols
        for one in (values.force, *values.rates)
        for part in one.atoms(sympy.Abs)
    ):
        raise ValueError(
            f"{type(law).__name__} must not have abs(relative_velocity) in force and rates, as it has a "
            "state_limit, within which v_r may have either sign: write relative_velocity itself, or leave "
            "out state_limit"
        )


def returns_to_zero(contact: Friction, states: Sequence[Any]) -> bool:
    """Whether a law's states, if it has any, are zero as soon as the contact is lost."""
    return bool(states) and contact.law.rates_in_separation(*states) is None


def energies_in_states(contact: Friction, states: Sequence[Any]) -> tuple[Any, Any] | None:
    """The energy (J) in the states of a contact's law, pressed and apart; None where it stores none."""
    if not states:
        return None
    pressed, apart = (contact.law.stored_energy(force, *states) for force in (contact.pressing, sympy.S.Zero))
    return None if pressed is None else (pressed, apart)


def _in_order(law: FrictionLaw, method: str, given: Any) -> tuple[Any, ...]:
    of, names = f"{type(law).__name__}.{method}", law.states
    if not isinstance(given, Mapping) or {*given} != {*names}:
        shown = ", ".join(f'"{name}": ...' for name in names)
        got = ", ".join(map(str, given)) if isinstance(given, Mapping) else abbreviate(given)
        what = "limit" if method == "state_limit" else "rate"
        raise ValueError(
            f"{of} must give the {what} of each of its states {', '.join(names)}, got {got or 'none'}: "
            f"write return {{{shown}}}"
        )
    return tuple(sympy.sympify(given[name], strict=True) for name in names)
