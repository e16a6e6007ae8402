"""The attractor that the motion from a state leads to, as data that JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array, state_ranges
from frictionlab.analysis.steady_state.classification import EVEN_SAMPLES, MIN_DECAY_FACTOR, classify_run
from frictionlab.analysis.steady_state.motion_kind import MotionKind
from frictionlab.analysis.steady_state.poincare_sections import sections_to_record
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory

from .attractors import RANGE_RTOL, AttractorData, attractor_scale

# points on an attractor, evenly in time: those of a sinusoid are 1.6e-4 of its range apart
ATTRACTOR_POINTS = 20_000
PATH_POINTS = 400  # points that are kept to draw it
REST_CHANGE_RTOL = 1e-8  # share of its range in the transient by which a motion at rest may still move
MAX_REST_TRANSIENTS = 20  # transients after which a motion is classified, settled or not

BasinSettings = Mapping[str, Any]  # the arguments of `fl.basins` by their names


def probe_attractor(automaton: HybridAutomaton, start: Any, settings: BasinSettings) -> AttractorData:
    """One task: the attractor of the motion from one state (n,), with the range of each state on the way."""
    run = _run(automaton, settings["transient"], np.asarray(start), settings)
    passed = np.vstack([run.raw.step_states, run.final_state])
    reach = [passed.min(axis=0).tolist(), passed.max(axis=0).tolist()]
    if not run.status.ok:
        return {
            "kind": MotionKind.ENDED_EARLY,
            "period": None,
            "state": run.final_state.tolist(),
            "reach": reach,
        }
    found = classify_attractor(automaton, run.final_state, np.ptp(passed, axis=0), settings)
    return {**add_ranges(found, attractor_points(automaton, found, settings)), "reach": reach}


def classify_attractor(
    automaton: HybridAutomaton, state: Array, spread: Array, settings: BasinSettings
) -> AttractorData:
    """The attractor of the motion from a state after the transient; `spread` (n,) is the range of each state
    so far."""
    section, tolerance = settings["section"], settings["tolerance"]
    run = _run(automaton, settings["window"], state, settings, sections_to_record(automaton, section))
    verdict = classify_run(run, section, tolerance)
    kind = MotionKind.EQUILIBRIUM if _decays(run, verdict.kind, spread, settings["rtol"]) else verdict.kind
    end, period = run.final_state, None if np.isnan(verdict.period) else verdict.period
    if kind in RANGE_RTOL:
        end = _state_on_attractor(automaton, end, kind, spread, settings)
    return {"kind": kind, "period": period, "state": end.tolist()}


def _decays(run: Trajectory, kind: str, spread: Array, rtol: float) -> bool:
    """Whether a motion without events, already small beside its earlier range, shrinks all the time.

    Measured by its own size alone, a motion that decays to zero never becomes small.
    """
    if kind != MotionKind.NOT_SETTLED or len(run.events):
        return False
    x = run(np.linspace(0.0, run.raw.t, EVEN_SAMPLES))[:, spread > 0] / spread[spread > 0]
    first, *_, last = (float(state_ranges(part).max(initial=0.0)) for part in np.array_split(x, 4))
    return last < min(rtol, first / MIN_DECAY_FACTOR)


def _state_on_attractor(
    automaton: HybridAutomaton, state: Array, kind: str, spread: Array, settings: BasinSettings
) -> Array:
    """A state closer to the attractor, which is known to a few digits so far: after one transient more, or at
    rest."""
    size, moving = attractor_scale([], spread, automaton.coordinates), 2 * automaton.coordinates or None
    for _ in range(MAX_REST_TRANSIENTS if kind == MotionKind.EQUILIBRIUM else 1):
        before, state = state, _run(automaton, settings["transient"], state, settings).final_state
        if not (np.abs(state - before) / size)[:moving].max() > REST_CHANGE_RTOL:
            break
    return state


def attractor_points(automaton: HybridAutomaton, found: AttractorData, settings: BasinSettings) -> Array:
    """Points (K, n) on an attractor, evenly in time; none where the motion has not settled or ended early."""
    state = np.array(found["state"])
    if found["kind"] == MotionKind.EQUILIBRIUM and len(state) <= 2 * automaton.coordinates:
        return state[None]
    if found["kind"] not in RANGE_RTOL:
        return state[None][:0]
    run = _run(automaton, found["period"] or settings["window"], state, settings)
    return run(np.linspace(0.0, run.raw.t, ATTRACTOR_POINTS))


def _run(
    automaton: HybridAutomaton, t_end: float, state: Array, settings: BasinSettings, sections: Any = None
) -> Trajectory:
    options: dict[str, Any] = {"method": settings["method"], "sections": sections, "progress": False}
    return solve(automaton, t_end, x0=state, **options)


def add_ranges(found: AttractorData, points: Array) -> AttractorData:
    """The data of an attractor, with its points and the range of each state over them."""
    if not len(points):
        return found
    path = points[:: max(1, len(points) // PATH_POINTS)]
    extent = {"low": points.min(axis=0).tolist(), "high": points.max(axis=0).tolist()}
    return {**found, **extent, "path": path.tolist()}
