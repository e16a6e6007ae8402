"""The data that panels draw, computed when first needed, so that only what some panel uses is computed."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import Spectrum, amplitude_spectrum, rounded_period
from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.stability import Eigenvalues, eigenvalues

from .settings import SHOWN_PERIODS, WHAT_MOVES, Settings, limit_steps

Array = NDArray[np.float64]
SAMPLES_PER_PERIOD, MIN_SAMPLES, MAX_SAMPLES = 40, 800, 20_000  # samples of what is shown


AT_REST = 1e-9  # share of the range of a motion: what varies less has come to rest
SEEN = 1e-3  # the same: what varies less is not seen in a picture
AFTER_REST = 1.15  # how far beyond the end of a motion it is shown
SAMPLES_AT_REST = 65
STEADY = 0.95  # share of its size that a motion keeps over half a run at least, unless it decays


def is_at_rest(run: Trajectory, span: tuple[float, float]) -> bool:
    """Whether no coordinate changes in a part of a run, measured by how far it is from where it began."""
    states = run(np.linspace(*span, SAMPLES_AT_REST))[:, : run.automaton.coordinates]
    began = run(np.zeros(1))[:, : run.automaton.coordinates]
    size = max(float(np.abs(states - began).max()), float(np.abs(states).max()))
    return bool(np.ptp(states, axis=0).max() <= AT_REST * size)


def time_of_rest(run: Trajectory) -> float:
    """When a run came to rest (s): from then on no coordinate is seen to leave its last value."""
    q = run.states[:, : run.automaton.coordinates]
    away = np.abs(q - q[-1]).max(axis=1)
    moved = np.flatnonzero(away > SEEN * away.max())
    after = min(int(moved[-1]) + 1, len(q) - 1) if len(moved) else len(q) - 1
    # The last event may come long after what is seen, as the impacts of a ball do.
    events = run.events.t
    return max(float(run.t[after]), float(events[-1]) if len(events) else 0.0)


class Result:
    """The run, the equilibrium and its eigenvalues for one setting.

    Attributes
    ----------
    settings : Settings
    model : Model
    run : Trajectory
    eigenvalues : Eigenvalues or None
        With the equilibrium; None where there is none.
    no_equilibrium_reason : str
        Why there is no equilibrium; empty where there is one.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings, self.model = settings, settings.model

    @cached_property
    def run(self) -> Trajectory:
        s = self.settings
        # No progress bar: one that is removed leaves "model not found" on Voila's page.
        return simulate(s.model, s.t_end, x0=s.x0, method=limit_steps(s.method), progress=False)

    @property
    def has_run(self) -> bool:
        """Whether the run has been computed."""
        return "run" in self.__dict__

    @property
    def has_spectrum(self) -> bool:
        """Whether the spectrum has been computed."""
        return "spectrum" in self.__dict__

    @cached_property
    def _linear(self) -> tuple[Eigenvalues | None, str]:
        try:
            return eigenvalues(self.model), ""
        except ValueError as error:  # without an equilibrium the motion is still shown
            return None, str(error)

    @property
    def eigenvalues(self) -> Eigenvalues | None:
        return self._linear[0]

    @property
    def no_equilibrium_reason(self) -> str:
        return self._linear[1]

    @cached_property
    def spectrum(self) -> Spectrum | None:
        """Of the coordinate chosen; None where the run is too short."""
        return amplitude_spectrum(self.run, self.settings.coordinate)

    @cached_property
    def _span(self) -> tuple[float, float]:
        end, window = float(self.run.raw.t), self.settings.window
        if window is None:
            return 0.0, end
        moving = window == WHAT_MOVES
        seconds = SHOWN_PERIODS * rounded_period(self.model) if moving else float(window)
        span = max(0.0, end - seconds), end
        if not moving or span[0] == 0.0 or not is_at_rest(self.run, span):
            return span
        return 0.0, min(end, AFTER_REST * time_of_rest(self.run))

    @property
    def is_moving(self) -> bool:
        """Whether the coordinates change in the last periods of the run."""
        end = float(self.run.raw.t)
        return not is_at_rest(self.run, (max(0.0, end - SHOWN_PERIODS * rounded_period(self.model)), end))

    @cached_property
    def decays(self) -> bool:
        """Whether the motion is smaller in the last periods of the run than in as many in its middle."""
        end, seconds = float(self.run.raw.t), SHOWN_PERIODS * rounded_period(self.model)
        late, early = (
            self.run(np.linspace(max(0.0, t - seconds), t, MIN_SAMPLES))[:, : len(self.model.coordinates)]
            for t in (end, end / 2)
        )
        return bool(np.ptp(late, axis=0).max() < STEADY * np.ptp(early, axis=0).max())

    def times(self) -> Array:
        """Times (s) of the part of the run that is shown, at equal distances."""
        start, stop = self._span
        count = (
            int(
                np.clip(
                    (stop - start) / rounded_period(self.model) * SAMPLES_PER_PERIOD, MIN_SAMPLES, MAX_SAMPLES
                )
            )
            + 1
        )
        return np.clip(np.linspace(start, stop, count), start, stop)

    @cached_property
    def states(self) -> Array:
        """States (N, 2n) at :meth:`times`."""
        return self.run(self.times())

    def state(self, name: str) -> Array:
        """One state at :meth:`times`, e.g. "x1" or "x1'"."""
        return self.states[:, self.run.names.index(name)]

    @cached_property
    def modes(self) -> Any:
        """Names (N,) of the modes at :meth:`times`."""
        raw, t = self.run.raw, self.times()
        steps = np.clip(np.searchsorted(raw.step_times[:, 0], t, side="right") - 1, 0, None)
        codes = raw.step_modes[np.minimum(steps, len(raw.step_modes) - 1)] if len(raw.step_modes) else []
        return np.array(self.run.mode_names)[codes] if len(codes) else np.full(len(t), "")
