"""`fl.watch`: the animation of a run in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictionlab.analysis.motion_scales import period_of_run, round_down_1_2_5
from frictionlab.models.model import values_of
from frictionlab.pages.scene import scene_data
from frictionlab.plotting.animation.animate import frame_times, mechanism_of
from frictionlab.plotting.time_histories import Periods, Window, window_limits
from frictionlab.validation import check_number

from .front_end import FrontEnd, sampled_run

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory

DEFAULT_WINDOW = Periods(20.0)
FRAMES = 100.0  # frames in a period: 50 a second where a period takes two
MAX_FRAMES = 200_000  # frames: twenty megabytes
SECONDS = 2.0  # seconds that a period takes at first


def watch(
    run: Trajectory,
    *,
    window: Window = DEFAULT_WINDOW,
    speed: float | None = None,
    rate: float | None = None,
    magnify: float | None = None,
) -> FrontEnd:
    """Play a run in a notebook: the picture of :func:`frictionlab.animate`, with play, pause and scrub.

    Parameters
    ----------
    run : Trajectory
        Of any model of the package, of your own, which tells its picture in a few lines
        (:class:`~frictionlab.models.Mechanism`), or of an automaton.
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run; by default twenty periods.
    speed : float or None
        Seconds of the run that are played in a second, at first; the widget offers real time and slow motion.
        None plays about one period in two seconds.
    rate : float or None
        Frames in a second of the run; None makes a hundred in a period of the model.
    magnify : float or None
        Factor of the displacements; None makes the largest one well visible.

    Returns
    -------
    FrontEnd
        An anywidget.

    Raises
    ------
    ValueError
        For a run of a structure, a window outside the run or of more than 200000 frames, or
        factors that are not above zero.

    Examples
    --------
    >>> import frictionlab as fl
    >>> widget = fl.watch(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.5))
    >>> len(widget.picture["samples"]["times"]) // 8
    501
    """
    mechanism = mechanism_of(run, "watch")
    start, stop = window_limits(run, window)
    for name, value in {"speed": speed, "rate": rate, "magnify": magnify}.items():
        if value is not None:
            check_number(name, value, above=0.0)
    period = period_of_run(run)
    rate = FRAMES / period if rate is None else float(rate)
    speed = round_down_1_2_5(period) / SECONDS if speed is None else float(speed)
    count = (stop - start) * rate
    if count > MAX_FRAMES:
        cure = "take a shorter window or a smaller rate"
        raise ValueError(f"window times rate must be at most {MAX_FRAMES} frames, got {count:.0f}: {cure}")
    times = frame_times(start, stop, 1.0 / rate)
    model = run.automaton if run.source is None else run.source
    widget = FrontEnd()
    widget.run = run
    panels = "response" if mechanism is None else "mechanism", "phase"
    widget.scene = scene_data(model, (), panels, period) | {"speed": speed}
    widget.picture = {
        "parameters": dict(values_of(model)),
        "coordinate": run.automaton.shown_state,
        "magnify": magnify,
        "drawings": {},
        "complete": False,
        **sampled_run(run, model, times, *run.states_and_modes(times)),
    }
    return widget
