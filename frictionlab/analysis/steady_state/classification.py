"""The kind of motion in a run: equilibrium, periodic, non-periodic, or not settled yet.

Recurrence at a section is checked first, then decay and drift over the whole window.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

import numpy as np

from frictionlab.analysis.motion_scales import AT_REST_RTOL, Array, state_ranges
from frictionlab.analysis.steady_state.poincare_sections import (
    STICK,
    Section,
    covers_period,
    only_phase_resets,
    phase_on_circle,
    section_crossings,
    stick_onsets,
    turning_section,
)
from frictionlab.analysis.steady_state.recurrence import (
    MIN_CROSSINGS,
    MIN_PERIODS_SEEN,
    MIN_SETTLING_FACTOR,
    NEAR_RECURRENCE_RTOL,
    Recurrence,
    all_parts_decay,
    amplitude_changes,
    crossings_drift,
    find_recurrence,
    is_periodic,
    part_decays,
)
from frictionlab.hybrid.events import SectionPoints
from frictionlab.hybrid.trajectory import Trajectory

REST_AMPLITUDE_RTOL = 1e-3  # size of a dying motion, as a share of the coordinates, that counts as at rest
MIN_DECAY_FACTOR = 1.4  # by which factor it has to shrink from the first quarter of the window to the last
EVEN_SAMPLES = 8001


class MotionKind(StrEnum):
    """Kind of a steady state; each member equals its text, as ``MotionKind.PERIODIC == "periodic"``."""

    EQUILIBRIUM = "equilibrium"
    PERIODIC = "periodic"
    NON_PERIODIC = "non-periodic"
    NOT_SETTLED = "not settled yet"  # the transient was too short to tell
    ENDED_EARLY = "ended early"  # the run did not reach its end

    def __repr__(self) -> str:
        """That of the text, as results show it."""
        return repr(self.value)


def kind_of_motion(run: Trajectory, crossings: Array, returns: Recurrence, tolerance: float) -> MotionKind:
    """The kind of motion in a run, from its crossings (K, m) of a section and their recurrence.

    Crossings are those of :func:`frictionlab.analysis.steady_state.poincare_sections.phase_on_circle`.
    """
    resting = _at_rest(run)
    if resting is not None:
        return MotionKind.EQUILIBRIUM if resting else MotionKind.NOT_SETTLED
    if is_periodic(returns, tolerance):
        return MotionKind.PERIODIC
    if _decays_slowly(run):
        return MotionKind.EQUILIBRIUM
    near = returns.deviation < NEAR_RECURRENCE_RTOL or returns.shrinking > MIN_SETTLING_FACTOR
    return (
        MotionKind.NOT_SETTLED
        if len(crossings) < MIN_CROSSINGS or near or _has_trend(run, crossings)
        else MotionKind.NON_PERIODIC
    )


def _at_rest(run: Trajectory) -> bool | None:
    """Whether a motion without events has come to rest; None where it does not decay."""
    if not only_phase_resets(run):
        return None
    x = _even_samples(run)[:, : run.automaton.coordinates or None]
    first, *_, last = (float(state_ranges(part).max()) for part in np.array_split(x, 4))
    if state_ranges(x).max() <= AT_REST_RTOL * np.abs(x).max():
        return covers_period(run)  # what a force holds now it may move later on
    if len(run.events):
        return None
    if last <= AT_REST_RTOL * np.abs(x).max():
        return True
    return last < REST_AMPLITUDE_RTOL * np.abs(x).max() if last < first / MIN_DECAY_FACTOR else None


def _decays_slowly(run: Trajectory) -> bool:
    """Whether a motion without events is nearly at rest, but decays too slowly to shrink much within the
    window."""
    if len(run.events):
        return False
    x = _even_samples(run)
    coordinates = x[:, : run.automaton.coordinates or None]
    small = state_ranges(coordinates).max() < REST_AMPLITUDE_RTOL * np.abs(coordinates).max()
    return bool(small and all_parts_decay(x, state_ranges(x)))


def _has_trend(run: Trajectory, crossings: Array) -> bool:
    """Whether a motion that does not repeat drifts, grows or decays throughout the window."""
    size = state_ranges(phase_on_circle(run, run.raw.step_states))
    if (
        crossings_drift(crossings, size)
        or amplitude_changes(run.raw.step_states)
        or part_decays(crossings, size)
    ):
        return True
    x = phase_on_circle(run, _even_samples(run))
    return part_decays(x, state_ranges(x), evenly=not only_phase_resets(run))


def _even_samples(run: Trajectory) -> Array:
    """States (N, m) at even times."""
    return run(np.linspace(0.0, run.raw.t, EVEN_SAMPLES))


def onsets_per_period(run: Trajectory, period: float) -> int:
    """Transitions from slip to stick in a period: their mean over all whole periods of the run."""
    times = run.events.t[stick_onsets(run)]
    if not len(times):
        return 0
    count = max(1, int((times[-1] - times[0]) / period + 0.5))
    # Shifted by half a thousandth of a period, so that rounding does not count both ends.
    return round(int((times > times[-1] - (count - 5e-4) * period).sum()) / count)


class MotionClass(NamedTuple):
    """The classification of a run: crossings of a section, their recurrence, the kind of motion, its period
    (s)."""

    section: SectionPoints
    returns: Recurrence
    kind: MotionKind
    period: float


def classify_run(run: Trajectory, section: Section | None, tolerance: float) -> MotionClass:
    """The kind of motion in a run and its period; arguments as of `steady_state`."""
    if not run.status.ok:
        # A motion that grows without bounds does not repeat, and may have a million crossings.
        end = SectionPoints(np.array([run.raw.t]), run.final_state[None])
        return MotionClass(end, Recurrence(0, np.nan, np.nan, np.nan), MotionKind.ENDED_EARLY, np.nan)
    if section is None:
        section = STICK if stick_onsets(run).sum() >= MIN_PERIODS_SEEN else turning_section(run.automaton)
    crossings = section_crossings(run, section)
    states, returns = _section_recurrence(run, crossings, tolerance)
    if section == STICK and not is_periodic(returns, tolerance):
        # Where the belt's speed is only touched, rounding decides whether stick begins.
        turns, other = _section_recurrence(
            run, section_crossings(run, turning_section(run.automaton)), tolerance
        )
        if is_periodic(other, tolerance) or len(states) < MIN_CROSSINGS:
            states, returns = turns, other
    kind = kind_of_motion(run, states, returns, tolerance)
    return MotionClass(crossings, returns, kind, returns.period if kind == MotionKind.PERIODIC else np.nan)


def _section_recurrence(
    run: Trajectory, crossings: SectionPoints, tolerance: float
) -> tuple[Array, Recurrence]:
    """The states at crossings of a section, phases as points on a circle, and their recurrence."""
    states, size = (
        phase_on_circle(run, crossings.state),
        state_ranges(phase_on_circle(run, run.raw.step_states)),
    )
    return states, find_recurrence(crossings.t, states, size, tolerance)
