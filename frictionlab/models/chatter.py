"""Chatter: what impacts come to where each throws the slider off again, in ever shorter flights.

Eq. (13) brings the velocity relative to the belt's *material* point to zero.  The slider then leaves the
belt at the rate r = (x1' - x2') phi, which no impact changes.  Where r > 0 it flies; if in flight the gap
closes with the acceleration a, it lands after 2 r/a, at the rate r, and so on.  Flights of length T differ
from their limit T -> 0 by O(T^2).  In the limit the impulses are a force F_N = a/(W_N^T M^-1 W_N) that keeps
gap and gap rate at zero, and there is no friction, as there is none in flight and none in an impact.  It
ends where r comes to zero, which is the accumulation point of the flights, or where they grow long; the
slider then takes off, with an error of the order of r, as the limit does not know which flight it is in.
"""

from __future__ import annotations

from typing import Any

import sympy

from frictionlab.automaton import Event, Mode, Reset

from .resets import RATES, impact, rates_after
from .scene import Scene
from .symbols import multiplied_out, symbol

CHATTER = "chatter"
SHORTEST = symbol("chatter")  # s, below which the solver replaces flights by their limit
AFTER = ("slip+", "slip-", "slip", "stick")


def chatter(scene: Scene) -> Mode | None:
    """The mode, for impact laws by which impacts throw off; None for the others."""
    if "separation" not in scene.model.interface.modes:
        return None
    rate = leaving_rate(scene)
    if rate == 0:
        return None
    closing = closing_acceleration(scene)
    force = closing / scene.compliance
    accelerations = [f / mass for f, mass in zip(scene.forces(force), scene.mass, strict=True)]
    outputs = {
        "gap": scene.gap,
        "normal_force": force,
        "friction_force": sympy.S.Zero,
        "relative_velocity": scene.relative_velocity,
    }
    flow, constraints = (*scene.v, *accelerations), (scene.gap, scene.gap_rate)
    return Mode(CHATTER, flow, _ends(scene, rate, closing), constraints, outputs, limit=True)


def leaving_rate(scene: Scene) -> Any:
    """Rate r at which the gap opens after an impact that it closed into at the rate r.

    Zero where no other rate is such, and for impact laws that are not linear in the rates.
    """
    material, full, compliance = RATES
    rate, other = sympy.symbols("rate other")
    law = rates_after(scene, scene.model.impact)[1]
    after = law.subs({material: rate + other, full: rate, compliance: scene.compliance}, simultaneous=True)
    slope = sympy.diff(after, rate)
    if slope.has(rate) or slope == -1:
        return sympy.S.Zero
    fixed = -after.subs(rate, 0) / (1 + slope)
    return multiplied_out(fixed.subs(other, scene.material_rate - scene.gap_rate))


def closing_acceleration(scene: Scene) -> Any:
    """Second derivative of the gap in flight, Eq. (9)."""
    accelerations = [force / mass for force, mass in zip(scene.forces(0), scene.mass, strict=True)]
    state = zip((*scene.q, *scene.v), (*scene.v, *accelerations), strict=True)
    return sum(sympy.diff(scene.gap_rate, x) * rate for x, rate in state)


def _ends(scene: Scene, rate: Any, closing: Any) -> tuple[Event, ...]:
    """Where flights come to nothing, and where they last twice as long as those replaced."""
    targets = tuple(name for name in AFTER if name in scene.model.interface.modes)
    landed = Reset(vanishing={scene.gap: 2, -scene.gap: 2})
    return (
        Event("leaving rate", rate, targets, landed),
        Event("flight", SHORTEST * closing - rate, ("separation",), impact(scene)[0]),
    )
