"""The arrays of many runs of one structure, and of the lanes in which some of them step side by side.

`BatchRuns` has a row for each run; `Lanes` holds the runs that step together, with the lane as the last axis
of its arrays.  The kernels are in :mod:`frictionlab.hybrid.ensemble.lanes`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.codegen.jet_codegen import CONTROL_ROWS, GUARD_TOL, LOG_TOL, TOL, lane_count
from frictionlab.hybrid.codegen.native_cache import NativeCode, native_code
from frictionlab.hybrid.kernels import run_state, step_length
from frictionlab.hybrid.kernels.run_state import jet_columns, most_impacts, new_record, new_scratch
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Problem
from frictionlab.tape.functions import POWER, QUOTIENT
from frictionlab.tape.program import Code, Numbers, Program

FREE = -1  # stands for no run, and for no slot
CACHE_LINE_BYTES = 64  # bytes


@dataclass(frozen=True, eq=False)
class Batch:
    """Runs that can be advanced repeatedly, with the program and method that they share."""

    program: Program
    method: Taylor
    order: int  # of the series
    native: NativeCode
    runs: BatchRuns
    lanes: Lanes
    record: run_state.Record
    scratch: run_state.Scratch
    alone: tuple[Problem, ...] = ()  # the problem of each run, where modes are derived on demand


def new_batch(problems: Sequence[Problem], method: Taylor) -> Batch:
    """Runs at time 0 of problems that share a program."""
    constants, terms = (np.array(rows) for rows in zip(*(problem.numbers for problem in problems)))
    numbers, states = Numbers(constants, terms), np.array([problem.x0 for problem in problems])
    program, order = problems[0].program, method.order_of(problems[0].program)
    code = program.code
    return Batch(
        program,
        method,
        order,
        native_code(program),
        _new_runs(program, numbers, states, method, [problem.chatter for problem in problems]),
        _new_lanes(program, numbers, method, order),
        new_record(code, 1, 1 + most_impacts(code), 0),
        new_scratch(program.slots, code, order),
        tuple(problems) if problems[0].derive is not None else (),
    )


def select_runs(group: Batch, which: np.ndarray) -> Batch:
    """A batch of some of the runs."""
    shared = ("signs", "caps", "queue", "first", "queued")
    rows = {name: array[which] for name, array in group.runs._asdict().items() if name not in shared}
    queue = np.zeros((len(group.runs.queued), len(rows["status"])), dtype=np.int64)
    alone = tuple(group.alone[i] for i in np.arange(len(group.runs.status))[which]) if group.alone else ()
    return replace(group, runs=group.runs._replace(**rows, queue=queue), alone=alone)


def _new_runs(
    program: Program, numbers: Numbers, states: np.ndarray, method: Taylor, limits: Sequence[float]
) -> BatchRuns:
    count, modes = len(states), len(program.modes)
    counts = np.zeros((count, run_state.COUNTS), dtype=np.int64)
    counts[:, run_state.JETS_READY] = 1
    counts[:, run_state.STOPS_AT_ZENO] = method.accumulation == "raise"
    times = np.zeros((count, run_state.RESOLUTION + 1))
    times[:, run_state.CHATTER] = limits
    return BatchRuns(
        states=states.copy(),
        sizes=np.abs(states),
        times=times,
        counts=counts,
        signs=np.zeros(0, dtype=np.int64),
        constants=numbers.constants,
        terms=numbers.terms,
        sizes_of_constants=np.abs(numbers.constants),
        sizes_of_terms=np.abs(numbers.terms),
        totals=np.zeros((count, 2), dtype=np.int64),
        caps=np.array([method.max_steps, method.max_events]),
        status=np.full(count, run_state.RUNNING),
        undefined=np.zeros(count, dtype=np.int64),
        zeros=np.zeros((count, most_guards(program.code))),
        queue=np.zeros((modes, count), dtype=np.int64),
        first=np.zeros(modes, dtype=np.int64),
        queued=np.zeros(modes, dtype=np.int64),
    )


def _new_lanes(program: Program, numbers: Numbers, method: Taylor, order: int) -> Lanes:
    count = lane_count()
    control = aligned_zeros(CONTROL_ROWS + most_guards(program.code), count)
    control[TOL], control[LOG_TOL] = method.tol, step_length.log2_of_tolerance(method.tol)
    control[GUARD_TOL] = method.tol * step_length.FUNCTION_TOL_FACTOR
    constants = aligned_zeros(numbers.constants.shape[1], count)
    terms = aligned_zeros(numbers.terms.shape[1], count)
    constants[:], terms[:] = numbers.constants[0, :, None], numbers.terms[0, :, None]
    first_terms = np.cumsum([0, *(len(tape.terms) for tape in program.tapes)])
    return Lanes(
        runs=np.full(count, FREE),
        guards=np.zeros(count, dtype=np.int64),
        multiplicities=np.zeros(count, dtype=np.int64),
        needed=needed_slots(program),
        own_constants=_own_numbers(numbers.constants, program.code.mode_ops),
        own_terms=_own_numbers(numbers.terms, first_terms),
        counts=np.zeros(run_state.COUNTS, dtype=np.int64),
        z=aligned_zeros(program.code.inputs, count),
        constants=constants,
        terms=terms,
        jets=aligned_zeros(program.slots, jet_columns(order), count),
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
    caps: np.ndarray  # (2,) most steps and events
    status: np.ndarray
    undefined: np.ndarray  # (runs,) whether the base of a power may have been negative at a step
    zeros: np.ndarray  # (runs, guards of a mode) leading coefficients that count as zero in the next step
    queue: np.ndarray  # (modes, runs), a ring for each mode
    first: np.ndarray  # (modes,) place of the run that has waited longest
    queued: np.ndarray  # (modes,) how many wait


class Lanes(NamedTuple):
    """The runs that step together; the last axis is the lane, but for the slots."""

    runs: np.ndarray  # index of the run in each lane, FREE where there is none
    guards: np.ndarray  # that end the steps, NO_GUARD where none does
    multiplicities: np.ndarray  # of these guards' zeros
    needed: np.ndarray  # (modes, slots) slots whose jets are needed besides those of guards, then FREE
    own_constants: np.ndarray  # (modes, most) those of each mode that differ among runs, then FREE
    own_terms: np.ndarray
    counts: np.ndarray  # scratch: those of a run before its event
    z: np.ndarray
    constants: np.ndarray
    terms: np.ndarray
    jets: np.ndarray
    control: np.ndarray


def most_guards(code: Code) -> int:
    """Largest number of guards that a mode has, 1 at least."""
    return max(1, int(np.diff(code.mode_guards).max()))


def needed_slots(program: Program) -> np.ndarray:
    """For each mode the slots whose jets the majorants need."""
    needed = np.full((len(program.modes), program.slots), FREE)
    for mode, tape in enumerate(program.tapes[: len(program.modes)]):
        slots: set[int] = set()
        for i, (kind, a, b) in enumerate(tape.ops):
            if kind >= QUOTIENT:
                slots |= {tape.inputs + i, a if kind == POWER else b}
        needed[mode, : len(slots)] = sorted(slots)
    return needed


def _own_numbers(numbers: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """For each mode the numbers (runs, numbers), within its `bounds`, that are not the same in all runs."""
    bits = numbers.view(np.int64)
    differ = np.flatnonzero((bits != bits[0]).any(axis=0))
    each = [differ[(first <= differ) & (differ < last)] for first, last in pairwise(bounds)]
    own = np.full((len(each), 1 + max(map(len, each))), FREE)
    for row, which in zip(own, each):
        row[: len(which)] = which
    return own


def aligned_zeros(*shape: int) -> np.ndarray:
    """Zeros that begin at the start of a cache line, so that no vector of lanes lies across two lines."""
    size = int(np.prod(shape))
    room = np.zeros(size + CACHE_LINE_BYTES // 8)
    first = -room.ctypes.data % CACHE_LINE_BYTES // 8
    return room[first : first + size].reshape(shape)
