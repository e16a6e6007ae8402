"""`fl.watch`: the animation of a run as a live canvas in a notebook."""

from __future__ import annotations

from importlib import resources
from typing import TYPE_CHECKING, Any

import anywidget
import numpy as np
import traitlets

from frictionlab.analysis.motion_scales import oscillation_period, rounded_period
from frictionlab.plotting.animation.animate import BeltPicture, frame_times, mechanism_of, picture_of
from frictionlab.plotting.animation.parts import MARKS, WIDTH, Parts
from frictionlab.plotting.animation.tilting_belt import COLUMNS, FORCE_COLOURS, SPRING_LABELS, belt_colour
from frictionlab.plotting.appearance import GREY, background, ink, legible, mode_colours
from frictionlab.plotting.time_histories import Periods, Window, window_limits
from frictionlab.presentation import state_unit
from frictionlab.validation import check_number

from .panels.picture import theme
from .sound import listen

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory
    from frictionlab.widgets.result import Result

DEFAULT_WINDOW = Periods(20.0)
FRAMES = 100.0  # frames in a period: 50 a second where a period takes two
MAX_FRAMES = 200_000  # frames: ten megabytes
SECONDS = 2.0  # seconds that a period takes at first
BELT = (*COLUMNS, "normal_force", "friction_force", "x1", "rate", "mode")
SUBSCRIPTS = str.maketrans("0123456789'", "₀₁₂₃₄₅₆₇₈₉′")

# Controls that can be seen on any background, in the font of the page.
CSS = """
.fl-canvas :is(button, select) { font: inherit; color: inherit; background: transparent;
  border: 1px solid #808080; border-radius: 3px; padding: 0.25em 0.6em; }
.fl-canvas option { color: black; background: white; }
.fl-canvas button:disabled { opacity: 0.5; }
"""


class Canvas(anywidget.AnyWidget):
    """A picture that plays in the browser: it gets its data in one message and asks Python for sound only.

    Attributes
    ----------
    scene : dict
        Sizes, colours and texts.
    rows : bytes
        32-bit floats (K, columns): what moves, in K frames.
    plays : bool
        Whether it plays as soon as it is shown, unless the reader's system asks for reduced motion.
    follows : bool
        Whether it shows the instant that the explorer's other mechanism shows, and has no clock of its own.
    run : Trajectory
        The run that is shown, and heard.
    """

    _esm = "".join(
        resources.files(package).joinpath(name).read_text(encoding="utf-8")
        for package, name in (
            ("frictionlab.plotting.animation", "drawing.js"),
            ("frictionlab.widgets", "canvas.js"),
        )
    )
    _css = CSS
    scene = traitlets.Dict().tag(sync=True)
    rows = traitlets.Bytes().tag(sync=True)
    plays = traitlets.Bool(False).tag(sync=True)
    follows = traitlets.Bool(False).tag(sync=True)

    def __init__(self, **traits: Any) -> None:
        super().__init__(**traits)
        self.run: Any = None
        self.on_msg(self._heard)

    def show(self, run: Trajectory, scene: dict[str, Any], rows: bytes) -> None:
        """Show a run; the browser gets all of it in one message."""
        self.run = run
        with self.hold_sync():
            self.scene, self.rows = scene, rows

    def _heard(self, *_: Any) -> None:
        """Send what the run sounds like, or why it makes no sound."""
        try:
            sound = listen(self.run)
        except ValueError as error:
            self.send({"text": str(error)})
            return
        silent = not sound.samples.any()
        text = "it makes no sound" if silent else f"{sound.signal}, {sound.pitch:.3g} times as high as it is"
        samples = np.round(sound.samples * np.iinfo(np.int16).max).astype("<i2")
        self.send({"text": text, "rate": sound.rate}, [samples.tobytes()])


class MovingMechanism:
    """A panel of an explorer: the mechanism in motion, over the part of the run that is shown.

    Attributes
    ----------
    canvas : Canvas

    Parameters
    ----------
    kept : str
        For the mechanism of a kept scene: what is shown beside its time.  It then follows the explorer's
        other mechanism.
    """

    name = "mechanism"

    def __init__(self, title: str = "") -> None:
        self._title = title
        canvas = Canvas(plays=True, follows=bool(title))
        self.canvas = canvas.add_class("fl-panel").add_class("fl-panel-mechanism")

    def show(self, result: Result, dark: bool) -> None:
        """Show the end of what a result shows, at most twenty periods, on a page that is dark or light."""
        run, times = result.run, result.times()
        mechanism = mechanism_of(run, "the panel mechanism")
        rate, period = FRAMES / oscillation_period(result.model), rounded_period(result.model)
        stop = float(times[-1])
        start = max(float(times[0]), stop - DEFAULT_WINDOW.count * period)
        picture = picture_of(run, mechanism, frame_times(start, stop, 1.0 / rate))
        with theme(dark):
            scene, rows = frame_data(run, picture, rate, period / SECONDS)
        scene["title"] = self._title
        self.canvas.show(run, scene, rows)


