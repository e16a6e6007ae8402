"""What a window of a motion shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from frictionlab.hybrid.trajectory import Points, Trajectory

from .clocks import unwound
from .intensity import intensity
from .kinds import ENDED, EQUILIBRIUM, NON_PERIODIC, PERIODIC, kind_of, onsets_in
from .recurrence import FEWEST, SHORTEST, Array, Recurrence, recurrence, repeats, sizes
from .sections import STICK, Section, points, stick_onsets, turning
from .spectrum import Spectrum, amplitude_spectrum
from .trust import warning_of


@dataclass(frozen=True, eq=False)
class SteadyState:
    """What a motion settles to.

    Parameters
    ----------
    model : Model or HybridAutomaton
    kind : "equilibrium", "periodic", "non-periodic", "not settled yet" or "ended early"
        The last where the solver did not reach the end of the run: ``trajectory.status`` says why.
    period : float
        s; NaN where the motion is not periodic.
    onsets_per_period : int
        Transitions from slip to stick in a period; 0 where the motion is not periodic.
    intensity : float
        L_s, Eq. (20): mean of the squared distance from the sliding equilibrium, the coordinates summed (m^2
        and rad^2).  Over the last period where there is one, else over the window.  NaN without an
        equilibrium, or where the run ended early.
    section : Points
        Crossings of the section in the window: times (K,), states (K, 2n).  Of a run that ended early the
        place where it ended.
    deviation : float
        How far the state is from that one period before, as a share of the motion's size.
    time_in_mode : mapping
        Share of the window spent in each mode.
    trajectory : Trajectory
        The window; its time starts at zero.
    transient : float
        Seconds before the window.
    """

    model: Any
    kind: str
    period: float
    onsets_per_period: int
    intensity: float
    section: Points
    deviation: float
    time_in_mode: Mapping[str, float]
    trajectory: Trajectory
    transient: float

    @cached_property
    def warning(self) -> str | None:
        """A sentence where steps of the window are far less exact than asked; else None."""
        return warning_of(self.trajectory)

    @property
    def settled(self) -> bool:
        """Whether the transient was long enough to tell."""
        return self.kind in (EQUILIBRIUM, PERIODIC, NON_PERIODIC)

    def spectrum(self, name: str | None = None, *, f_max: float | None = None) -> Spectrum | None:
        """Amplitude spectrum (the state's unit, over Hz) of the whole window, Hann-weighted; see
        :func:`frictionlab.analysis.spectrum.amplitude_spectrum`.
        """
        return amplitude_spectrum(self.trajectory, name, f_max=f_max, start=0.0)

    def __repr__(self) -> str:
        if self.kind == ENDED:
            return f"SteadyState({ENDED}: {self.trajectory.status})"
        onsets = "onset" if self.onsets_per_period == 1 else "onsets"
        period = f", period {self.period:.6g} s, {self.onsets_per_period} {onsets} of stick in it"
        return f"SteadyState({self.kind}{period if self.kind == PERIODIC else ''}, L_s {self.intensity:.5g})"


class Verdict(NamedTuple):
    """What a run tells: crossings of a section, how they repeat, the kind of motion, its period (s)."""

    section: Points
    returns: Recurrence
    kind: str
    period: float


def judged(run: Trajectory, section: Section | None, tolerance: float) -> Verdict:
    """The kind of motion in a run and its period; arguments as of `steady_state`."""
    if not run.status.ok:
        # Nothing repeats, and what grows without bounds may have a million crossings.
        end = Points(np.array([run.raw.t]), run.final_state[None])
        return Verdict(end, Recurrence(0, np.nan, np.nan, np.nan), ENDED, np.nan)
    if section is None:
        section = STICK if stick_onsets(run).sum() >= SHORTEST else turning(run.automaton)
    crossings = points(run, section)
    states, returns = _returning(run, crossings, tolerance)
    if section == STICK and not repeats(returns, tolerance):
        # Where the belt's speed is but touched, stick begins or not as rounding has it.
        turns, other = _returning(run, points(run, turning(run.automaton)), tolerance)
        if repeats(other, tolerance) or len(states) < FEWEST:
            states, returns = turns, other
    kind = kind_of(run, states, returns, tolerance)
    return Verdict(crossings, returns, kind, returns.period if kind == PERIODIC else np.nan)


def _returning(run: Trajectory, crossings: Points, tolerance: float) -> tuple[Array, Recurrence]:
    """The states at crossings of a section, clocks as points on a circle, and how they repeat."""
    states, size = unwound(run, crossings.state), sizes(unwound(run, run.raw.step_states))
    return states, recurrence(crossings.t, states, size, tolerance)


def look(
    model: Any, run: Trajectory, section: Section | None, tolerance: float, *, passed: float
) -> SteadyState:
    """The kind of motion in a run, its period, intensity and so on; arguments as of `steady_state`."""
    found = judged(run, section, tolerance)
    return SteadyState(
        model=model,
        kind=found.kind,
        period=found.period,
        onsets_per_period=onsets_in(run, found.period) if found.kind == PERIODIC else 0,
        intensity=np.nan if found.kind == ENDED else intensity(run, found.period),
        section=found.section,
        deviation=found.returns.deviation,
        time_in_mode={name: seconds / (run.raw.t or 1.0) for name, seconds in run.time_in_mode.items()},
        trajectory=run,
        transient=passed,
    )
