"""`SteadyState`: kind, period, intensity, section and time in each mode of the motion in a window."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from frictionlab.analysis.spectrum import Spectrum, amplitude_spectrum
from frictionlab.analysis.verification.defect_warning import defect_warning
from frictionlab.drawable import Drawable
from frictionlab.hybrid.events import SectionPoints
from frictionlab.hybrid.trajectory import Trajectory

from .classification import classify_run, onsets_per_period
from .intensity import intensity
from .motion_kind import MotionKind
from .poincare_sections import Section


@dataclass(frozen=True, eq=False)
class SteadyState(Drawable):
    """What a motion settles to.

    Parameters
    ----------
    model : Model or HybridAutomaton
    kind : MotionKind
        One of "equilibrium", "periodic", "non-periodic", "not settled yet" and "ended early", the last where
        the solver did not reach the end of the run: ``trajectory.status`` says why.
    period : float
        s; NaN where the motion is not periodic.
    onsets_per_period : int
        Transitions from slip to stick in a period; 0 where the motion is not periodic.
    intensity : float
        L_s, Eq. (20): mean of the squared distance from the sliding equilibrium, the coordinates summed (m^2
        and rad^2).  Taken over the last period where there is one, else over the window.  NaN without an
        equilibrium, or where the run ended early.
    section : SectionPoints
        Crossings of the section in the window: times (K,), states (K, 2n).  Of a run that ended early the
        place where it ended.
    deviation : float
        How far the state is from that one period before, as a share of the motion's size.
    time_in_mode : mapping
        Share of the window spent in each mode.
    trajectory : Trajectory
        The run over the window; its time starts at zero.
    transient : float
        Seconds before the window.
    """

    drawn_by = "plot_steady_state"

    model: Any
    kind: MotionKind
    period: float
    onsets_per_period: int
    intensity: float
    section: SectionPoints
    deviation: float
    time_in_mode: Mapping[str, float]
    trajectory: Trajectory
    transient: float

    @cached_property
    def warning(self) -> str | None:
        """A sentence where steps of the window are far less exact than asked; else None."""
        return defect_warning(self.trajectory)

    @property
    def settled(self) -> bool:
        """Whether the transient was long enough to tell."""
        return self.kind in (MotionKind.EQUILIBRIUM, MotionKind.PERIODIC, MotionKind.NON_PERIODIC)

    def spectrum(self, name: str | None = None, *, f_max: float | None = None) -> Spectrum | None:
        """Amplitude spectrum (the state's unit, over Hz) of the whole window, Hann-weighted; see
        :func:`frictionlab.analysis.spectrum.amplitude_spectrum`.
        """
        return amplitude_spectrum(self.trajectory, name, f_max=f_max, start=0.0)

    def __repr__(self) -> str:
        if self.kind == MotionKind.ENDED_EARLY:
            return f"SteadyState({MotionKind.ENDED_EARLY}: {self.trajectory.status})"
        onsets = "onset" if self.onsets_per_period == 1 else "onsets"
        period = f", period {self.period:.6g} s, {self.onsets_per_period} {onsets} of stick in it"
        period = period if self.kind == MotionKind.PERIODIC else ""
        return f"SteadyState({self.kind}{period}, L_s {self.intensity:.5g})"


def steady_state_of_window(
    model: Any, run: Trajectory, section: Section | None, tolerance: float, *, passed: float
) -> SteadyState:
    """The kind of motion in a run, its period, intensity and so on; arguments as of `steady_state`."""
    found = classify_run(run, section, tolerance)
    return SteadyState(
        model=model,
        kind=found.kind,
        period=found.period,
        onsets_per_period=onsets_per_period(run, found.period) if found.kind == MotionKind.PERIODIC else 0,
        intensity=np.nan if found.kind == MotionKind.ENDED_EARLY else intensity(run, found.period),
        section=found.section,
        deviation=found.returns.deviation,
        time_in_mode={name: seconds / (run.raw.t or 1.0) for name, seconds in run.time_in_mode.items()},
        trajectory=run,
        transient=passed,
    )
