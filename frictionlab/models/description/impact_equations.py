"""The equations of an impact: on a stop, or of a re-contact, Eqs. (10) to (17)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem, system_at
from frictionlab.models.mechanical.mechanics import Stop
from frictionlab.models.mechanical.resets import (
    RATE_SYMBOLS,
    friction_impulse,
    material_rate,
    normal_impulse,
    rate_after,
    rates_after_impact,
    velocities_after,
)
from frictionlab.models.symbols import symbol

from .equations import equation

NORMAL_IMPULSE, TANGENTIAL_IMPULSE = symbol("p"), symbol("p_T")


def stop_equations(stop: Stop, rate: Any) -> tuple[Any, ...]:
    """The rate of the distance after the impact from that before, which is written `rate`."""
    before, after = symbol("rate-"), symbol("rate+")
    return equation(before, rate), equation(after, rate_after(stop.law, before))


def impact_equations(model: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Eqs. (10) to (17) for a symbolic model with one contact, and their symbols by name.

    Velocities just before and just after the impact are named ``y1'-`` and ``y1'+``.  Eq. (16) is the one
    that follows from Eqs. (11) and (14): as printed in the paper it has two terms too many.  With friction in
    the impact there is its impulse, and the normal one is that for the velocities after it.
    """
    before, after = (_kinematics_with_sign(model, sign) for sign in "-+")
    contact: Any = before.rubbing
    solved, rubbing = (of(before, contact, contact.impact) for of in (normal_impulse, friction_impulse))
    symbols = {str(x): x for x in (*before.q, *before.v, *after.v, NORMAL_IMPULSE)}
    if rubbing != 0:
        return _with_friction(before, after, solved, rubbing), symbols | {
            str(TANGENTIAL_IMPULSE): TANGENTIAL_IMPULSE
        }
    factors = before.inverse * before.normal(contact)
    jumps = [row for row in zip(before.v, after.v, factors, strict=True) if row[2] != 0]
    equations = (
        *(equation(new - old, factor * NORMAL_IMPULSE) for old, new, factor in jumps),
        *_impact_law(before, after),
        equation(NORMAL_IMPULSE, solved),
        *(equation(new, old + factor * solved) for old, new, factor in jumps),
    )
    return equations, symbols


def _with_friction(
    before: LagrangeSystem, after: LagrangeSystem, solved: Any, rubbing: Any
) -> tuple[Any, ...]:
    contact = before.rubbing
    pushed = before.inverse * (
        before.normal(contact) * NORMAL_IMPULSE + before.direction(contact) * TANGENTIAL_IMPULSE
    )
    jumps = (equation(new - old, p) for old, new, p in zip(before.v, after.v, pushed, strict=True))
    rubbed = velocities_after(before, before.direction(contact), TANGENTIAL_IMPULSE)
    return *jumps, equation(TANGENTIAL_IMPULSE, rubbing), equation(NORMAL_IMPULSE, solved.xreplace(rubbed))


def impact_letters(model: Any, letters: Mapping[str, str]) -> dict[str, str]:
    """LaTeX of the velocities before and after, as the paper writes them, and of the coordinates."""
    found = {}
    for name in model.coordinates:
        letter = letters.get(name) or (f"{name[0]}_{{{name[1:]}}}" if name[1:] else name)
        head, _, index = letter.partition("_")
        found[name] = letter
        for sign in "-+":
            dotted = rf"\dot{{{head}}}" + (f"_{index}" if index else "")
            found[f"{name}'{sign}"] = rf"{dotted}(t_{{\mathrm{{r}}}}^{{{sign}}})"
    return found


def _kinematics_with_sign(model: Any, sign: str) -> LagrangeSystem:
    q = [symbol(name) for name in model.coordinates]
    return system_at(model, q, [symbol(f"{name}'{sign}") for name in model.coordinates])


def _impact_law(before: LagrangeSystem, after: LagrangeSystem) -> tuple[Any, ...]:
    """Eq. (13): the rate that the impact law brings to a multiple of what it was."""
    pairs = list(zip(_rates(before), _rates(after), strict=True))
    contact: Any = before.rubbing
    for (old, new), left, rate in zip(
        pairs, rates_after_impact(before, contact, contact.impact), RATE_SYMBOLS
    ):
        factor = sympy.cancel(left / rate)
        if not factor.has(*RATE_SYMBOLS):
            return (equation(new, factor * old),)
    return ()


def _rates(found: LagrangeSystem) -> tuple[Any, Any]:
    return material_rate(found, found.rubbing), found.rate(found.rubbing.penetration)
