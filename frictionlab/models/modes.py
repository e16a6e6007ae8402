"""The modes of a scene: what flows, what guards it, and where it leads."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import sympy

from frictionlab.automaton import Event, Mode

from .resets import impact, projection
from .scene import Scene

# The modes tried first after an event, in this order, as far as the model's interface has them.
AFTER_SLIP = {"slip+": ("stick", "slip-"), "slip-": ("stick", "slip+")}
AFTER_FLIGHT = ("slip+", "slip-", "slip", "stick")


def build(scene: Scene, name: str) -> Mode:
    """The mode of that name.

    Raises
    ------
    ValueError
        If there is no such mode.
    """
    if name not in BUILDERS:
        raise ValueError(f"no mode is called {name!r}: an interface may list {', '.join(BUILDERS)}")
    return BUILDERS[name](scene)


def friction_force(scene: Scene, name: str) -> Any:
    """F_T of a mode in contact, Eq. (3), and in stick from the constraint of Eq. (5)."""
    if name == "stick":
        return sticking_force(scene, scene.normal_force)
    sign = sympy.sign(scene.model.v) if name == "slip" else (1 if name == "slip+" else -1)
    return sign * scene.model.friction.kinetic(scene.normal_force, sign * scene.relative_velocity)


def _sliding(scene: Scene, name: str) -> Mode:
    """Sliding in one direction, Eqs. (1) to (4)."""
    sign = 1 if name == "slip+" else -1
    event = Event("v_r", sign * scene.relative_velocity, _known(scene, AFTER_SLIP[name]), projection(scene))
    return _mode(scene, name, _accelerations(scene, name), (event, *_leaving(scene)))


def _sliding_on(scene: Scene) -> Mode:
    """Sliding whose friction force keeps its sign: Eqs. (1) to (3) with sgn(v)."""
    return _mode(scene, "slip", _accelerations(scene, "slip"), _leaving(scene))


def _stick(scene: Scene) -> Mode:
    """Sticking, Eqs. (5) to (8): all coordinates are kept, x1'' and x2'' are one expression."""
    friction, limit = (
        sticking_force(scene, scene.normal_force),
        scene.model.friction.static_limit(scene.normal_force),
    )
    r = scene.forces(scene.normal_force)
    accelerations = [force / mass for force, mass in zip(r, scene.mass, strict=True)]
    one, two = _bodies(scene)
    accelerations[one] = accelerations[two] = (r[one] + r[two]) / (scene.mass[one] + scene.mass[two])
    events = (
        Event("cone+", limit - friction, _known(scene, ("slip+",))),
        Event("cone-", limit + friction, _known(scene, ("slip-",))),
    )
    return _mode(scene, "stick", accelerations, events + _leaving(scene), (scene.relative_velocity,))


def _separation(scene: Scene) -> Mode:
    """Flight, Eq. (9): no contact forces; it ends where the gap closes."""
    accelerations = [force / mass for force, mass in zip(scene.forces(0), scene.mass, strict=True)]
    law, plastic = impact(scene)
    event = Event("gap", -scene.gap, _known(scene, AFTER_FLIGHT), law, plastic)
    return _mode(scene, "separation", accelerations, (event,))


def _accelerations(scene: Scene, name: str) -> list[Any]:
    friction = friction_force(scene, name)
    rows = zip(scene.forces(scene.normal_force), scene.tangent, scene.mass, strict=True)
    return [(r + w * friction) / mass for r, w, mass in rows]


def sticking_force(scene: Scene, normal_force: Any) -> Any:
    """F_T in stick: from x1'' = x2'' with M x1'' = r1 + F_T and m x2'' = r2 - F_T, Eqs. (1) and (5)."""
    one, two = _bodies(scene)
    r, (heavy, light) = scene.forces(normal_force), (scene.mass[one], scene.mass[two])
    return (heavy * r[two] - light * r[one]) / (heavy + light)


def _bodies(scene: Scene) -> tuple[int, int]:
    """Indices of the two coordinates between which friction acts: x1 and x2."""
    return scene.tangent.index(1), scene.tangent.index(-1)


def _leaving(scene: Scene) -> tuple[Event, ...]:
    # Bilateral contact is an interface without the mode that a lost contact would lead to.
    targets = _known(scene, ("separation",))
    return (Event("gap", scene.gap, targets),) if targets else ()


def _known(scene: Scene, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name for name in names if name in scene.model.interface.modes)


def _mode(
    scene: Scene,
    name: str,
    accelerations: list[Any],
    events: tuple[Event, ...],
    constraints: tuple[Any, ...] = (),
) -> Mode:
    contact = name != "separation"
    outputs = {
        "gap": scene.gap,
        "normal_force": scene.normal_force if contact else sympy.S.Zero,
        "friction_force": friction_force(scene, name) if contact else sympy.S.Zero,
        "relative_velocity": scene.relative_velocity,
    }
    return Mode(name, (*scene.v, *accelerations), events, constraints, outputs)


BUILDERS: dict[str, Callable[[Scene], Mode]] = {
    "stick": _stick,
    "slip+": partial(_sliding, name="slip+"),
    "slip-": partial(_sliding, name="slip-"),
    "slip": _sliding_on,
    "separation": _separation,
}
