"""The data that panels draw, computed when first needed, so that only what some panel uses is computed."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import rounded_period
from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.spectrum import Spectrum, amplitude_spectrum
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.stability import Eigenvalues, eigenvalues

from .settings import Settings, limit_steps

Array = NDArray[np.float64]
SAMPLES_PER_PERIOD, MIN_SAMPLES, MAX_SAMPLES = 40, 800, 20_000  # samples of what is shown


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
        return (0.0 if window is None else max(0.0, end - window)), end

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
