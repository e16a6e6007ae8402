"""What jumps at an event: the projection on stick, and the impact of a re-contact."""

from __future__ import annotations

from typing import Any

import sympy

from frictionlab.automaton import Reset
from frictionlab.components.impact import ImpactLaw, PlasticImpact

from .scene import Scene
from .symbols import multiplied_out

RATES = sympy.symbols("material_rate gap_rate compliance", real=True)


def projection(scene: Scene) -> Reset:
    """v_r = 0, keeping the tangential momentum M x1' + m x2': it removes only the rounding of the root."""
    one, two = scene.tangent.index(1), scene.tangent.index(-1)
    heavy, light, belt = scene.mass[one], scene.mass[two], scene.model.v
    together = (heavy * scene.v[one] + light * scene.v[two] + light * belt) / (heavy + light)
    return Reset({scene.v[one]: together, scene.v[two]: together - belt})


def impact(scene: Scene) -> tuple[Reset, Reset]:
    """The re-contact under the model's impact law, and the one that closes an accumulation of them."""
    return _jump(scene, scene.model.impact), _jump(scene, PlasticImpact("full"))


def velocities_after(scene: Scene, direction: Any, impulse: Any) -> dict[Any, Any]:
    """M dv = W p, Eqs. (10) to (12): the velocities that jump, after an impulse along W_N or W_T."""
    rows = zip(scene.v, direction, scene.mass, strict=True)
    return {rate: rate + w * impulse / mass for rate, w, mass in rows if w * impulse != 0}


def friction_impulse(scene: Scene, law: ImpactLaw) -> Any:
    """The tangential impulse (N s) of the re-contact, along W_T; none in the paper."""
    compliance = sum(w**2 / m for w, m in zip(scene.tangent, scene.mass, strict=True))
    return law.friction(impulse(scene, law), scene.relative_velocity / compliance)


def impulse(scene: Scene, law: ImpactLaw) -> Any:
    """The impulse p (N s) of the re-contact, Eq. (14)."""
    return law.impulse(scene.material_rate, scene.gap_rate, scene.compliance)


def rates_after(scene: Scene, law: ImpactLaw) -> tuple[Any, Any]:
    """Material and full gap rate after the impact in terms of those before it, as the symbols of RATES."""
    material, full, compliance = RATES
    if multiplied_out(scene.material_rate - scene.gap_rate) == 0:
        material = full
    change = compliance * law.impulse(material, full, compliance)
    return multiplied_out(material - change), multiplied_out(full - change)


def _jump(scene: Scene, law: ImpactLaw) -> Reset:
    # The gap is zero where this happens; its rate afterwards only if the law makes it so identically.
    order = 2 if rates_after(scene, law)[1] == 0 else 1
    rubbed = velocities_after(scene, scene.tangent, friction_impulse(scene, law))
    pushed = velocities_after(scene, scene.normal, impulse(scene, law))
    jump = rubbed | {rate: after.xreplace(rubbed) for rate, after in pushed.items()}
    return Reset(jump, {scene.gap: order, -scene.gap: order})
