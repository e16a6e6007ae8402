"""`fl.watch`: the animation of a run as a live canvas in a notebook."""

from __future__ import annotations

from importlib import resources
from typing import Any

import anywidget
import numpy as np
import traitlets

from frictionlab.hybrid.validation import check_number
from frictionlab.plotting.animation import frame_times
from frictionlab.plotting.arrows import COLOURS, force_handles, newtons_per_metre
from frictionlab.plotting.draw_mechanism import SPRINGS
from frictionlab.plotting.frames import Frames, frames, parameters, refuse_others
from frictionlab.plotting.mechanism import COLUMNS, Mechanism, mechanism
from frictionlab.plotting.palette import mode_colours
from frictionlab.plotting.windows import Window, limits

LAST = 2.0  # seconds of the run
RATE = 1000.0  # frames per second of the run: 50 a second at twenty times slower than real time
MOST = 200_000  # frames: ten megabytes
SLOW = 0.05
ALL_COLUMNS = (*COLUMNS, "normal_force", "friction_force", "x1", "rate", "mode")


class Canvas(anywidget.AnyWidget):
    """A picture that plays in the browser; it is sent its data once and asks for nothing afterwards.

    Attributes
    ----------
    scene : dict
        Sizes, colours and texts.
    rows : bytes
        32-bit floats (K, columns): what moves, in K frames.
    """

    _esm = resources.files("frictionlab.widgets").joinpath("canvas.js").read_text(encoding="utf-8")
    scene = traitlets.Dict().tag(sync=True)
    rows = traitlets.Bytes().tag(sync=True)


def watch(
    run: Any,
    *,
    window: Window = LAST,
    speed: float = SLOW,
    rate: float = RATE,
    magnify: float | None = None,
) -> Canvas:
    """Play a run in a notebook: the picture of :func:`frictionlab.animate`, with play, pause and scrub.

    Parameters
    ----------
    run : Trajectory
        Of a :class:`SliderOnBelt`.
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run.
    speed : float
        Seconds of the run in a second, at first; the canvas offers real time and slow motion.
    rate : float
        Frames in a second of the run.
    magnify : float or None
        Factor of the displacements; None makes the largest well seen.

    Returns
    -------
    Canvas
        An anywidget.

    Raises
    ------
    ValueError
        For a run of anything else than a slider on a belt, a window outside the run or of more than 200000
        frames, or factors that are not above zero.

    Examples
    --------
    >>> import frictionlab as fl
    >>> canvas = fl.watch(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.5))
    >>> len(canvas.rows) // 4 // len(canvas.scene["columns"])
    501
    """
    refuse_others(run, "watch")
    start, stop = limits(run, window)
    for name, value in {"speed": speed, "rate": rate, "magnify": magnify}.items():
        if value is not None:
            check_number(name, value, above=0.0)
    count = (stop - start) * rate
    if count > MOST:
        cure = "take a shorter window or a smaller rate"
        raise ValueError(f"window times rate must be at most {MOST} frames, got {count:.0f}: {cure}")
    p, seen = parameters(run), frames(run, frame_times(start, stop, 1.0 / rate))
    picture = mechanism(seen, v=p["v"], l1=p["l1"], l2=p["l2"], magnify=magnify)
    names = list(run.automaton.names)
    scene = _sizes(picture) | _texts(seen, p["F"], mode_colours(names))
    scene |= {"scale": newtons_per_metre(picture, seen, p["F"]), "preload": p["F"], "speed": speed}
    scene |= {"start": start, "step": 1.0 / rate, "digits": max(0, int(np.ceil(np.log10(rate))))}
    scene["note"] = f"displacements × {picture.magnify:g}, tilt as it is"
    return Canvas(scene=scene, rows=_rows(picture, seen, names))


def _sizes(picture: Mechanism) -> dict[str, Any]:
    names = ("size", "wheels", "radius", "block", "spring", "walls", "anchor", "limits", "reach")
    return {name: getattr(picture, name) for name in names} | {"columns": ALL_COLUMNS}


def _texts(seen: Frames, preload: float, colours: dict[str, str]) -> dict[str, Any]:
    """Colours and legend: the modes that occur, then the forces."""
    legend = [(name, colour) for name, colour in colours.items() if name in seen.mode]
    forces = [str(handle.get_label()).replace("$", "") for handle in force_handles(seen, preload)]
    return {
        "modes": list(colours),
        "colours": list(colours.values()),
        "force_colours": COLOURS,
        "legend": [*legend, *zip(forces, COLOURS)],
        "names": {name: aside for name, (_, aside) in SPRINGS.items()},
    }


def _rows(picture: Mechanism, seen: Frames, names: list[str]) -> bytes:
    codes = np.array([names.index(mode) for mode in seen.mode], dtype=float)
    moving = [seen.normal_force, seen.friction_force, seen.x1, seen.rate, codes]
    return np.column_stack([picture.rows, *moving]).astype("<f4").tobytes()
