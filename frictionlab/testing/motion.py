"""What holds in every motion with dry friction and unilateral contact."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.hybrid.trajectory import Trajectory

POINTS = 400
SIGNS = {"slip+": 1.0, "slip-": -1.0}
LIMIT = 1e-9
NAMES = ("gap", "normal_force", "friction_force", "relative_velocity")


def violations(run: Trajectory) -> dict[str, float]:
    """Worst violation of each rule as a share of its scale, for those that are violated.

    Looked at on a grid, at the steps and just after every event.  Which rules there are depends on the
    outputs and the names of the modes: v_r = 0 in stick, v_r of the mode's sign in slip, friction along it,
    F_N >= 0 and gap >= 0 in contact, gap <= 0 and no force in flight (where there is a flight).
    """
    t = np.unique(np.concatenate([np.linspace(0.0, run.t[-1], POINTS), run.t, run.events.t]))
    modes = np.array(run.automaton.names)[run._modes_of(t, run._step_of(t))]
    if not np.isfinite(run(t)).all():
        return {"every state is a number": np.inf}
    known = [name for name in NAMES if all(name in mode.outputs for mode in run.automaton.modes)]
    values = {name: run.output(name, t) for name in known}
    return {rule: worst for rule, worst in _rules(run, modes, values) if not worst <= LIMIT}


def _rules(run: Trajectory, modes: Any, values: dict[str, Any]) -> Any:
    unilateral, flight = "separation" in run.automaton.names, modes == "separation"
    for name, value in values.items():
        yield f"{name} is a number", 0.0 if np.isfinite(value).all() else np.inf
    if "relative_velocity" in values:
        # Where contact is bilateral, friction turns round with F_N.
        friction = values.get("friction_force") if unilateral else None
        yield from _sliding(modes, values["relative_velocity"], friction)
    if unilateral and "gap" in values:
        gap, scale = values["gap"], _scale(values["gap"])
        yield "gap <= 0 in flight", (gap[flight] / scale).max(initial=0.0)
        yield "gap >= 0 in contact", (-gap[~flight] / scale).max(initial=0.0)
    if unilateral and "normal_force" in values:
        force, scale = values["normal_force"], _scale(values["normal_force"])
        yield "no normal force in flight", np.abs(force[flight]).max(initial=0.0)
        yield "F_N >= 0 in contact", (-force[~flight] / scale).max(initial=0.0)


def _sliding(modes: Any, v_r: Any, friction: Any) -> Any:
    scale, stick = _scale(v_r), modes == "stick"
    yield "v_r = 0 in stick", np.abs(v_r[stick] / scale).max(initial=0.0)
    for name, sign in SIGNS.items():
        slip = modes == name
        yield f"v_r has the sign of {name}", (-sign * v_r[slip] / scale).max(initial=0.0)
        if friction is not None:
            yield (
                f"friction has the sign of {name}",
                (-sign * friction[slip] / _scale(friction)).max(initial=0.0),
            )


def _scale(values: Any) -> float:
    return float(np.abs(values).max(initial=0.0)) or 1.0
