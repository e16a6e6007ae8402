"""What the motion from a state comes to, as data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory

from .attractors import SAME_RANGE, Found, size_of
from .kinds import DYING, ENDED, EQUILIBRIUM, SAMPLES, UNSETTLED
from .recurrence import Array, sizes
from .sections import recorded
from .window import judged

POINTS = 20_000  # of an attractor, evenly in time: a sinusoid's are 1.6e-4 of its range apart
DRAWN = 400  # of them that are kept to draw it
STILL = 1e-8  # share of a motion's range by which what is at rest may move in a transient
PATIENCE = 20  # transients after which it is taken as it is

Settings = Mapping[str, Any]  # the arguments of `fl.basins` by their names


def probe(automaton: HybridAutomaton, start: Any, settings: Settings) -> Found:
    """One task: what the motion from one state (n,) settles to, with the range of all that it passes."""
    run = _run(automaton, settings["transient"], np.asarray(start), settings)
    passed = np.vstack([run.raw.step_states, run.final_state])
    reach = [passed.min(axis=0).tolist(), passed.max(axis=0).tolist()]
    if not run.status.ok:
        return {"kind": ENDED, "period": None, "state": run.final_state.tolist(), "reach": reach}
    found = examined(automaton, run.final_state, np.ptp(passed, axis=0), settings)
    return {**with_ranges(found, cloud(automaton, found, settings)), "reach": reach}


def examined(automaton: HybridAutomaton, state: Array, spread: Array, settings: Settings) -> Found:
    """What the motion from a state comes to, the transient being over; `spread` (n,) is its range so far."""
    section, tolerance = settings["section"], settings["tolerance"]
    run = _run(automaton, settings["window"], state, settings, recorded(automaton, section))
    verdict = judged(run, section, tolerance)
    kind = EQUILIBRIUM if _dies(run, verdict.kind, spread, settings["near"]) else verdict.kind
    end, period = run.final_state, None if np.isnan(verdict.period) else verdict.period
    if kind in SAME_RANGE:
        end = _upon(automaton, end, kind, spread, settings)
    return {"kind": kind, "period": period, "state": end.tolist()}


def _dies(run: Trajectory, kind: str, spread: Array, near: float) -> bool:
    """Whether a motion without events, small beside what it has been, becomes ever smaller.

    By itself a motion that dies away to zero is always as large as it has been.
    """
    if kind != UNSETTLED or len(run.events):
        return False
    x = run(np.linspace(0.0, run.raw.t, SAMPLES))[:, spread > 0] / spread[spread > 0]
    first, *_, last = (float(sizes(part).max(initial=0.0)) for part in np.array_split(x, 4))
    return last < min(near, first / DYING)


def _upon(automaton: HybridAutomaton, state: Array, kind: str, spread: Array, settings: Settings) -> Array:
    """A state on an attractor that is told by its first decimals so far: one transient later, or at rest."""
    size, moving = size_of([], spread, automaton.coordinates), 2 * automaton.coordinates or None
    for _ in range(PATIENCE if kind == EQUILIBRIUM else 1):
        before, state = state, _run(automaton, settings["transient"], state, settings).final_state
        if not (np.abs(state - before) / size)[:moving].max() > STILL:
            break
    return state


def cloud(automaton: HybridAutomaton, found: Found, settings: Settings) -> Array:
    """Points (K, n) of an attractor, evenly in time; none of what is no attractor."""
    state = np.array(found["state"])
    if found["kind"] == EQUILIBRIUM and len(state) <= 2 * automaton.coordinates:
        return state[None]
    if found["kind"] not in SAME_RANGE:
        return state[None][:0]
    run = _run(automaton, found["period"] or settings["window"], state, settings)
    return run(np.linspace(0.0, run.raw.t, POINTS))


def _run(
    automaton: HybridAutomaton, t_end: float, state: Array, settings: Settings, sections: Any = None
) -> Trajectory:
    options: dict[str, Any] = {"method": settings["method"], "sections": sections, "progress": False}
    return solve(automaton, t_end, x0=state, **options)


def with_ranges(found: Found, points: Array) -> Found:
    """The data of an attractor, with what its points tell."""
    if not len(points):
        return found
    path = points[:: max(1, len(points) // DRAWN)]
    extent = {"low": points.min(axis=0).tolist(), "high": points.max(axis=0).tolist()}
    return {**found, **extent, "path": path.tolist()}
