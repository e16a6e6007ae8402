"""The settings of an explorer, as data; results, each computed when first needed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import (
    Spectrum,
    amplitude_spectrum,
    is_at_rest,
    moving_span,
    round_down_1_2_5,
)
from frictionlab.analysis.period_of_motion import oscillation_period
from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import SliderOnBelt
from frictionlab.models.model import MAKE_ONE, automaton_of
from frictionlab.pages.scene import (
    BEGINNING,
    WHAT_MOVES,
    Shown,
    shown_model,
    usual_duration,
)
from frictionlab.stability import Eigenvalues, eigenvalues
from frictionlab.validation import check_t_end

SHOWN_PERIODS = 10  # of the model: 1 s of the slider on a belt

# Under Eq. (13) flights of the slider that are shorter than a third of the distance between two samples are
# replaced by their limit.  Displacements are then right to some 1e-5 of the motion; rates, which zigzag in
# flight, to less than a pixel; and the run is ten times as fast.  The error of the tolerance is below 1e-5 of
# the motion over 20 s, far less than a pixel; its shorter series save some 25 % of the time where events cut
# steps short.
Array = NDArray[np.float64]

QUICK_METHOD = Taylor(tol=1e-7, chatter=4e-4)
PERIODICITY_TOLERANCE = 1e-10  # tolerance of runs that are tested for whether the motion repeats

MAX_STEPS = 300_000  # 100 s of the paper's system with all its chatter take 200 000 steps
SAMPLES_PER_PERIOD, MIN_SAMPLES, MAX_SAMPLES = 40, 800, 20_000  # samples of what is shown
MAX_EVENTS = 1000  # events of what is shown: with more, their jumps are not seen
STEADY = 0.95  # a motion that keeps less than this share of its size over half a run decays


@dataclass(frozen=True)
class Settings:
    """A model, how it is run, and what is shown of it.

    Parameters
    ----------
    model : Model or HybridAutomaton
    t_end : float
        Seconds that are simulated.
    x0 : str or tuple of float
        As :func:`frictionlab.simulate` takes it.
    method : Method
    window : float, "moving", "beginning" or None
        Seconds at the end that are shown.  None shows the whole run; "beginning" the first ten periods;
        "moving" the last ten or, if nothing moves in them, the run from its start until shortly after it came
        to rest.
    coordinate : str
        The coordinate of phase plane and spectrum.
    period : float
        Approximate period (s) that the model states, or else of that with which the explorer began.
    """

    model: Shown
    t_end: float
    x0: str | tuple[float, ...]
    method: Method
    window: float | str | None
    coordinate: str
    period: float


def starting_settings(model: object, x0: Any = "rest", t_end: float | None = None) -> Settings:
    """The initial settings of an explorer; the length of a run follows from the model's own time scale.

    Raises
    ------
    TypeError
        If `model` is neither a model nor a structure nor an automaton; None is the paper's.
    ValueError
        For a bad `x0` or `t_end`.
    """
    shown, start = shown_model(SliderOnBelt() if model is None else model, x0, MAKE_ONE)
    period = oscillation_period(shown, start)
    seconds = usual_duration(shown, period) if t_end is None else float(check_t_end(t_end))
    return Settings(shown, seconds, start, QUICK_METHOD, WHAT_MOVES, automaton_of(shown).shown_state, period)


@cache  # methods never change
def limit_steps(method: Method) -> Method:
    """The method with at most MAX_STEPS steps: a motion that grows without bounds takes ever shorter ones."""
    return replace(method, max_steps=MAX_STEPS) if isinstance(method, Taylor) else method


def tighten_tolerance(method: Method) -> Method:
    """The method with a tolerance small enough to recognise that a motion repeats."""
    return (
        replace(method, tol=min(method.tol, PERIODICITY_TOLERANCE)) if isinstance(method, Taylor) else method
    )


class Result:
    """The run, the equilibrium and its eigenvalues for one setting.

    Attributes
    ----------
    settings : Settings
    model : Model or HybridAutomaton
    run : Trajectory
    eigenvalues : Eigenvalues or None
        With the equilibrium; None where there is none.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings, self.model = settings, settings.model
        self._period = round_down_1_2_5(settings.period)  # of which the shown part is a multiple, s

    @cached_property
    def run(self) -> Trajectory:
        s = self.settings
        # Without a progress bar, as a removed one leaves "model not found" on Voila's page.
        return simulate(s.model, s.t_end, x0=s.x0, method=limit_steps(s.method), progress=False)

    @cached_property
    def eigenvalues(self) -> Eigenvalues | None:
        try:
            return eigenvalues(self.model)
        except ValueError:  # without an equilibrium the motion is still shown
            return None

    @cached_property
    def spectrum(self) -> Spectrum | None:
        """Of the coordinate chosen, or of its rate if it turns for ever; None where the run is too short."""
        name, automaton = self.settings.coordinate, automaton_of(self.model)
        return amplitude_spectrum(self.run, automaton.rates[name] if name in automaton.cyclic else name)

    @cached_property
    def _span(self) -> tuple[float, float]:
        end, window = float(self.run.raw.t), self.settings.window
        if window is None:
            return 0.0, end
        shown = SHOWN_PERIODS * self._period
        if window == BEGINNING:
            return 0.0, min(end, shown)
        if window == WHAT_MOVES and not self.is_moving:
            return moving_span(self.run, shown)
        return max(0.0, end - (shown if window == WHAT_MOVES else float(window))), end

    @cached_property
    def is_moving(self) -> bool:
        """Whether the coordinates change in the last periods of the run."""
        end = float(self.run.raw.t)
        return not is_at_rest(self.run, (max(0.0, end - SHOWN_PERIODS * self._period), end))

    @cached_property
    def decays(self) -> bool:
        """Whether the motion is smaller in the last periods of the run than in as many in its middle."""
        end, seconds = float(self.run.raw.t), SHOWN_PERIODS * self._period
        spans = [np.linspace(max(0.0, t - seconds), t, MIN_SAMPLES) for t in (end / 2, end)]
        early, late = self.run(np.array(spans))[..., : len(self.run.automaton.shown_states)]
        return bool(np.ptp(late, axis=0).max() < STEADY * np.ptp(early, axis=0).max())

    def times(self) -> Array:
        """Times (s) of the part of the run that is shown, at equal distances."""
        start, stop = self._span
        count = np.clip((stop - start) / self._period * SAMPLES_PER_PERIOD, MIN_SAMPLES, MAX_SAMPLES)
        return np.clip(np.linspace(start, stop, int(count) + 1), start, stop)

    def samples(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Times (N,), states (N, 2n) and modes (N,) of what is shown: at :meth:`times` and, where there are
        few, on both sides of each event."""
        times, raw = self.times(), self.run.raw
        inside = np.flatnonzero((raw.event_times > times[0]) & (raw.event_times < times[-1]))
        inside = inside if len(inside) <= MAX_EVENTS else inside[:0]
        first = inside[np.diff(raw.event_times[inside], prepend=-np.inf) > 0]
        jumps = raw.event_times[first]
        states, modes = self.run.states_and_modes(np.concatenate([times, jumps]))
        before = raw.event_states[first, 0]
        sources = self.run.problem.program.guard_modes[raw.event_codes[first, 0]]
        times = np.concatenate([times, jumps, jumps])
        states, modes = np.concatenate([states, before]), np.concatenate([modes, sources])
        side = np.concatenate([np.ones(len(states) - len(jumps)), np.zeros(len(jumps))])
        order = np.lexsort((side, times))
        return times[order], states[order], modes[order]