def watch(
    run: Trajectory,
    *,
    window: Window = DEFAULT_WINDOW,
    speed: float | None = None,
    rate: float | None = None,
    magnify: float | None = None,
) -> Canvas:
    """Play a run in a notebook: the picture of :func:`frictionlab.animate`, with play, pause and scrub.

    Parameters
    ----------
    run : Trajectory
        Of a model that has a `mechanism`: any model of the package, or one of your own with a few lines for
        its picture (:class:`~frictionlab.models.Mechanism`).
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run; by default twenty periods.
    speed : float or None
        Seconds of the run that are played in a second, at first; the canvas offers real time and slow motion.
        None plays about one period in two seconds.
    rate : float or None
        Frames in a second of the run; None makes a hundred in a period of the model.
    magnify : float or None
        Factor of the displacements; None makes the largest one well visible.

    Returns
    -------
    Canvas
        An anywidget.

    Raises
    ------
    ValueError
        For a run of a model without a mechanism, a window outside the run or of more than 200000 frames, or
        factors that are not above zero.

    Examples
    --------
    >>> import frictionlab as fl
    >>> canvas = fl.watch(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.5))
    >>> len(canvas.rows) // 4 // len(canvas.scene["columns"])
    501
    """
    mechanism = mechanism_of(run, "watch")
    start, stop = window_limits(run, window)
    for name, value in {"speed": speed, "rate": rate, "magnify": magnify}.items():
        if value is not None:
            check_number(name, value, above=0.0)
    rate = FRAMES / oscillation_period(run.source) if rate is None else float(rate)
    speed = rounded_period(run.source) / SECONDS if speed is None else speed
    count = (stop - start) * rate
    if count > MAX_FRAMES:
        cure = "take a shorter window or a smaller rate"
        raise ValueError(f"window times rate must be at most {MAX_FRAMES} frames, got {count:.0f}: {cure}")
    picture = picture_of(run, mechanism, frame_times(start, stop, 1.0 / rate), magnify)
    canvas = Canvas()
    canvas.show(run, *frame_data(run, picture, rate, speed))
    return canvas


def frame_data(
    run: Trajectory, picture: BeltPicture | Parts, rate: float, speed: float
) -> tuple[dict[str, Any], bytes]:
    """The scene and the rows of a picture whose frames are 1 / rate apart."""
    colours = mode_colours(run)
    scene, rows = _belt(picture) if isinstance(picture, BeltPicture) else _parts(picture)
    scene |= _labels_and_colours(picture, colours) | {"note": picture.note, "speed": speed}
    scene |= {"start": float(picture.t[0]), "step": 1.0 / rate}
    scene["digits"] = max(0, int(np.ceil(np.log10(rate))))
    places = {mode: float(i) for i, mode in enumerate(colours)}
    modes = [places[mode] for mode in picture.mode.tolist()]
    return scene, np.column_stack([*rows, modes]).astype("<f4").tobytes()


def _belt(picture: BeltPicture) -> tuple[dict[str, Any], list[Any]]:
    """Sizes of the slider on the tilting belt, and its columns except the mode."""
    names = ("size", "wheels", "radius", "block", "spring", "walls", "anchor", "limits", "reach")
    scene = {name: getattr(picture.layout, name) for name in names} | {"columns": BELT}
    scene |= {
        "scale": picture.scale,
        "preload": picture.preload,
        "force_colours": [*map(legible, FORCE_COLOURS)],
    }
    scene |= {"names": {name: aside for name, (_, aside) in SPRING_LABELS.items()}}
    frames = picture.frames
    return scene, [picture.layout.rows, frames.normal_force, frames.friction_force, frames.x1, frames.rate]


def _parts(picture: Parts) -> tuple[dict[str, Any], list[Any]]:
    """The shapes of a mechanism, each with its first column, and all columns except the mode."""
    shapes, columns = [], []
    for i, shape in enumerate(picture.shapes):
        shapes.append({"kind": shape.kind, "colour": legible(shape.colour), "first": len(columns)})
        columns += [f"{shape.kind}{i}.{j}" for j in range(shape.rows.shape[1])]
    scene = {"shapes": shapes, "limits": picture.limits, "width": WIDTH, "marks": MARKS}
    scene |= {"columns": (*columns, picture.coordinate, "rate", "mode")}
    return scene, [*(shape.rows for shape in picture.shapes), picture.x, picture.rate]


def _labels_and_colours(picture: BeltPicture | Parts, colours: dict[str, str]) -> dict[str, Any]:
    """Colours; the legend, modes that occur and then forces; the labels of the phase plane."""
    legend = [(name, colour) for name, colour in colours.items() if name in picture.mode]
    forces = [(str(h.get_label()).replace("$", ""), h.get_color()) for h in picture.handles()]
    labels = (
        f"{n.translate(SUBSCRIPTS)} ({state_unit(n)})" for n in (picture.coordinate, picture.coordinate + "'")
    )
    return {
        "modes": list(colours),
        "colours": list(colours.values()),
        "line_colours": [*map(legible, colours.values())],
        "paper": background(),
        "ink": ink(),
        "grey": legible(GREY),
        "pale": belt_colour(),
        "legend": [*legend, *forces],
        "axes": [picture.coordinate, *labels],
    }
