"""`fl.animate`: the mechanism of any model that has one, and its phase plane, in slow motion."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.animation import FuncAnimation, HTMLWriter, writers
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from frictionlab.analysis.motion_scales import round_down_1_2_5
from frictionlab.file_writing import name_written_file, write_file
from frictionlab.interruption import progress_bar
from frictionlab.models import Model
from frictionlab.models.mechanism import Mechanism
from frictionlab.models.model import MovingSystem
from frictionlab.plotting.appearance import (
    BLACK,
    background,
    figure_size,
    font_size,
    ink,
    marker_size,
    mode_looks,
    rcParams,
)
from frictionlab.plotting.figure import AnimatedFigure, check_figure, legend_below
from frictionlab.plotting.overview import plot_phase_plane
from frictionlab.plotting.time_histories import (
    SAMPLING_RTOL,
    Array,
    Periods,
    Window,
    check_run,
    plot_displacements,
    window_limits,
)
from frictionlab.plotting.turns import turning_angles, within_turn
from frictionlab.validation import abbreviate, check_number, check_path, with_article

from .parts import Parts, parts

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory

DEFAULT_DURATION = 6.0  # seconds that an animation lasts, or somewhat longer, where no speed is given
MAX_FRAMES = 100_000  # of an animation: an hour and more
DEFAULT_WINDOW = Periods(3.0)
FONT_SIZE = 9.0
DPI = 80.0  # an animation in a notebook holds every frame as a picture

FILM_FORMATS = ".gif", ".html", ".htm", ".webp", ".apng", ".png"  # browsers and pillow write them
FFMPEG_FORMATS = ".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm"


@dataclass(frozen=True, eq=False)
class HistoryPicture:
    """The coordinates, or states, of a run against time, and the instant, where nothing tells how a system
    looks."""

    run: Trajectory
    t: Array
    note = "time (s)"

    @property
    def coordinate(self) -> str:
        """The coordinate that the phase plane shows."""
        return self.run.automaton.shown_state

    @cached_property
    def x(self) -> Array:
        """That coordinate, (K,)."""
        return self.run(self.t)[:, self.run.names.index(self.coordinate)]

    @cached_property
    def rate(self) -> Array:
        """Its rate, or the state against which the phase plane shows it, (K,)."""
        against = self.run.automaton.drawn_against(self.coordinate)
        return self.run(self.t)[:, self.run.names.index(against)]

    @cached_property
    def mode(self) -> Any:
        """Names of the modes, (K,)."""
        return self.run.modes_at(self.t)

    def handles(self) -> list[Any]:
        """Legend entries: none beside those of the modes."""
        return []

    def draw(self, ax: Axes) -> Any:
        """The line at the instant, before the curves."""
        lines = plot_displacements(self.run, ax, window=(float(self.t[0]), float(self.t[-1])))
        above: Any = next((line.axes for line in lines if line.axes is not ax), ax)
        above.legend(handles=lines, loc="upper right", fontsize=font_size(FONT_SIZE))
        return ax.axvline(self.t[0], color=ink(ax))

    def move(self, artists: Any, frame: int, colour: str | None) -> list[Artist]:
        """Put the line where it is in a frame."""
        artists.set_xdata([self.t[frame]] * 2)
        return [artists]


Picture: TypeAlias = Parts | HistoryPicture


def mechanism_of(run: Trajectory, function: str) -> Mechanism | None:
    """The mechanism of the model of a run; None where nothing tells what the system looks like.

    Raises
    ------
    TypeError
        If `run` is not a Trajectory.
    ValueError
        For a run of a structure.
    """
    check_run(run)
    source = run.source
    if isinstance(source, MovingSystem):
        raise ValueError(
            f"{function} needs a run of a model or an automaton, got one of {with_article(type(source))}, "
            "whose matrices do not tell what it looks like: take fl.plot_run(run)"
        )
    return source.mechanism if isinstance(source, Model) else None


def picture_of(run: Any, mechanism: Mechanism | None, t: Array, magnify: float | None = None) -> Picture:
    """The mechanism of a run, or its time history, at times `t` (K,)."""
    if mechanism is not None:
        return parts(run, mechanism, t, magnify)
    return HistoryPicture(run, t)


@dataclass(frozen=True, eq=False)
class AnimationScene:
    """What is drawn in the frames, and the artists that show it; `x` (K,) is that of the phase plane."""

    picture: Picture
    x: Array
    colours: dict[str, str]
    artists: Any
    phase: Any
    title: Any


def animate(
    run: Trajectory,
    *,
    window: Window = DEFAULT_WINDOW,
    speed: float | None = None,
    fps: float = 20.0,
    magnify: float | None = None,
    figure: Figure | None = None,
) -> RunAnimation:
    """Animate a run: the model's mechanism, coloured by mode, with the contact forces and the phase plane.

    Dampers are left out.  Displacements and the travel of a belt are magnified, angles are not.  Where
    nothing tells what the system looks like, as for an automaton, the time history takes the place of the
    mechanism.

    Parameters
    ----------
    run : Trajectory
        Of any model of the package, of your own, which tells its picture in a few lines
        (:class:`~frictionlab.models.Mechanism`), or of an automaton.
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run; by default three periods.
    speed : float or None
        Seconds of the run in a second of the animation: 0.05 is twenty times slower than reality.  None makes
        the animation last some six to fifteen seconds.
    fps : float
        Frames a second.
    magnify : float or None
        Factor of the displacements, which the picture states; None makes the largest one well visible.  By a
        large factor bodies are drawn over each other.
    figure : Figure or None
        Where to draw; None makes a new figure that belongs to no window.

    Returns
    -------
    FuncAnimation
        A notebook shows it; ``.to_jshtml()`` and ``.save("run.gif")`` draw its frames.

    Raises
    ------
    ValueError
        For a run of a structure, or of a single state, a window outside the run, or speeds, rates and factors
        that are not above zero.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.2)
    >>> animation = fl.animate(run, window=0.1, speed=0.05, fps=2)
    >>> animation.to_jshtml().count("data:image/png")
    5
    """
    mechanism = mechanism_of(run, "animate")
    start, stop = window_limits(run, window)
    fps = check_number("fps", fps, above=0.0, cure="give the frames of a second")
    if magnify is not None:
        magnify = check_number("magnify", magnify, above=0.0, cure="leave it out to see displacements well")
    usual = round_down_1_2_5((stop - start) / DEFAULT_DURATION)
    slow = usual if speed is None else check_number("speed", speed, above=0.0, cure="leave it out for ten s")
    frames = (stop - start) * fps / slow
    check_number("the number of frames", frames, most=MAX_FRAMES, cure="lower fps, or take a shorter window")
    check_figure(figure)
    size = figure_size(11.0, 5.6)
    figure = AnimatedFigure(figsize=size, dpi=DPI, layout="constrained") if figure is None else figure
    picture = picture_of(run, mechanism, frame_times(start, stop, slow / fps), magnify)
    scene = _build_scene(run, figure, picture)
    update = frame_updater(scene, slow)
    moving_artists = update(0)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # nothing that moves changes the layout
    if isinstance(figure, AnimatedFigure):
        figure.moving_artists = moving_artists
    count = len(picture.t)
    return RunAnimation(figure, update, count, fps)


def frame_times(start: float, stop: float, step: float) -> Array:
    """Times of the frames: from `start` in steps of `step`, as far as `stop`."""
    return np.minimum(start + step * np.arange(int((stop - start) / step * (1 + SAMPLING_RTOL)) + 1), stop)


def _build_scene(run: Trajectory, figure: Figure, picture: Picture) -> AnimationScene:
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    colours = {name: look.colour for name, look in mode_looks(run).items()}
    artists = picture.draw(left)
    plot_phase_plane(run, right, name=picture.coordinate, window=(float(picture.t[0]), float(picture.t[-1])))
    dot: dict[str, Any] = {"markersize": marker_size(9.0), "markeredgecolor": background(right)}
    (phase,) = right.plot([], [], "o", color=ink(right), zorder=5, **dot)
    _draw_legend(figure, picture, {name: colours[name] for name in colours if name in picture.mode})
    left.set_xlabel(picture.note, fontsize=font_size(FONT_SIZE))
    # At a fixed height, as otherwise the title would move with each draw.
    title = left.set_title("", y=1.0, fontsize=font_size(FONT_SIZE + 2))
    x = within_turn(picture.x) if picture.coordinate in turning_angles(run.automaton) else picture.x
    return AnimationScene(picture, x, colours, artists, phase, title)


def _draw_legend(figure: Figure, picture: Picture, colours: dict[str, str]) -> None:
    modes = [Patch(facecolor=colour, edgecolor=ink(), label=name) for name, colour in colours.items()]
    legend_below(figure, [*modes, *picture.handles()], font_size(FONT_SIZE))


def frame_updater(scene: AnimationScene, speed: float) -> Callable[[int], list[Artist]]:
    """The function that shows a frame of the picture."""
    picture = scene.picture
    step = float(picture.t[1] - picture.t[0]) if len(picture.t) > 1 else 1.0
    digits = max(0, int(np.ceil(-np.log10(step))))
    pace = f"{1 / speed:.3g} times slower" if speed < 1 else f"{speed:.3g} times faster"
    pace = "real time" if speed == 1 else pace

    def update(frame: int) -> list[Artist]:
        mode = str(picture.mode[frame])
        artists = picture.move(scene.artists, frame, scene.colours.get(mode))
        scene.phase.set_data([scene.x[frame]], [picture.rate[frame]])
        scene.phase.set_markerfacecolor(scene.colours.get(mode, BLACK))
        scene.title.set_text(f"t = {picture.t[frame]:.{digits}f} s: {mode}; {pace}")
        return [*artists, scene.phase, scene.title]

    return update


def check_film_path(name: str, value: Any) -> Path:
    """The path of a film, of a format that can be written here."""
    path = check_path(name, value, FILM_FORMATS + FFMPEG_FORMATS)
    if path.suffix.lower() in FFMPEG_FORMATS and not _has_ffmpeg():
        raise ValueError(
            f"{name} must end in {' or '.join(FILM_FORMATS)} where there is no ffmpeg, got "
            f"{abbreviate(str(value))}: pip install imageio-ffmpeg, or write {path.stem}{FILM_FORMATS[0]}"
        )
    return path


def _has_ffmpeg() -> bool:
    """Whether matplotlib finds ffmpeg, which the package imageio-ffmpeg brings too."""
    if not writers.is_available("ffmpeg"):
        with suppress(ImportError):
            rcParams["animation.ffmpeg_path"] = import_module("imageio_ffmpeg").get_ffmpeg_exe()
    return writers.is_available("ffmpeg")


class RunAnimation(FuncAnimation):
    """An animation that shows itself in a notebook, with a bar while its frames are drawn."""

    def __init__(
        self, figure: Figure, update: Callable[[int], list[Artist]], frames: int, fps: float
    ) -> None:
        super().__init__(figure, update, frames=frames, interval=1000.0 / fps, blit=False, repeat=True)
        self.fps = fps

    def save(self, filename: Any, *args: Any, **options: Any) -> None:
        """Write a file; see :meth:`matplotlib.animation.Animation.save`.

        Films such as ``.mp4`` need ffmpeg, of the machine or of the package imageio-ffmpeg.  An HTML page
        embeds all of its frames, unless a writer other than "html" is given.
        """
        if not args and options.get("writer") is None:
            filename = check_film_path("filename", filename)
        if str(filename).lower().endswith((".html", ".htm")) and not args:
            if options.get("writer", "html") != "html":  # its frames may be in a folder beside
                with name_written_file(filename):
                    return self._save(filename, **options)
            fps: Any = options.pop("fps", None) or self.fps
            writer = HTMLWriter(fps=fps, embed_frames=True, embed_limit=float("inf"))
            options["writer"] = writer
        with write_file(filename) as beside:
            self._save(beside, *args, **options)

    def _save(self, filename: Any, *args: Any, **options: Any) -> None:
        if options.get("progress_callback") is not None:
            return super().save(filename, *args, **options)
        with progress_bar(desc="animate") as bar:

            def count(frame: int, total: int) -> None:
                bar.total = total
                bar.update()

            return super().save(filename, *args, **options | {"progress_callback": count})

    def _repr_html_(self) -> str:
        # FuncAnimation's own method shows nothing unless a setting of matplotlib was changed.
        return self.to_jshtml()
