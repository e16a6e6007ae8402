"""Where the parts of Fig. 1 of the paper are drawn in each frame: slider, contact spring, belt, walls.

A run is sampled at the times of the frames.  Displacements are magnified by one factor s; the belt's tilt
is shown as it is.  So the penetration in the picture is s times that of the run: s y2 - (s x1 - s x2) phi
- s y1.  The slider stands on its contact spring, whose foot touches the belt as long as the spring is not
at its natural length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import round_down_1_2_5
from frictionlab.plotting.runs.time_histories import Array, modes_at

SLIDER_COORDINATES = ("x1", "y1", "x2", "y2")
FORCE_OUTPUTS = ("normal_force", "friction_force")
REQUIRED_PARAMETERS = ("v", "F", "l1", "l2")

COLUMNS = ("slider_x", "slider_y", "foot_x", "foot_y", "belt_x", "belt_y", "slope", "travel")
MAX_DISPLACEMENT_SHARE = 0.4  # largest displacement drawn, as a share of the distance of the nearer wheel
MIN_WHEEL_SHARE = 0.25  # of the distance of a wheel drawn, as a share of the other's
DEFAULT_SIZE = 0.2  # m: drawn size of a belt whose wheels are at its centre


@dataclass(frozen=True, eq=False)
class Frames:
    """States and contact forces at K times, in SI units; each array is (K,).

    Parameters
    ----------
    t : time
    x1, y1, x2, y2, phi : coordinates; phi is zero where the belt does not rotate
    rate : x1'
    penetration : positive in contact, negative in flight
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
    penetration: Array
    normal_force: Array
    friction_force: Array
    mode: np.ndarray


def sample_frames(run: Any, t: Array) -> Frames:
    """The frames of a run of a slider on a belt at times `t` (K,)."""
    states = dict(zip(run.names, run(t).T, strict=True))
    states |= {name: run.output(name, t) for name in ("penetration", *FORCE_OUTPUTS)}
    states.setdefault("phi", np.zeros(len(t)))
    shown = {name: states[name] for name in (*SLIDER_COORDINATES, "phi", "penetration", *FORCE_OUTPUTS)}
    return Frames(t=t, rate=states["x1'"], mode=modes_at(run, t), **shown)


def parameters(run: Any) -> dict[str, float]:
    """The run's parameters by name."""
    return {str(symbol): float(value) for symbol, value in run.automaton.parameters.items()}


def is_tilting_belt(run: Any) -> bool:
    """Whether a run has all that the picture of the slider on the tilting belt shows."""
    has = {*run.names, *run.automaton.outputs, *parameters(run)}
    return has >= {*SLIDER_COORDINATES, "x1'", "penetration", *FORCE_OUTPUTS, *REQUIRED_PARAMETERS}


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Sizes of the picture, and where its moving parts are in each of K frames.

    Parameters
    ----------
    size : float
        Distance of the farther wheel, m; the other sizes follow from it.
    wheels : (float, float)
        Distances of the wheels from the belt's centre as drawn, m.
    magnify : float
        Factor s of the displacements.
    spring : float
        Natural length of the contact spring as drawn, m.
    reach : float
        Room for displacements, m.
    rows : (K, 8) array
        The columns COLUMNS: bottom of the slider, foot of the contact spring, point of the belt's surface
        above its centre (all m), slope of the belt (its surface falls to the right for phi > 0), way of the
        belt's surface (m).
    """

    size: float
    wheels: tuple[float, float]
    magnify: float
    spring: float
    reach: float
    rows: Array

    def row(self, frame: int) -> dict[str, float]:
        """Where the moving parts are in a frame, by the names of COLUMNS."""
        return {name: float(value) for name, value in zip(COLUMNS, self.rows[frame])}

    @property
    def radius(self) -> float:
        """Radius of the wheels, m."""
        return 0.2 * self.size

    @property
    def block(self) -> tuple[float, float]:
        """Width and height of the slider, m."""
        return 0.4 * self.size, 0.3 * self.size

    @property
    def walls(self) -> tuple[float, float, float]:
        """Left wall (x), right wall (x) and ground (y), m."""
        left = -(0.2 + 0.8) * self.size - self.reach
        right = self.wheels[1] + 0.7 * self.size + self.reach
        return left, right, -self.radius - 0.8 * self.size - self.reach

    @property
    def anchor(self) -> tuple[float, float]:
        """Fixed end of the spring k3, at 45 degrees above the slider's upper left corner at rest, m."""
        width, height = self.block
        out = 0.6 * self.size + self.reach
        return -width / 2 - out, self.spring + height + out

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The picture's edges in x and in y, m."""
        left, right, ground = self.walls
        margin = 0.15 * self.size
        left = min(left, self.anchor[0], -self.wheels[0] - self.radius - self.reach)
        return (left - margin, right + margin), (ground - margin, self.anchor[1] + 2 * margin)


def lay_out_mechanism(
    frames: Frames, *, v: float, l1: float, l2: float, magnify: float | None = None
) -> Mechanism:
    """Where everything is drawn; ``magnify=None`` makes the largest displacement well visible.

    Parameters
    ----------
    frames : Frames
    v : float
        Speed of the belt, m/s.
    l1, l2 : float
        Distances of the wheels, m.
    magnify : float or None
    """
    size = max(l1, l2) or DEFAULT_SIZE
    wheels = (max(l1, MIN_WHEEL_SHARE * size), max(l2, MIN_WHEEL_SHARE * size))
    room = MAX_DISPLACEMENT_SHARE * min(wheels)
    largest = max(float(np.abs(x).max()) for x in (frames.x1, frames.y1, frames.x2, frames.y2))
    s = magnify if magnify is not None else round_down_1_2_5(room / largest) if largest > 0 else 1.0
    spring = max(0.6 * size, 1.3 * s * float(frames.penetration.max()))
    rows = _part_positions(frames, s, spring, s * v * (frames.t - frames.t[0]))
    return Mechanism(size, wheels, s, spring, max(room, s * largest), rows)


def _part_positions(frames: Frames, s: float, spring: float, travel: Array) -> Array:
    x1, y1, x2, y2 = s * frames.x1, s * frames.y1, s * frames.x2, s * frames.y2
    surface = y2 - (x1 - x2) * frames.phi
    # Bilateral contact pulls where the penetration is negative: only in flight is there no contact.
    foot = np.where(frames.mode == "separation", y1, surface)
    return np.column_stack([x1, y1 + spring, x1, foot, x2, y2, -frames.phi, travel])
