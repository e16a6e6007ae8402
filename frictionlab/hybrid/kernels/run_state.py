"""The state of a run: its position and clock, its scratch arrays, and the record of its steps and events.

Kernels allocate nothing: a `Record` has room for so many steps and events, and is filled, taken away, and
replaced by a new one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.compilation import inlined
from frictionlab.hybrid.kernels.event_location import RootScratch, new_root_scratch
from frictionlab.hybrid.kernels.jets import JET_COLUMNS
from frictionlab.hybrid.tape.program import Code, Demand

RUNNING, FINISHED, NO_ADMISSIBLE_MODE, STALLED, ZENO, NOT_FINITE, MODE_NOT_DERIVED, EVENT_PENDING = range(8)

# Combinations of regimes tried after an event, most: all of 6 contacts that may stick or slip either way.
MAX_CANDIDATES = 3**6
CLOCK_RESOLUTION = 1e-15  # share of the time that the clock shows as some of its last digits


class CombinationQueue(NamedTuple):
    """Combinations of regimes that come to be tried as the next mode, where modes are derived on demand."""

    demand: Demand
    rows: np.ndarray  # (MAX_CANDIDATES, parts) in the order in which they are tried
    allowed: np.ndarray  # (regimes,) whether their conditions allow to enter a mode
    place: np.ndarray  # (parts,) of the last taken from the automaton's order
    missing: np.ndarray  # (parts,) one that is being made, and in the end the one that is to be derived


class Scratch(NamedTuple):
    """Scratch arrays of a run."""

    jets: np.ndarray  # (slots, columns) at the state where the run stands
    values: np.ndarray  # (slots, columns) of order 0
    bounds: np.ndarray  # (slots, columns) majorants of jets, or ranges of the slots on a disc
    roots: RootScratch
    structural_zeros: np.ndarray  # (classes,) leading coefficients that vanish after the last reset
    ended: (
        np.ndarray
    )  # (2,) the guard that ended the last mode without a reset, -1 for none; its multiplicity
    leading_zeros: np.ndarray  # (guards of a mode,) leading coefficients that count as zero
    states: np.ndarray  # (states,)


class Truncation(NamedTuple):
    """Where series end: at an order, and where their last terms have a relative size."""

    order: int
    tol: float


class StepData(NamedTuple):
    """Steps of a run that is over."""

    times: np.ndarray  # (steps, 2) start and length
    modes: np.ndarray  # (steps,)
    states: np.ndarray  # (steps, states) at the start


class RunState(NamedTuple):
    """Where a run stands.  ``times``: now, end, entry into the mode, limit of the dwell time, that for
    events that have a limit mode, and what the sum of the steps is beyond now;
    ``counts``: mode, steps, events, section points, short dwells in a row by either limit, accumulations
    closed, events without advance, whether the jets are at hand, whether an accumulation ends the run, and
    the number of the current cell of a fixed time grid, and the guard and multiplicity of an event that
    has yet to be handled, or whose mode has yet to be derived;
    ``sizes``: what the rounding errors of the state at the last event are relative to."""

    state: np.ndarray
    sizes: np.ndarray
    times: np.ndarray
    counts: np.ndarray
    signs: np.ndarray


NOW, END, ENTERED, DWELL, CHATTER, CARRY = range(6)
(
    MODE,
    STEPS,
    EVENTS,
    POINTS,
    SHORT_DWELLS,
    SHORT_FLIGHTS,
    ZENO_COUNT,
    REPEATED,
    JETS_READY,
    STOPS_AT_ZENO,
    CELL,
    EVENT_GUARD,
    EVENT_MULTIPLICITY,
) = range(13)
COUNTS = 13


class Record(NamedTuple):
    """Buffers for steps, events and section points."""

    step_times: np.ndarray  # (capacity, 2) start and length
    step_modes: np.ndarray
    step_states: np.ndarray
    event_times: np.ndarray
    event_codes: np.ndarray  # (capacity, 3) guard, mode entered (-1: none), whether an accumulation closed
    event_states: np.ndarray  # (capacity, 2, states) before and after
    point_times: np.ndarray
    point_sections: np.ndarray
    point_states: np.ndarray


def new_run_state(
    state: np.ndarray, mode: int, t_end: float, limits: tuple[float, float], raises: bool
) -> RunState:
    """A run at time 0 in `mode`, whose jets have been computed; without sections."""
    counts = np.zeros(COUNTS, dtype=np.int64)
    counts[MODE], counts[JETS_READY], counts[STOPS_AT_ZENO] = mode, 1, raises
    signs = np.zeros(0, dtype=np.int64)
    return RunState(state.copy(), np.abs(state), initial_times(t_end, limits), counts, signs)


def initial_times(t_end: float, limits: tuple[float, float]) -> np.ndarray:
    """The times of a run at t = 0."""
    return np.array([0.0, t_end, 0.0, *limits, 0.0])


@inlined
def remaining_time(times):
    """From now to the end."""
    return (times[END] - times[NOW]) - times[CARRY]


@inlined
def advance_clock(times, h, left):
    """Go on by `h`, of `left` at most; returns whether the clock shows it.

    What rounding takes from the sum is carried to the next step (Knuth's two-sum): steps of nearly one
    length are rounded nearly alike, which would add up to 2e-8 s in 1e4 s.
    """
    before = times[NOW]
    if h == left:
        times[NOW], times[CARRY] = times[END], 0.0
    else:
        h += times[CARRY]
        now = before + h
        shown = now - before
        times[NOW], times[CARRY] = now, (before - (now - shown)) + (h - shown)
    return times[NOW] > before


def new_record(code: Code, steps: int, events: int, points: int) -> Record:
    """Empty buffers."""
    n = code.inputs
    return Record(
        np.empty((steps, 2)),
        np.empty(steps, dtype=np.int64),
        np.empty((steps, n)),
        np.empty(events),
        np.empty((events, 3), dtype=np.int64),
        np.empty((events, 2, n)),
        np.empty(points),
        np.empty(points, dtype=np.int64),
        np.empty((points, n)),
    )


def new_scratch(slots: int, code: Code, order: int) -> Scratch:
    """Scratch arrays for one run."""
    return Scratch(
        jets=np.zeros((slots, jet_columns(order))),
        values=np.zeros((slots, jet_columns(0))),
        bounds=np.zeros((slots, jet_columns(order))),
        roots=new_root_scratch(order),
        structural_zeros=np.zeros(1 + code.function_classes.max(initial=0), dtype=np.int64),
        ended=np.array([-1, 0]),
        leading_zeros=np.zeros(max(1, int(np.diff(code.mode_guards).max())), dtype=np.int64),
        states=np.zeros(code.inputs),
    )


def new_queue(demand: Demand | None) -> CombinationQueue | None:
    """An empty queue; None where all modes are derived."""
    if demand is None:
        return None
    parts, regimes = len(demand.regimes) - 1, demand.regimes[-1]
    rows, allowed = np.zeros((MAX_CANDIDATES, parts), dtype=np.int64), np.zeros(regimes, dtype=np.int64)
    return CombinationQueue(demand, rows, allowed, *np.zeros((2, parts), dtype=np.int64))


def jet_columns(order: int) -> int:
    """Length of a row of jets: as native code has it, longer for orders that only the interpreter knows."""
    return max(JET_COLUMNS, order + 1)
