"""Motions that turn for ever, or whose place grows: they recur modulo a shift on which nothing depends.

A state drifts where its means in eight parts of a run all ascend, or all descend.  Flow, event functions,
constraints and resets of the modes that the run visits say whether a shift of such states changes nothing:
any shift along a direction in which all their derivatives vanish, as of the place of a cart, or of two blocks
together; or a whole turn, where angles enter through sine and cosine only, alone or with a shift of others in
proportion, as of gears.  Along the first the states are left out of comparisons, a turning angle becomes a
point on a circle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.run_conditions import moved_by_rounding
from frictionlab.analysis.steady_state.poincare_sections import phase_on_circle, phase_resets
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.lazy_names import sympy
from frictionlab.tape.formulas import Formulas, formulas_of

TREND_PARTS = 8  # parts of the window: eight random numbers ascend or descend only twice in 40320 times
SAMPLES = 32  # states in each of these parts
INVARIANCE_RTOL = 1e-9  # share of a function, or of a row of derivatives, that is rounding
DIFFERENCE_ROUNDING = 64 * np.finfo(float).eps
TURN = 2 * np.pi
TURN_CORRECTIONS = 4  # of the ratios of states that turn together, which the mean motion gives roughly


def drifting_states(run: Trajectory) -> list[int]:
    """The coordinates and further states whose means grow, or fall, throughout a run."""
    n = run.automaton.coordinates
    means = np.array([part.mean(axis=0) for part in np.array_split(run(_sample_times(run)), TREND_PARTS)])
    steps = np.diff(means, axis=0)
    one_way = (steps > 0).all(axis=0) | (steps < 0).all(axis=0)
    at = phase_resets(run)
    phases = (run.events.before[at] != run.events.state[at]).any(axis=0)
    places = [int(i) for i in np.flatnonzero(one_way & ~phases) if not n <= i < 2 * n]
    still = moved_by_rounding(run) if places else ()
    return [i for i in places if not still[i]]


def mean_rates(run: Trajectory) -> dict[str, float]:
    """Mean rates (units of the state per s) of the states that drift, by name."""
    change = run.final_state - run.raw.step_states[0]
    return {run.names[i]: float(change[i] / run.raw.t) for i in drifting_states(run)}


@dataclass(frozen=True, eq=False)
class Drift:
    """Shifts of a run's drifting states that change nothing.

    Parameters
    ----------
    run : Trajectory
    places : list of int
        The states that drift.
    across : array (k, r)
        Directions across the shifts, as columns: what is left of the k states in comparisons.
    winding : array (k, t)
        Combinations of the k states, as columns, that are angles: only whole turns leave them as they are.
    """

    run: Trajectory
    places: list[int]
    across: Array
    winding: Array

    def leave_out(self, states: Array) -> Array:
        """States (N, m) of the run without the shifts; phases and angles that turn as points on circles."""
        others = np.delete(phase_on_circle(self.run, states), self.places, axis=1)
        angles = states[:, self.places] @ self.winding
        return np.hstack([states[:, self.places] @ self.across, np.cos(angles), np.sin(angles), others])

    def places_and_rates(self, states: Array) -> tuple[Array, Array]:
        """What the shifts leave of the coordinates and further states (N, k), and the velocities (N, n)."""
        n, left = self.run.automaton.coordinates, self.leave_out(states)
        first = self.across.shape[1] + 2 * self.winding.shape[1] + n - sum(i < n for i in self.places)
        return np.delete(left, slice(first, first + n), axis=1), left[:, first : first + n]

    @property
    def shifted(self) -> list[int]:
        """The states among `places` that the shifts move."""
        along = np.eye(len(self.places)) - self.across @ np.linalg.pinv(self.across)
        return [i for i, share in zip(self.places, np.diag(along), strict=True) if share > INVARIANCE_RTOL]

    @property
    def travelled(self) -> float:
        """How far the states drift in the run: what is far less of a place is rounding."""
        return float(np.abs((self.run.final_state - self.run.raw.step_states[0])[self.places]).max())

    @property
    def rounding(self) -> float:
        """What of a difference between the places is rounding, as of two bodies that turn as one."""
        return DIFFERENCE_ROUNDING * float(np.abs(self.run.raw.step_states[:, self.places]).max())

    @property
    def section(self) -> tuple[Any, int]:
        """Where the first coordinate is ahead of its mean motion most; without coordinates, where the first
        state that does not drift falls below its mean, or the first angle begins a turn."""
        automaton, run = self.run.automaton, self.run
        n, states = automaton.coordinates, automaton.states
        if n:
            level = (run.final_state[0] - run.raw.step_states[0][0]) / run.raw.t if 0 in self.places else 0.0
            return states[n] - float(level), -1
        resting = [i for i in range(len(states)) if i not in self.places]
        if not resting:
            return sympy.sin(states[self.places[0]]), 1
        mean = run(_sample_times(run)).mean(axis=0)
        return states[resting[0]] - float(mean[resting[0]]), -1


def drift_of(run: Trajectory) -> Drift | None:
    """The shifts of a run's drifting states that change nothing; None where there are none."""
    places = drifting_states(run)
    return shifts_without_effect(run, places) if places else None


