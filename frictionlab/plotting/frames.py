"""What a run shows at a number of times: the frames of an animation, and of the canvas in a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .shading import modes_at
from .windows import Array

COORDINATES = ("x1", "y1", "x2", "y2")
FORCES = ("normal_force", "friction_force")
PARAMETERS = ("v", "F", "l1", "l2")


@dataclass(frozen=True, eq=False)
class Frames:
    """States and contact forces at K times, in SI units; each array is (K,).

    Parameters
    ----------
    t : time
    x1, y1, x2, y2, phi : coordinates; phi is zero where the belt does not rotate
    rate : x1'
    gap : compression of the contact, negative in flight
    normal_force, friction_force : on the slider
    mode : names of the modes
    """

    t: Array
    x1: Array
    y1: Array
    x2: Array
    y2: Array
    phi: Array
    rate: Array
    gap: Array
    normal_force: Array
    friction_force: Array
    mode: np.ndarray


def frames(run: Any, t: Array) -> Frames:
    """The frames of a run of a slider on a belt at times `t` (K,)."""
    states = dict(zip(run.names, run(t).T, strict=True))
    states |= {name: run.output(name, t) for name in ("gap", *FORCES)}
    states.setdefault("phi", np.zeros(len(t)))
    shown = {name: states[name] for name in (*COORDINATES, "phi", "gap", *FORCES)}
    return Frames(t=t, rate=states["x1'"], mode=modes_at(run, t), **shown)


def parameters(run: Any) -> dict[str, float]:
    """The run's parameters by name."""
    return {str(symbol): float(value) for symbol, value in run.automaton.parameters.items()}


def is_tilting_belt(run: Any) -> bool:
    """Whether a run has all that the picture of the slider on the tilting belt shows."""
    has = {*run.names, *run.automaton.outputs, *parameters(run)}
    return has >= {*COORDINATES, "x1'", "gap", *FORCES, *PARAMETERS}
