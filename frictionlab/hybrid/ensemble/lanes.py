"""Many runs of one structure, their arrays and their kernels: those in the same mode take their steps side by
side.

`BatchRuns` has a row for each run; `Lanes` holds those that step side by side, whose last axis is the lane.
Runs wait in a queue for each mode.  Up to LANE_COUNT of the longest queue are loaded into lanes; a step of
all lanes is one call of the mode's native code (:mod:`frictionlab.hybrid.codegen.step_codegen`).  A run that
meets an event, or anything rare, leaves its lane, goes through the kernels of single runs and to the queue of
its next mode, and the lane is given to the next run in the queue.  Every run takes the steps that it would
take alone, so its numbers depend on no other run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.codegen.jet_codegen import (
    CONTROL_ROWS,
    GUARD_TOL,
    LANE_COUNT,
    LEFT,
    LENGTH,
    LOG_TOL,
    REGULAR,
    TOL,
)
from frictionlab.hybrid.codegen.native_cache import NativeCode, native_code
from frictionlab.hybrid.compilation import kernel
from frictionlab.hybrid.kernels import run_state, step_length
from frictionlab.hybrid.kernels.arithmetic import call_lane_step
from frictionlab.hybrid.kernels.event_handling import count_repeat
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.jets import JET_COLUMNS, copy_vector
from frictionlab.hybrid.kernels.mode_selection import NO_MODE, Rounding, forget_zeros, select_mode
from frictionlab.hybrid.kernels.run_state import (
    END,
    EVENTS,
    FINISHED,
    JETS_READY,
    MODE,
    NO_ADMISSIBLE_MODE,
    NOW,
    RUNNING,
    STEPS,
    RunState,
    advance_clock,
    jet_columns,
    new_record,
    new_scratch,
    remaining_time,
)
from frictionlab.hybrid.kernels.taylor_steps import advance_taylor
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.tape.program import Numbers, Program, System

FREE = -1

CACHE_LINE_BYTES = 64  # bytes


@dataclass(frozen=True, eq=False)
class Batch:
    """Runs that can be advanced repeatedly, with the program and method that they share."""

    program: Program
    method: Taylor
    native: NativeCode
    runs: BatchRuns
    lanes: Lanes
    record: run_state.Record
    scratch: run_state.Scratch
    alone: tuple[Problem, ...] = ()  # of each run, where modes are derived as runs come to them


def new_batch(problems: Sequence[Problem], method: Taylor) -> Batch:
    """Runs at time 0 of problems that share a program."""
    constants, terms = (np.array(rows) for rows in zip(*(problem.numbers for problem in problems)))
    numbers, states = Numbers(constants, terms), np.array([problem.x0 for problem in problems])
    program, order = problems[0].program, method.degree
    code = program.code
    return Batch(
        program,
        method,
        native_code(program),
        _new_runs(program, numbers, states, method),
        _new_lanes(program, numbers, method),
        new_record(code, 1, 2, 0),
        new_scratch(program.slots, code, order),
        tuple(problems) if problems[0].derive is not None else (),
    )


def select_runs(group: Batch, which: np.ndarray) -> Batch:
    """A batch of some of the runs."""
    shared = ("signs", "caps", "queue", "queued")
    rows = {name: array[which] for name, array in group.runs._asdict().items() if name not in shared}
    queue = np.zeros((len(group.runs.queued), len(rows["status"])), dtype=np.int64)
    alone = tuple(group.alone[i] for i in np.arange(len(group.runs.status))[which]) if group.alone else ()
    return replace(group, runs=group.runs._replace(**rows, queue=queue), alone=alone)


def _new_runs(program: Program, numbers: Numbers, states: np.ndarray, method: Taylor) -> BatchRuns:
    count, modes = len(states), len(program.modes)
    counts = np.zeros((count, run_state.COUNTS), dtype=np.int64)
    counts[:, run_state.JETS_READY], counts[:, run_state.STOPS_AT_ZENO] = 1, method.raises
    return BatchRuns(
        states=states.copy(),
        sizes=np.abs(states),
        times=np.tile(run_state.initial_times(0.0, method.limits), (count, 1)),
        counts=counts,
        signs=np.zeros(0, dtype=np.int64),
        constants=numbers.constants,
        terms=numbers.terms,
        sizes_of_constants=np.abs(numbers.constants),
        sizes_of_terms=np.abs(numbers.terms),
        totals=np.zeros((count, 2), dtype=np.int64),
        caps=np.array([method.max_steps, method.max_events]),
        status=np.full(count, run_state.RUNNING),
        queue=np.zeros((modes, count), dtype=np.int64),
        queued=np.zeros(modes, dtype=np.int64),
    )


def _new_lanes(program: Program, numbers: Numbers, method: Taylor) -> Lanes:
    control = aligned_zeros(CONTROL_ROWS, LANE_COUNT)
    control[TOL], control[LOG_TOL] = method.tol, step_length.log2_of_tolerance(method.tol)
    control[GUARD_TOL] = method.tol * step_length.FUNCTION_TOL_FACTOR
    return Lanes(
        runs=np.full(LANE_COUNT, FREE),
        z=aligned_zeros(program.code.inputs, LANE_COUNT),
        constants=aligned_zeros(numbers.constants.shape[1], LANE_COUNT),
        terms=aligned_zeros(numbers.terms.shape[1], LANE_COUNT),
        jets=aligned_zeros(program.slots, jet_columns(method.degree), LANE_COUNT),
        control=control,
    )


class BatchRuns(NamedTuple):
    """All runs, one row each."""

    states: np.ndarray
    sizes: np.ndarray  # these, times and counts as in RunState
    times: np.ndarray
    counts: np.ndarray
    signs: np.ndarray
    constants: np.ndarray
    terms: np.ndarray
    sizes_of_constants: np.ndarray  # absolute values
    sizes_of_terms: np.ndarray
    totals: np.ndarray  # (runs, 2) steps and events
    caps: np.ndarray  # (2,)
    status: np.ndarray
    queue: np.ndarray  # (modes, runs)
    queued: np.ndarray  # (modes,)


class Lanes(NamedTuple):
    """The runs that step together; the last axis of all arrays is the lane."""

    runs: np.ndarray  # index of the run in each lane, FREE where there is none
    z: np.ndarray
    constants: np.ndarray
    terms: np.ndarray
    jets: np.ndarray
    control: np.ndarray


def aligned_zeros(*shape: int) -> np.ndarray:
    """Zeros that begin with a cache line, so that no vector of lanes lies across two."""
    size = int(np.prod(shape))
    room = np.zeros(size + CACHE_LINE_BYTES // 8)
    first = -room.ctypes.data % CACHE_LINE_BYTES // 8
    return room[first : first + size].reshape(shape)


MIN_RUNS_FOR_LANES = 2  # fewer than these in a mode go one by one
SINGLE_STEPS = 20  # steps of a run alone, after which the kernel looks for the longest queue again
MAX_CALLS = 1000  # calls after which the kernel looks up
CAPPED = -1  # the status of a run that has reached its cap of steps or events


@kernel
def run_state_of(runs, i):
    """A run as the kernels of single runs know it."""
    return RunState(runs.states[i], runs.sizes[i], runs.times[i], runs.counts[i], runs.signs)


@kernel
def system_of_run(code, runs, i):
    """The automaton with the values of a run."""
    numbers = Numbers(runs.constants[i], runs.terms[i])
    return System(code, numbers, Numbers(runs.sizes_of_constants[i], runs.sizes_of_terms[i]))


@kernel
def record_step_end(runs, i, status):
    """Record how a step ended; True where the run is over."""
    counts, totals = runs.counts[i], runs.totals[i]
    totals[0] += counts[STEPS]
    totals[1] += counts[EVENTS]
    counts[STEPS] = counts[EVENTS] = 0
    if status == RUNNING and not runs.times[i, NOW] < runs.times[i, END]:
        status = FINISHED
    elif status == RUNNING and (totals[0] >= runs.caps[0] or totals[1] >= runs.caps[1]):
        status = CAPPED
    runs.status[i] = status
    return status != RUNNING


@kernel
def enqueue(runs, i):
    """Put a run into the queue of its mode."""
    mode = runs.counts[i, MODE]
    runs.queue[mode, runs.queued[mode]] = i
    runs.queued[mode] += 1


@kernel
def advance_single(code, truncation, runs, i, most, record, scratch):
    """Up to `most` steps of one run, and on while its jets are at hand; then it waits, or is over."""
    system, run = system_of_run(code, runs, i), run_state_of(runs, i)
    while most > 0 or runs.counts[i, JETS_READY]:
        most -= 1  # the record has room for one step
        status = advance_taylor(system, truncation, run, record, scratch)
        if record_step_end(runs, i, status):
            return
    enqueue(runs, i)


@kernel
def begin_run(code, truncation, runs, i, initial, record, scratch):
    """Choose the first mode of a run, and take its first step."""
    system, z = system_of_run(code, runs, i), runs.states[i]
    forget_zeros(scratch)
    rounding = Rounding(z, COEFFICIENT_ROUNDING)
    mode, _ = select_mode(system, initial, z, rounding, truncation.order, scratch)
    runs.counts[i, MODE], runs.counts[i, JETS_READY] = mode, 1
    if mode == NO_MODE:
        runs.status[i] = NO_ADMISSIBLE_MODE
    else:
        advance_single(code, truncation, runs, i, 0, record, scratch)


@kernel
def begin_runs(code, truncation, runs, which, initial, record, scratch):
    """Begin some of the runs."""
    for i in which:
        begin_run(code, truncation, runs, i, initial, record, scratch)


@kernel
def load_lane(runs, lanes, lane, i):
    """Load a run into a lane."""
    lanes.runs[lane] = i
    copy_vector(runs.states[i], lanes.z[:, lane])
    copy_vector(runs.constants[i], lanes.constants[:, lane])
    copy_vector(runs.terms[i], lanes.terms[:, lane])


@kernel
def load_lanes(runs, lanes, mode):
    """Load runs from the queue of the mode into free lanes; returns the number of occupied lanes."""
    taken = 0
    for lane in range(LANE_COUNT):
        if lanes.runs[lane] == FREE and runs.queued[mode] > 0:
            runs.queued[mode] -= 1
            load_lane(runs, lanes, lane, runs.queue[mode, runs.queued[mode]])
        if lanes.runs[lane] != FREE:
            taken += 1
            i = lanes.runs[lane]
            lanes.control[LEFT, lane] = remaining_time(runs.times[i])
    return taken


@kernel
def release_lanes(runs, lanes):
    """Free all lanes; their runs return to the queue."""
    for lane in range(LANE_COUNT):
        i = lanes.runs[lane]
        if i != FREE:
            copy_vector(lanes.z[:, lane], runs.states[i])
            enqueue(runs, i)
        lanes.runs[lane] = FREE


@kernel
def accept_lane_step(runs, lanes, lane):
    """Record a regular step of a lane."""
    i = lanes.runs[lane]
    goes_on = advance_clock(runs.times[i], lanes.control[LENGTH, lane], lanes.control[LEFT, lane])
    runs.counts[i, STEPS] = 1
    if record_step_end(runs, i, RUNNING if goes_on else count_repeat(runs.counts[i])):
        copy_vector(lanes.z[:, lane], runs.states[i])
        lanes.runs[lane] = FREE


@kernel
def finish_lane_step(code, truncation, runs, lanes, lane, record, scratch):
    """Complete a step that was not regular, from the jets that the lane has computed."""
    i = lanes.runs[lane]
    lanes.runs[lane] = FREE
    for slot in range(scratch.jets.shape[0]):
        copy_vector(lanes.jets[slot, : truncation.order + 1, lane], scratch.jets[slot])
    scratch.leading_zeros[:] = 0
    copy_vector(lanes.z[:, lane], runs.states[i])
    runs.counts[i, JETS_READY] = 1
    advance_single(code, truncation, runs, i, 0, record, scratch)


@kernel
def advance_lanes(code, truncation, runs, lanes, mode, record, scratch):
    """Advance the runs in a mode until few are left in it; returns the number of calls."""
    calls = 0
    while calls < MAX_CALLS and load_lanes(runs, lanes, mode) >= MIN_RUNS_FOR_LANES:
        calls += 1
        arrays = lanes.z, lanes.constants, lanes.terms, lanes.jets, lanes.control
        call_lane_step(code.lanes[mode], *arrays, truncation.order)
        for lane in range(LANE_COUNT):
            if lanes.runs[lane] == FREE:
                continue
            if lanes.control[REGULAR, lane] != 0.0:
                accept_lane_step(runs, lanes, lane)
            else:
                finish_lane_step(code, truncation, runs, lanes, lane, record, scratch)
    release_lanes(runs, lanes)
    return calls


@kernel
def advance_batch_kernel(code, truncation, runs, lanes, record, scratch, rounds):
    """Go on for about so many steps; returns whether any run is left."""
    while rounds > 0:
        mode = 0
        for other in range(1, runs.queued.shape[0]):
            if runs.queued[other] > runs.queued[mode]:
                mode = other
        if runs.queued[mode] == 0:
            return False
        if (
            code.lanes[mode] != 0
            and lanes.jets.shape[1] == JET_COLUMNS
            and runs.queued[mode] >= MIN_RUNS_FOR_LANES
        ):
            rounds -= LANE_COUNT * advance_lanes(code, truncation, runs, lanes, mode, record, scratch)
        else:
            runs.queued[mode] -= 1
            i = runs.queue[mode, runs.queued[mode]]
            advance_single(code, truncation, runs, i, SINGLE_STEPS, record, scratch)
            rounds -= SINGLE_STEPS
    return True
