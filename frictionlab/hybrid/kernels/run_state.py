"""The state of a run: its position and clock, its scratch arrays, and the record of its steps and events.

Kernels allocate nothing: a `Record` has room for a given number of steps and events; when it is full a new
one takes its place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.compilation.decorators import inlined
from frictionlab.hybrid.kernels.event_location import RootScratch, new_root_scratch
from frictionlab.hybrid.kernels.jets import JET_COLUMNS
from frictionlab.tape.program import Code, Demand

RUNNING, FINISHED, NO_ADMISSIBLE_MODE, STALLED, ZENO, NOT_FINITE, MODE_NOT_DERIVED, EVENT_PENDING = range(8)

# Most combinations of regimes tried after an event: all those of 6 contacts that stick or slip either way.
MAX_CANDIDATES = 3**6
NO_REGIME = -1
CLOCK_RESOLUTION = 1e-15  # a step of this share of the time changes only the clock's last digits


class CombinationQueue(NamedTuple):
    """Combinations of regimes to be tried as the next mode, where modes are derived on demand."""

    demand: Demand
    rows: np.ndarray  # (MAX_CANDIDATES, parts) in the order in which they are tried
    allowed: np.ndarray  # (regimes,) whether their conditions allow a mode with them
    place: np.ndarray  # (parts,) the last combination taken in the automaton's order
    missing: np.ndarray  # (parts,) scratch, and in the end the combination that is to be derived
    kept: np.ndarray  # (parts,) the regime that an impact is to end at this instant; NO_REGIME elsewhere
    progress: np.ndarray  # (2,) fewest guards that failed, joint changes that may not lower this


class ImpactScratch(NamedTuple):
    """Scratch arrays for the impacts at one instant."""

    guards: np.ndarray  # (impacts,) of the impacts that act
    closing: np.ndarray  # (impacts,) whether each closes a Zeno accumulation
    places: np.ndarray  # (impacts,)
    touching: np.ndarray  # (impacts,) whether guards were zero already after the last event at this instant
    rates: np.ndarray  # (impacts, impacts + 1) how each impact changes the rates of all these guards
    shares: np.ndarray  # (impacts,) of their own impulses by which they act together
    total: np.ndarray  # (states,)


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
    impacts: ImpactScratch


class Truncation(NamedTuple):
    """Where series are truncated: at an order, with last terms of this relative size."""

    order: int
    tol: float


class StepData(NamedTuple):
    """Steps of a run that is over."""

    times: np.ndarray  # (steps, 2) start and length
    modes: np.ndarray  # (steps,)
    states: np.ndarray  # (steps, states) at the start


class RunState(NamedTuple):
    """Where a run stands.

    ``times`` (NOW to RESOLUTION): now, the end, the entry into the mode, the limit below which a flight is
    taken for part of chatter, by how much the sum of the steps is beyond now, and the shortest flight that
    states resolve, 0 for series.  ``counts`` (MODE to
    EVENT_MULTIPLICITY): mode; steps; events; section points; whether the last impact ended a flight too short
    for the clock; flights in a row shorter than the limit of chatter; accumulations closed; other events or
    steps, and impacts, since the clock was advanced; whether the jets are at hand; whether an accumulation
    ends the run; the current cell of a fixed time grid; guard and multiplicity of an event that is yet to be
    handled.  ``sizes``: what the rounding errors of the state at the last event are relative to.  ``signs``:
    the last sign of each section's function.
    """

    state: np.ndarray
    sizes: np.ndarray
    times: np.ndarray
    counts: np.ndarray
    signs: np.ndarray


NOW, END, ENTERED, CHATTER, CARRY, RESOLUTION = range(6)
(
    MODE,
    STEPS,
    EVENTS,
    POINTS,
    SHORT_DWELLS,
    SHORT_FLIGHTS,
    ZENO_COUNT,
    REPEATED,
    IMPACTS,
    JETS_READY,
    STOPS_AT_ZENO,
    CELL,
    EVENT_GUARD,
    EVENT_MULTIPLICITY,
) = range(14)
COUNTS = 14


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


def new_run_state(states: int, sections: int) -> RunState:
    """Empty arrays for a run with so many states and sections."""
    counts, signs = np.zeros(COUNTS, dtype=np.int64), np.zeros(sections, dtype=np.int64)
    return RunState(np.zeros(states), np.zeros(states), np.zeros(RESOLUTION + 1), counts, signs)


@inlined
def remaining_time(times):
    """Time from now to the end."""
    return (times[END] - times[NOW]) - times[CARRY]


@inlined
def advance_clock(times, h, left):
    """Advance the clock by `h`, where `left` remains to the end; returns whether its time has changed.

    The rounding error of the sum is carried to the next step (Knuth's two-sum): steps of nearly equal length
    are rounded nearly alike, and their errors would add up to 2e-8 s in 1e4 s.
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


@inlined
def record_sizes(start, rates, h, run):
    """Note what the state's rounding errors are relative to, after a step `h` from `start` at these rates."""
    for i in range(run.state.shape[0]):
        run.sizes[i] = max(abs(start[i]), abs(run.state[i]), abs(rates[i] * h))


def most_impacts(code: Code) -> int:
    """How many contacts have impacts, so how many events may be recorded at once; 1 at least."""
    impacts = code.resets[:, 0] != code.resets[:, 1]
    contacts = len(np.unique(code.function_classes[: len(impacts)][impacts]))
    each = np.diff(np.concatenate([[0], np.cumsum(impacts)])[code.mode_guards])
    return max(1, contacts, int(each.max(initial=0)))


def new_impact_scratch(code: Code) -> ImpactScratch:
    """Scratch arrays for the impacts of a mode."""
    count = most_impacts(code)
    guards, closing, places, touching = np.zeros((4, count), dtype=np.int64)
    room = np.zeros((count, count + 1)), np.zeros(count), np.zeros(code.inputs)
    return ImpactScratch(guards, closing, places, touching, *room)


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
        impacts=new_impact_scratch(code),
    )


def new_queue(demand: Demand | None) -> CombinationQueue | None:
    """An empty queue; None where all modes are derived."""
    if demand is None:
        return None
    parts, regimes = len(demand.regimes) - 1, demand.regimes[-1]
    rows, allowed = np.zeros((MAX_CANDIDATES, parts), dtype=np.int64), np.zeros(regimes, dtype=np.int64)
    place, missing = np.zeros((2, parts), dtype=np.int64)
    kept, progress = np.full(parts, NO_REGIME), np.zeros(2, dtype=np.int64)
    return CombinationQueue(demand, rows, allowed, place, missing, kept, progress)


def jet_columns(order: int) -> int:
    """Length of a row of jets: that of native code, or longer for orders that only the interpreter has."""
    return max(JET_COLUMNS, order + 1)
