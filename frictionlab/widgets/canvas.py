"""`fl.watch`: the animation of a run as a live canvas in a notebook."""

from __future__ import annotations

from importlib import resources
from typing import Any

import anywidget
import numpy as np
import traitlets

from frictionlab.analysis.motion_scales import oscillation_period, rounded_period
from frictionlab.plotting.animation.animate import BeltPicture, frame_times, mechanism_of, picture_of
from frictionlab.plotting.animation.parts import MARKS, WIDTH, Parts
from frictionlab.plotting.animation.tilting_belt import COLUMNS, FORCE_COLOURS, SPRING_LABELS, belt_colour
from frictionlab.plotting.appearance import background, ink, legible
from frictionlab.plotting.style import GREY, mode_colours
from frictionlab.plotting.time_histories import Periods, Window, window_limits
from frictionlab.presentation import state_unit
from frictionlab.validation import check_number

DEFAULT_WINDOW = Periods(20.0)
FRAMES = 100.0  # frames in a period: 50 a second where a period takes two
MAX_FRAMES = 200_000  # frames: ten megabytes
SECONDS = 2.0  # seconds that a period takes at first
BELT = (*COLUMNS, "normal_force", "friction_force", "x1", "rate", "mode")
SUBSCRIPTS = str.maketrans("0123456789'", "₀₁₂₃₄₅₆₇₈₉′")


class Canvas(anywidget.AnyWidget):
    """A picture that plays in the browser; it is sent its data once and asks for nothing afterwards.

    Attributes
    ----------
    scene : dict
        Sizes, colours and texts.
    rows : bytes
        32-bit floats (K, columns): what moves, in K frames.
    """

    _esm = "".join(
        resources.files(package).joinpath(name).read_text(encoding="utf-8")
        for package, name in (
            ("frictionlab.plotting.animation", "drawing.js"),
            ("frictionlab.widgets", "canvas.js"),
        )
    )
    scene = traitlets.Dict().tag(sync=True)
    rows = traitlets.Bytes().tag(sync=True)


def watch(
    run: Any,
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
        The last so many seconds, from one time to another, or the whole run; by default twenty periods.
    speed : float or None
        Seconds of the run in a second, at first; the canvas offers real time and slow motion.  None takes two
        seconds for about a period.
    rate : float or None
        Frames in a second of the run; None makes a hundred in a period of the model.
    magnify : float or None
        Factor of the displacements; None makes the largest well visible.

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
    rate = FRAMES / oscillation_period(run.source) if rate is None else rate
    speed = rounded_period(run.source) / SECONDS if speed is None else speed
    count = (stop - start) * rate
    if count > MAX_FRAMES:
        cure = "take a shorter window or a smaller rate"
        raise ValueError(f"window times rate must be at most {MAX_FRAMES} frames, got {count:.0f}: {cure}")
    picture = picture_of(run, mechanism, frame_times(start, stop, 1.0 / rate), magnify)
    colours = mode_colours(run)
    scene, rows = _belt(picture) if isinstance(picture, BeltPicture) else _parts(picture)
    scene |= _labels_and_colours(picture, colours) | {"note": picture.note, "speed": speed}
    scene |= {"start": start, "step": 1.0 / rate, "digits": max(0, int(np.ceil(np.log10(rate))))}
    modes = np.array([[*colours].index(mode) for mode in picture.mode], dtype=float)
    return Canvas(scene=scene, rows=np.column_stack([*rows, modes]).astype("<f4").tobytes())


def _belt(picture: BeltPicture) -> tuple[dict[str, Any], list[Any]]:
    """Sizes of the slider on the tilting belt, and its columns but the mode."""
    names = ("size", "wheels", "radius", "block", "spring", "walls", "anchor", "limits", "reach")
    scene = {name: getattr(picture.sizes, name) for name in names} | {"columns": BELT}
    scene |= {
        "scale": picture.scale,
        "preload": picture.preload,
        "force_colours": [*map(legible, FORCE_COLOURS)],
    }
    scene |= {"names": {name: aside for name, (_, aside) in SPRING_LABELS.items()}}
    seen = picture.frames
    return scene, [picture.sizes.rows, seen.normal_force, seen.friction_force, seen.x1, seen.rate]


def _parts(picture: Parts) -> tuple[dict[str, Any], list[Any]]:
    """The shapes of a mechanism, each with the place of its first number, and its columns but the mode."""
    shapes, columns = [], []
    for i, shape in enumerate(picture.shapes):
        shapes.append({"kind": shape.kind, "colour": legible(shape.colour), "first": len(columns)})
        columns += [f"{shape.kind}{i}.{j}" for j in range(shape.rows.shape[1])]
    scene = {"shapes": shapes, "limits": picture.limits, "width": WIDTH, "marks": MARKS}
    scene |= {"columns": (*columns, picture.coordinate, "rate", "mode")}
    return scene, [*(shape.rows for shape in picture.shapes), picture.x, picture.rate]


def _labels_and_colours(picture: BeltPicture | Parts, colours: dict[str, str]) -> dict[str, Any]:
    """Colours and legend: the modes that occur, then the forces; what the phase plane shows."""
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
