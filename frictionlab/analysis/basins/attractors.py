"""Attractors that motions lead to, the features that tell them apart, and the catalogue of those known.

The features are the kind, the period and the range of each state.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from frictionlab.analysis.motion_scales import Array, state_groups
from frictionlab.analysis.options import SteadyStateOptions
from frictionlab.analysis.steady_state.classification import MotionKind, classify_run, is_small_and_decays
from frictionlab.analysis.steady_state.poincare_sections import sections_to_record
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import end_of, solve_from_end
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.presentation import count

# points on an attractor, evenly in time: those of a sinusoid are 1.6e-4 of its range apart
ATTRACTOR_POINTS = 20_000
PATH_POINTS = 400  # points that are kept to draw it
REST_CHANGE_RTOL = 1e-8  # share of a state's range so far by which it may still change at rest
MAX_REST_TRANSIENTS = 20  # most further transients in which a motion is to come to rest

# least scale of a state, as a share of the largest scale in its group, and of its own range over the motions
# to the attractors
MIN_RANGE_SHARE = 1e-2
PERIOD_RTOL = 1e-3
RANGE_RTOL = {
    MotionKind.EQUILIBRIUM: 1e-2,
    MotionKind.PERIODIC: 1e-2,
    MotionKind.NON_PERIODIC: 0.1,
}  # share of the attractors' size

UNDECIDED = -1

ModeState = tuple[Array, str | None]  # a state (n,) and its mode, None where that is to be chosen
AttractorData = dict[str, Any]  # an attractor as data that JSON can hold


def drifting_of(attractor: AttractorData) -> list[int]:
    """The states that grow or fall for ever in a motion, such as the place of a cart."""
    return attractor.get("drifting", [])


def probe_attractor(automaton: HybridAutomaton, start: Any, options: SteadyStateOptions) -> AttractorData:
    """One task: the attractor of the motion from one state (n,), with the range of each state on the way."""
    run = _run(automaton, options.transient, (np.asarray(start), None), options)
    passed = np.vstack([run.raw.step_states, run.final_state])
    reach = [passed.min(axis=0).tolist(), passed.max(axis=0).tolist()]
    if not run.status.ok:
        return {
            "kind": MotionKind.ENDED_EARLY,
            "period": None,
            "state": run.final_state.tolist(),
            "reach": reach,
        }
    attractor = classify_attractor(automaton, end_of(run), np.ptp(passed, axis=0), options)
    return {**add_ranges(attractor, attractor_points(automaton, attractor, options)), "reach": reach}


def classify_attractor(
    automaton: HybridAutomaton, start: ModeState, spread: Array, options: SteadyStateOptions
) -> AttractorData:
    """The attractor of the motion from where it is after the transient; `spread` (n,) is the range of each
    state so far."""
    section, tolerance = options.section, options.tolerance
    run = _run(automaton, options.window, start, options, sections_to_record(automaton, section))
    verdict = classify_run(run, section, tolerance)
    kind = verdict.kind
    size = spread[: automaton.coordinates or None].max()
    if kind == MotionKind.NOT_SETTLED and is_small_and_decays(run, size, options.rtol):
        kind = MotionKind.EQUILIBRIUM
    period = None if np.isnan(verdict.period) else verdict.period
    end, mode = end_of(run)
    drifting: list[int] = []
    if kind in RANGE_RTOL:
        drifting = [] if verdict.drift is None else verdict.drift.places
        end, mode = _state_on_attractor(automaton, (end, mode), kind, drifting, spread, options)
    modes = [run.mode_names[i] for i in np.unique(run.raw.step_modes)]
    attractor = {"kind": kind, "period": period, "state": end.tolist(), "mode": mode, "modes": modes}
    return attractor | ({"drifting": drifting} if drifting else {})


def _state_on_attractor(
    automaton: HybridAutomaton,
    start: ModeState,
    kind: str,
    drifting: list[int],
    spread: Array,
    options: SteadyStateOptions,
) -> ModeState:
    """A state closer to the attractor, which is known to a few digits so far.

    It is the state after one more transient; for an equilibrium after as many as it takes for all but the
    `drifting` states to come to rest.
    """
    size, moving = attractor_scale([], spread, automaton.coordinates), 2 * automaton.coordinates or None
    for _ in range(MAX_REST_TRANSIENTS if kind == MotionKind.EQUILIBRIUM else 1):
        run = _run(automaton, options.transient, start, options)
        before, start = start, end_of(run)
        change = np.abs(start[0] - before[0]) / size
        change[drifting] = 0.0
        if not change[:moving].max() > REST_CHANGE_RTOL:
            break
    return start


def attractor_points(
    automaton: HybridAutomaton, attractor: AttractorData, options: SteadyStateOptions
) -> Array:
    """Points (K, n) on an attractor, evenly in time; none where the motion has not settled or ended early."""
    state = np.array(attractor["state"])
    if attractor["kind"] == MotionKind.EQUILIBRIUM and len(state) <= 2 * automaton.coordinates:
        return state[None]
    if attractor["kind"] not in RANGE_RTOL:
        return state[None][:0]
    start = state, attractor.get("mode")
    run = _run(automaton, attractor["period"] or options.window, start, options)
    return run(np.linspace(0.0, run.raw.t, ATTRACTOR_POINTS))


def _run(
    automaton: HybridAutomaton,
    t_end: float,
    start: ModeState,
    options: SteadyStateOptions,
    sections: Any = None,
) -> Trajectory:
    records: dict[str, Any] = {"method": options.solver, "sections": sections}
    return solve_from_end(automaton, t_end, *start, **records, progress=False)


def add_ranges(attractor: AttractorData, points: Array) -> AttractorData:
    """The data of an attractor, with its points and the range of each state over them."""
    if not len(points):
        return attractor
    path = points[:: max(1, len(points) // PATH_POINTS)]
    extent = {"low": points.min(axis=0).tolist(), "high": points.max(axis=0).tolist()}
    return {**attractor, **extent, "path": path.tolist()}


@dataclass(frozen=True, eq=False)
class Attractor:
    """An attractor, or one of the two outcomes that are no attractors.

    Parameters
    ----------
    name : str
        "equilibrium", "period 6.316 s", "non-periodic", with the addition "with drift" where the motion turns
        for ever or a place grows; others of the same name are numbered.  "not settled yet" and "ended early"
        are no attractors.
    kind : str
        As of :func:`frictionlab.steady_state`.
    period : float
        s; NaN where the motion is not periodic.
    state : array (n,)
        A state on the attractor.
    low, high : array (n,)
        Smallest and largest value of each state.
    path : array (K, n)
        Some of its points, in the order of time.
    """

    name: str
    kind: str
    period: float
    state: Array
    low: Array
    high: Array
    path: Array

    def __repr__(self) -> str:
        return f"Attractor({self.name}, {count(len(self.state), 'state')}, {count(len(self.path), 'point')})"

    @property
    def settled(self) -> bool:
        """Whether it is an attractor."""
        return self.kind in RANGE_RTOL


def transient_ranges(probes: Sequence[AttractorData]) -> Array:
    """The range (n,) of each state over the motions that led to attractors; zeros where none did."""
    reached = [np.array(a["reach"]) for a in probes if a["kind"] in RANGE_RTOL]
    if not reached:
        return np.zeros(len(probes[0]["state"]) if probes else 0)
    low, high = np.min(reached, axis=0)[0], np.max(reached, axis=0)[1]
    return high - low


def attractor_scale(attractors: Sequence[AttractorData], spread: Array, coordinates: int) -> Array:
    """The range (n,) of each state over all attractors, or over the motions to them where none is known.

    It is at least a share of the range over those motions: smaller differences tell no attractors apart.  How
    far states drift says nothing of a motion.
    """
    steady = [a for a in attractors if a["kind"] in RANGE_RTOL]
    size = np.array(spread)
    if steady:
        size = np.max([a["high"] for a in steady], axis=0) - np.min([a["low"] for a in steady], axis=0)
        size = np.maximum(size, MIN_RANGE_SHARE * spread)
        size[sorted({i for a in steady for i in drifting_of(a)})] = 0.0
    for group in state_groups(coordinates):
        size[group] = np.maximum(size[group], MIN_RANGE_SHARE * size[group].max(initial=0.0))
    return np.where(size > 0, size, 1.0)


def same_attractor(one: AttractorData, other: AttractorData, size: Array) -> bool:
    """Whether two attractors are the same: of one kind, one period and one range in each state.

    The states that drift must be the same; where they are does not matter.
    """
    if one["kind"] != other["kind"] or one["kind"] not in RANGE_RTOL:
        return one["kind"] == other["kind"]
    if drifting_of(one) != drifting_of(other):
        return False
    if one["kind"] == MotionKind.PERIODIC and abs(one["period"] / other["period"] - 1.0) > PERIOD_RTOL:
        return False
    differences = [np.abs(np.subtract(one[side], other[side])) / size for side in ("low", "high")]
    distances = np.delete(differences, drifting_of(one), axis=1)
    return bool(distances.max(initial=0.0) < RANGE_RTOL[one["kind"]])


class AttractorCatalogue:
    """The known attractors, in the order in which they were found.

    Parameters
    ----------
    size : array (n,)
        Scale of each state, by which differences are measured.
    rtol : float
        Share of `size` within which a state counts as on an attractor.
    """

    def __init__(self, size: Array, rtol: float) -> None:
        self.attractors: list[AttractorData] = []
        self._size, self._rtol = size, rtol
        self._trees: list[Any] = []

    def copy(self) -> AttractorCatalogue:
        """A copy that can be extended on its own."""
        other = AttractorCatalogue(self._size, self._rtol)
        other.attractors, other._trees = [*self.attractors], [*self._trees]
        return other

    def known(self, attractor: AttractorData) -> int:
        """Index of an attractor, `UNDECIDED` where it is new."""
        return next(
            (i for i, other in enumerate(self.attractors) if same_attractor(attractor, other, self._size)),
            UNDECIDED,
        )

    def place(self, attractor: AttractorData, points: Array | None = None) -> int:
        """Index of an attractor, which is added where it is new.

        With its points (K, n), :meth:`reached` recognises states on it.
        """
        index = self.known(attractor)
        if index != UNDECIDED:
            return index
        self.attractors.append(attractor)
        # No state of one motion with a drift is on another; such runs are classified after the transient.
        if points is None or not len(points) or drifting_of(attractor):
            self._trees.append(None)
        else:
            self._trees.append(KDTree(points / self._size))
        return len(self.attractors) - 1

    def reached(self, states: Array, modes: np.ndarray | None = None) -> np.ndarray:
        """Index of the attractor that each state (N, n) is on, `UNDECIDED` where there is none.

        In a mode that an attractor never is in a motion is not on it, as with hysteresis; `modes` (N,) are
        the names of the modes.
        """
        index, shares = np.full(len(states), UNDECIDED), states / self._size
        for i, tree in enumerate(self._trees):
            if tree is None:
                continue
            box = (shares > tree.mins - 2 * self._rtol) & (shares < tree.maxes + 2 * self._rtol)
            if modes is not None and "modes" in self.attractors[i]:
                box &= np.isin(modes, self.attractors[i]["modes"])[:, None]
            about = np.flatnonzero(box.all(axis=1) & (index == UNDECIDED))  # faster to test than the tree
            if len(about):
                distance = tree.query(shares[about], p=np.inf, distance_upper_bound=self._rtol)[0]
                index[about[distance < self._rtol]] = i
        return index


def catalogue_of_probes(
    probes: Sequence[AttractorData],
    coordinates: int,
    rtol: float,
    points_on: Callable[[AttractorData], Array] | None = None,
) -> AttractorCatalogue:
    """The attractors that the probes led to, each once.

    `points_on` gives points on an attractor; with it, :meth:`AttractorCatalogue.reached` recognises states.
    """
    catalogue = AttractorCatalogue(attractor_scale(probes, transient_ranges(probes), coordinates), rtol)
    for attractor in probes:
        if catalogue.known(attractor) == UNDECIDED:
            catalogue.place(attractor, None if points_on is None else points_on(attractor))
    return catalogue


def name_attractors(attractors: Sequence[AttractorData]) -> tuple[Attractor, ...]:
    """The attractors, with a name for each."""
    names = [_name(a) for a in attractors]
    counts = [names[: i + 1].count(name) for i, name in enumerate(names)]
    full = [f"{name} ({count})" if count > 1 else name for name, count in zip(names, counts)]
    return tuple(_attractor(name, a) for name, a in zip(full, attractors))


def _name(attractor: AttractorData) -> str:
    periodic = attractor["kind"] == MotionKind.PERIODIC
    name = f"period {attractor['period']:.4g} s" if periodic else str(attractor["kind"])
    return f"{name} with drift" if drifting_of(attractor) else name


def _attractor(name: str, attractor: AttractorData) -> Attractor:
    state = np.array(attractor["state"])
    low, high = (np.array(attractor.get(side, np.full_like(state, np.nan))) for side in ("low", "high"))
    path = np.array(attractor.get("path", [])).reshape(-1, len(state))
    period = np.nan if attractor["period"] is None else attractor["period"]
    return Attractor(name, attractor["kind"], period, state, low, high, path)
