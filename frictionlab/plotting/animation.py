"""`fl.animate`: the slider on the tilting belt, and its phase plane, in slow motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.quiver import Quiver

from frictionlab.hybrid.validation import check_number

from .arrows import draw_forces, force_handles, newtons_per_metre, point
from .draw_mechanism import draw_mechanism, move
from .frames import Frames, frames, parameters, refuse_others
from .mechanism import Mechanism, mechanism, round_down
from .moving import MovingFigure, RunAnimation
from .palette import BLACK, mode_colours
from .phase_plane import plot_phase_plane
from .windows import Array, Window, limits

SECONDS = 6.0  # that an animation lasts, or somewhat longer, where no speed is given
LAST = 0.3  # seconds of the run: some three oscillations of the paper's system
SMALL = 9.0
DPI = 80.0  # an animation in a notebook holds every frame as a picture


@dataclass(frozen=True, eq=False)
class Scene:
    """What is drawn in the frames, and the artists that show it."""

    frames: Frames
    mechanism: Mechanism
    preload: float
    colours: dict[str, str]
    parts: dict[str, Any]
    arrows: Quiver
    phase: Any
    title: Any


def animate(
    run: Any,
    *,
    window: Window = LAST,
    speed: float | None = None,
    fps: float = 20.0,
    magnify: float | None = None,
    figure: Figure | None = None,
) -> RunAnimation:
    """Animate a run: slider, springs and belt, coloured by mode, with the contact forces and the phase plane.

    The slider stands on its contact spring (k2, k_nl) on the belt, which k4, k5 and k6 hold; dampers are left
    out.  Forces are those on the slider.  Displacements and the belt's way are magnified, its tilt is not.

    Parameters
    ----------
    run : Trajectory
        Of a :class:`SliderOnBelt`.
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run.
    speed : float or None
        Seconds of the run in a second of the animation: 0.05 is twenty times slower than reality.  None makes
        it last some six to fifteen seconds.
    fps : float
        Frames a second.
    magnify : float or None
        Factor of the displacements; None makes the largest well seen.  It stands in the picture.
    figure : Figure or None
        Where to draw; None makes a new figure that belongs to no window.

    Returns
    -------
    FuncAnimation
        A notebook shows it; ``.to_jshtml()`` and ``.save("run.gif")`` draw its frames.

    Raises
    ------
    ValueError
        For a run of anything else than a slider on a belt, a window outside the run, or speeds, rates and
        factors that are not above zero.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.2)
    >>> animation = fl.animate(run, window=0.1, speed=0.05, fps=2)
    >>> animation.to_jshtml().count("data:image/png")
    5
    """
    refuse_others(run, "animate")
    start, stop = limits(run, window)
    for name, value in {"speed": speed, "fps": fps, "magnify": magnify}.items():
        if value is not None:
            check_number(name, value, above=0.0)
    speed = speed or round_down((stop - start) / SECONDS)
    figure = MovingFigure(figsize=(11.0, 5.6), dpi=DPI, layout="constrained") if figure is None else figure
    scene = _scene(run, figure, frame_times(start, stop, speed / fps), magnify)
    update = show_frame(scene, speed)
    moving = update(0)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # nothing that moves changes the layout
    if isinstance(figure, MovingFigure):
        figure.moving = moving
    count = len(scene.frames.t)
    return RunAnimation(figure, update, frames=count, interval=1000.0 / fps, blit=False, repeat=True)


def frame_times(start: float, stop: float, step: float) -> Array:
    """Times of the frames, both ends of the window as far as the step allows."""
    return np.minimum(start + step * np.arange(int((stop - start) / step * (1 + 1e-12)) + 1), stop)


def _scene(run: Any, figure: Figure, t: Array, magnify: float | None) -> Scene:
    p, seen = parameters(run), frames(run, t)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    picture = mechanism(seen, v=p["v"], l1=p["l1"], l2=p["l2"], magnify=magnify)
    colours = mode_colours(run.automaton.names)
    parts = draw_mechanism(left, picture)
    arrows = draw_forces(left, newtons_per_metre(picture, seen, p["F"]))
    plot_phase_plane(run, right, window=(float(t[0]), float(t[-1])))
    (phase,) = right.plot([], [], "o", color=BLACK, markersize=9.0, markeredgecolor="white", zorder=5)
    _legends(left, figure, seen, p["F"], {name: colours[name] for name in colours if name in seen.mode})
    left.set_xlabel(f"displacements × {picture.magnify:g}, tilt as it is", fontsize=SMALL)
    # With a height of its own, or each draw without it would move it.
    title = left.set_title("", y=1.0, fontsize=SMALL + 2)
    return Scene(seen, picture, p["F"], colours, parts, arrows, phase, title)


def _legends(ax: Axes, figure: Figure, seen: Frames, preload: float, colours: dict[str, str]) -> None:
    modes = [Patch(facecolor=colour, edgecolor=BLACK, label=name) for name, colour in colours.items()]
    handles = [*modes, *force_handles(seen, preload)]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=SMALL
    )


def show_frame(scene: Scene, speed: float) -> Callable[[int], list[Artist]]:
    """The function that takes the picture to a frame."""
    seen = scene.frames
    step = float(seen.t[1] - seen.t[0]) if len(seen.t) > 1 else 1.0
    digits = max(0, int(np.ceil(-np.log10(step))))
    pace = f"{1 / speed:.3g} times slower" if speed < 1 else f"{speed:.3g} times faster"
    pace = "real time" if speed == 1 else pace

    def update(frame: int) -> list[Artist]:
        mode = str(seen.mode[frame])
        moved = move(scene.parts, scene.mechanism, frame, scene.colours.get(mode))
        point(scene.arrows, scene.mechanism, seen, scene.preload, frame)
        scene.phase.set_data([seen.x1[frame]], [seen.rate[frame]])
        scene.phase.set_markerfacecolor(scene.colours.get(mode, BLACK))
        scene.title.set_text(f"t = {seen.t[frame]:.{digits}f} s: {mode}; {pace}")
        return [*moved, scene.arrows, scene.phase, scene.title]

    return update
