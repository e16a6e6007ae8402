"""The picture of a run in its frames, of any model that has a mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes

from frictionlab.models import Model
from frictionlab.models.mechanism import Mechanism, TiltingBelt
from frictionlab.plotting.runs.time_window import Array, check_run

from .artists import (
    draw_force_arrows,
    draw_mechanism,
    force_legend_handles,
    force_scale,
    move_force_arrows,
    move_mechanism,
    outlines,
)
from .parts import Parts, parts
from .tilting_belt import Frames, is_tilting_belt, parameters, sample_frames
from .tilting_belt import Mechanism as Sizes
from .tilting_belt import lay_out_mechanism as sizes_of


@dataclass(frozen=True, eq=False)
class BeltPicture:
    """The slider on the tilting belt, with its contact forces and the preload, in K frames."""

    frames: Frames
    sizes: Sizes
    preload: float
    coordinate: str = "x1"

    @property
    def t(self) -> Array:
        """Times (K,)."""
        return self.frames.t

    @property
    def x(self) -> Array:
        """The coordinate that the phase plane shows, (K,)."""
        return self.frames.x1

    @property
    def rate(self) -> Array:
        """Its rate, (K,)."""
        return self.frames.rate

    @property
    def mode(self) -> Any:
        """Names of the modes, (K,)."""
        return self.frames.mode

    @property
    def scale(self) -> float:
        """N per m of the arrows."""
        return force_scale(self.sizes, self.frames, self.preload)

    @property
    def note(self) -> str:
        """A note on the magnification."""
        return f"displacements × {self.sizes.magnify:g}, tilt as it is"

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The picture's edges in x and in y."""
        return self.sizes.limits

    def outlines(self, frame: int) -> list[Array]:
        """Lines (2, P) of all that moves in a frame."""
        return outlines(self.sizes, frame)

    def handles(self) -> list[Any]:
        """Legend entries of the forces."""
        return force_legend_handles(self.frames, self.preload)

    def draw(self, ax: Axes) -> tuple[dict[str, Any], Any]:
        """The artists, as they are in the first frame: the moving parts, and the arrows."""
        return draw_mechanism(ax, self.sizes), draw_force_arrows(ax, self.scale)

    def move(self, artists: Any, frame: int, colour: str | None) -> list[Artist]:
        """Put the artists where they are in a frame, the slider in the colour of its mode."""
        bodies, arrows = artists
        moved = move_mechanism(bodies, self.sizes, frame, colour)
        move_force_arrows(arrows, self.sizes, self.frames, self.preload, frame)
        return [*moved, arrows]


def mechanism_of(run: Any, function: str) -> Mechanism | TiltingBelt:
    """The mechanism of the model of a run.

    Raises
    ------
    TypeError
        For what is no run.
    ValueError
        If the model has no mechanism.
    """
    check_run(run)
    source = run.source
    if isinstance(source, Model) and source.mechanism is not None:
        return source.mechanism
    if source is None and is_tilting_belt(run):  # of the model's automaton alone
        return TiltingBelt()
    of = type(run.automaton if source is None else source).__name__
    raise ValueError(
        f"{function} needs a run of a model that has a mechanism, got one of a {of}: give the model a "
        "property `mechanism` (frictionlab.models.Mechanism), or use the panels of frictionlab.plotting"
    )


def picture_of(
    run: Any, mechanism: Mechanism | TiltingBelt, t: Array, magnify: float | None = None
) -> BeltPicture | Parts:
    """The mechanism of a run at times `t` (K,); ``magnify=None`` makes the largest displacement well
    visible."""
    if isinstance(mechanism, Mechanism):
        return parts(run, mechanism, t, magnify)
    seen, p = sample_frames(run, t), parameters(run)
    return BeltPicture(seen, sizes_of(seen, v=p["v"], l1=p["l1"], l2=p["l2"], magnify=magnify), p["F"])