def shifts_without_effect(run: Trajectory, places: list[int]) -> Drift | None:
    """The shifts of some states, at least one, that change nothing in a run; None where there are none."""
    across = _directions_across(run, places)
    if across.shape[1] < len(places):
        return Drift(run, places, across, np.zeros((len(places), 0)))
    angles = [k for k, i in enumerate(places) if _is_same_after(run, [i], TURN)]
    rest, basis = [k for k in range(len(places)) if k not in angles], np.eye(len(places))
    for k in rest if len(places) > 1 else []:  # all of them turn together
        shift = _common_turn(run, places, k)
        if _is_same_after(run, places, shift):
            basis[k] -= shift / TURN
            basis[k, k] = 1.0
            rest.remove(k)
            angles.append(k)
            break
    return Drift(run, places, basis[:, rest], basis[:, angles]) if angles else None


def _common_turn(run: Trajectory, places: list[int], angle: int) -> Array:
    """How far states that drift move while one of them, `places[angle]`, makes a turn, as with gears.

    From their mean motion, corrected by Newton's method so that all functions are as before the turn.
    """
    change = (run.final_state - run.raw.step_states[0])[places]
    shift = TURN / change[angle] * change
    others = [k for k in range(len(places)) if k != angle]
    slopes = np.concatenate([np.concatenate(each) for each in _along_run(run, _gradients, places)])
    before = _along_run(run, _values, places, 0.0)
    for _ in range(TURN_CORRECTIONS):
        pairs = zip(_along_run(run, _values, places, shift), before, strict=True)
        missed = np.concatenate([(later - values).T.ravel() for later, values in pairs])
        shift[others] -= np.linalg.lstsq(slopes[:, others], missed)[0]
    return shift


def _directions_across(run: Trajectory, places: list[int]) -> Array:
    """A basis (k, r) of the directions of these states along which some function changes."""
    rows = np.vstack([rows for gradients in _along_run(run, _gradients, places) for rows in gradients])
    size = np.abs(rows).max(axis=1, keepdims=True)
    rows = rows[size[:, 0] > 0] / size[size[:, 0] > 0]
    if not len(rows):
        return np.zeros((len(places), 0))
    _, spread, directions = np.linalg.svd(rows.T @ rows)
    return directions[spread > INVARIANCE_RTOL * spread[0]].T


def _is_same_after(run: Trajectory, places: list[int], shift: Any) -> bool:
    """Whether all functions are the same after a shift of these states."""
    pairs = zip(_along_run(run, _values, places, 0.0), _along_run(run, _values, places, shift), strict=True)
    for values, later in pairs:
        size = np.abs(values).max(axis=0)
        if (np.abs(later - values) > INVARIANCE_RTOL * np.where(size > 0, size, 1.0)).any():
            return False
    return True


def _along_run(run: Trajectory, what: Callable[..., Any], places: list[int], *shift: Any) -> list[Any]:
    """`what` in each mode that the run visits, at states (N, m) in it."""
    automaton = run.automaton
    states, modes = run.states_and_modes(_sample_times(run))
    return [
        what(automaton, automaton.mode(run.mode_names[mode]), places, states[modes == mode], *shift)
        for mode in np.unique(modes)
    ]


def _sample_times(run: Trajectory) -> Array:
    return np.linspace(0.0, run.raw.t, 1 + TREND_PARTS * SAMPLES)


def _values(automaton: HybridAutomaton, mode: Mode, places: list[int], states: Array, shift: Any) -> Array:
    """The mode's functions (N, f) after a shift of some states."""
    shifted = states.copy()
    shifted[:, places] += shift
    return _evaluate(automaton, _functions(mode, automaton.states, tuple(places)), shifted)


def _gradients(automaton: HybridAutomaton, mode: Mode, places: list[int], states: Array) -> list[Array]:
    """Derivatives by some states: for each of the mode's functions (N, k)."""
    functions = _functions(mode, automaton.states, tuple(places))
    entries, slopes = _formulas(automaton, functions).jacobian(places)
    columns = {place: k for k, place in enumerate(places)}
    values = np.zeros((len(functions), len(states), len(places)))
    for (row, place), slope in zip(entries, _evaluated(automaton, slopes, states), strict=True):
        values[row, :, columns[place]] = slope
    return list(values)


def _evaluate(automaton: HybridAutomaton, functions: tuple[Any, ...], states: Array) -> Array:
    values = _evaluated(automaton, _formulas(automaton, functions), states)
    return np.stack([np.broadcast_to(value, len(states)) for value in values], axis=1).astype(float)


def _evaluated(automaton: HybridAutomaton, formulas: Formulas, states: Array) -> list[Any]:
    with np.errstate(all="ignore"):
        return formulas.along_run(*states.T, *automaton.parameters.values())


def _formulas(automaton: HybridAutomaton, functions: tuple[Any, ...]) -> Formulas:
    return _remembered_formulas((*automaton.states, *automaton.parameters), functions)


@lru_cache(maxsize=64)
def _remembered_formulas(inputs: tuple[Any, ...], functions: tuple[Any, ...]) -> Formulas:
    return formulas_of(inputs, functions)


def _functions(mode: Mode, states: Sequence[Any], places: tuple[int, ...]) -> tuple[Any, ...]:
    """All that says how a mode goes on; of states that are shifted and jump, how far they jump."""
    shifted = {states[i] for i in places}
    expressions = [*mode.flow, *mode.constraints]
    for event in mode.events:
        expressions.append(event.function)
        for reset in filter(None, (event.reset, event.accumulation)):
            expressions += [value - x if x in shifted else value for x, value in reset.jump.items()]
    return tuple(sympy.sympify(one, strict=True) for one in expressions)
