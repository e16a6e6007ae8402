"""Contact forces on the slider, and the preload, as arrows."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.quiver import Quiver

from .frames import Frames
from .mechanism import Mechanism
from .palette import BLACK, BLUE, VERMILLION

COLOURS = (BLUE, VERMILLION, BLACK)  # F_N, F_T, F
LONGEST = 0.9  # as a share of the mechanism's size


def newtons_per_metre(mechanism: Mechanism, frames: Frames, preload: float) -> float:
    """Scale at which the largest force is drawn with the length LONGEST."""
    forces = np.abs([frames.normal_force, frames.friction_force]).max()
    return max(float(forces), abs(preload)) / (LONGEST * mechanism.size) or 1.0


def draw_forces(ax: Axes, scale: float) -> Quiver:
    """The arrows of normal force, friction force and preload; `point` gives them place and length.

    Parameters
    ----------
    ax : Axes
    scale : float
        N per m of the picture.
    """
    options: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "minlength": 0.0, "zorder": 5}
    width: dict[str, Any] = {"units": "dots", "width": 4.0, "edgecolor": "white", "linewidth": 0.7}
    return ax.quiver(
        [0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3, color=COLOURS, scale=scale, **width, **options
    )


def point(arrows: Quiver, mechanism: Mechanism, frames: Frames, preload: float, frame: int) -> None:
    """The arrows in a frame: contact forces from the slider's centre, the preload down onto its top."""
    row = mechanism.row(frame)
    width, height = mechanism.block
    x, y = row["slider_x"], row["slider_y"]
    normal, friction = frames.normal_force[frame], frames.friction_force[frame]
    top = y + height + preload / float(arrows.scale or 1.0)
    arrows.set_offsets([(x, y + height / 2), (x, y + height / 2), (x + 0.35 * width, top)])
    # A force that is zero is no arrow at all, not one of length zero.
    absent = np.array([normal, friction, preload]) == 0.0
    arrows.set_UVC(*(np.ma.array(x, mask=absent) for x in ([0.0, friction, 0.0], [normal, 0.0, -preload])))


def force_handles(frames: Frames, preload: float) -> list[Line2D]:
    """Legend entries of the arrows, with the largest size that each has in the frames."""
    sizes = np.abs(frames.normal_force).max(), np.abs(frames.friction_force).max()
    texts = [f"{name}, up to {size:.0f} N" for name, size in zip(("$F_N$", "$F_T$"), sizes)]
    texts.append(f"$F$ = {preload:.4g} N")
    return [Line2D([], [], color=c, linewidth=3.0, label=text) for c, text in zip(COLOURS, texts)]
