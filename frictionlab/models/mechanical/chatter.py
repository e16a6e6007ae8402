"""Chatter: the limit of impacts after each of which the slider leaves the belt again, in ever shorter
flights.

Eq. (13) brings the velocity relative to the belt's *material* point to zero.  The slider then leaves the
belt at the rate r = (x1' - x2') phi, which no impact changes.  Where r > 0 the gap opens; if in flight it
closes with the acceleration a, the slider lands after 2 r/a, at the rate r, and so on.  Flights of length T
differ from their limit T -> 0 by O(T^2).  In the limit the impulses are a force F_N = a/(W_N^T M^-1 W_N) that
keeps gap and gap rate at zero, and there is no friction, as there is none in flight and none in an impact.
It ends where r comes to zero, which is the accumulation (Zeno) point of the flights, or where they grow long;
the slider then takes off, with an error of the order of r, as the limit does not contain the phase of a
flight.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sympy

from frictionlab.automaton import Event, Mode, Reset
from frictionlab.models.symbols import expand_products, symbol

from .contact_regimes import AFTER_FLIGHT
from .mechanics import Friction
from .resets import RATE_SYMBOLS, compliance, impact_resets, material_rate, rates_after_impact

if TYPE_CHECKING:
    from .equations_of_motion import LagrangeSystem

CHATTER_MODE = "chatter"
CHATTER_TIME = symbol("chatter")  # s, below which the solver replaces flights by their limit


def chatter_mode(found: LagrangeSystem) -> Mode | None:
    """The limit mode of a single contact at which the gap opens again after an impact; None for others."""
    for contact in found.mechanics.contacts[:1]:
        if isinstance(contact, Friction) and contact.impact is not None and "separation" in contact.modes:
            rate = leaving_rate(found, contact)
            return None if rate == 0 else _limit(found, contact, rate)
    return None


def _limit(found: LagrangeSystem, contact: Friction, rate: Any) -> Mode:
    closing = closing_acceleration(found, contact)
    force = closing / compliance(found, found.normal(contact))
    outputs = {
        "penetration": contact.penetration,
        "gap": -contact.penetration,
        "normal_force": force,
        "friction_force": sympy.S.Zero,
        "relative_velocity": contact.relative_velocity,
    }
    flow = (*found.v, *_accelerations(found, contact, force))
    constraints = (contact.penetration, found.rate(contact.penetration))
    return Mode(
        CHATTER_MODE, flow, _chatter_events(found, contact, rate, closing), constraints, outputs, limit=True
    )


def leaving_rate(found: LagrangeSystem, contact: Friction) -> Any:
    """Rate r at which the gap opens after an impact before which it closed at the rate r.

    Zero where there is no other such rate, and for impact laws that are not linear in the rates.
    """
    material, full, soft = RATE_SYMBOLS
    rate, other = sympy.symbols("rate other")
    law, w = rates_after_impact(found, contact, contact.impact)[1], found.normal(contact)
    before = {material: rate + other, full: rate, soft: compliance(found, w)}
    after = law.subs(before, simultaneous=True)
    slope = sympy.diff(after, rate)
    if slope.has(rate) or slope == -1:
        return sympy.S.Zero
    fixed = -after.subs(rate, 0) / (1 + slope)
    return expand_products(fixed.subs(other, material_rate(found, contact) - found.rate(contact.penetration)))


def closing_acceleration(found: LagrangeSystem, contact: Friction) -> Any:
    """Second derivative of the penetration in flight, Eq. (9)."""
    state = zip((*found.q, *found.v), (*found.v, *_accelerations(found, contact, 0)), strict=True)
    penetration_rate = found.rate(contact.penetration)
    return sum(sympy.diff(penetration_rate, x) * rate for x, rate in state)


def _accelerations(found: LagrangeSystem, contact: Friction, force: Any) -> list[Any]:
    """Accelerations under a normal force without friction."""
    return list(found.inverse * sympy.Matrix(found.forces(contact, force)))


def _chatter_events(found: LagrangeSystem, contact: Friction, rate: Any, closing: Any) -> tuple[Event, ...]:
    """The events of the limit mode: flights have become infinitely short, or twice as long as those
    replaced."""
    targets = tuple(name for name in AFTER_FLIGHT if name in contact.modes)
    landed = Reset(vanishing={contact.penetration: 2, -contact.penetration: 2})
    return (
        Event("leaving rate", rate, targets, landed),
        Event("flight", CHATTER_TIME * closing - rate, ("separation",), impact_resets(found, contact)[0]),
    )
