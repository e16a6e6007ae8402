"""Runs of one structure under way: their arrays, as the kernels of lanes take them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from frictionlab.hybrid import bookkeeping, lanes, step_length
from frictionlab.hybrid.buffers import aligned, columns, new_record, new_work
from frictionlab.hybrid.layout import Numbers, Program
from frictionlab.hybrid.native_vectors import GUARD_TOL, LOG_TOL, ROWS, TOL, WIDTH
from frictionlab.hybrid.natives import Natives, natives
from frictionlab.hybrid.taylor import Taylor


@dataclass(frozen=True, eq=False)
class UnderWay:
    """Runs that can be taken on and on, with what they share."""

    program: Program
    method: Taylor
    native: Natives
    runs: lanes.Runs
    seats: lanes.Seats
    record: bookkeeping.Record
    work: bookkeeping.Work


def under_way(program: Program, numbers: Numbers, states: np.ndarray, method: Taylor) -> UnderWay:
    """Runs at time 0; `numbers` and `states` have a row for each."""
    code, order = program.code, method.degree
    return UnderWay(
        program,
        method,
        natives(program),
        _runs(program, numbers, states, method),
        _seats(program, numbers, method),
        new_record(code, 1, 2, 0),
        new_work(program.slots, code, order),
    )


def kept(group: UnderWay, which: np.ndarray) -> UnderWay:
    """Some of the runs, which go on without the others."""
    shared = ("signs", "caps", "queue", "queued")
    rows = {name: array[which] for name, array in group.runs._asdict().items() if name not in shared}
    queue = np.zeros((len(group.runs.queued), len(rows["status"])), dtype=np.int64)
    return replace(group, runs=group.runs._replace(**rows, queue=queue))


def _runs(program: Program, numbers: Numbers, states: np.ndarray, method: Taylor) -> lanes.Runs:
    count, modes = len(states), len(program.modes)
    counts = np.zeros((count, bookkeeping.COUNTS), dtype=np.int64)
    counts[:, bookkeeping.READY], counts[:, bookkeeping.RAISES] = 1, method.raises
    return lanes.Runs(
        states=states.copy(),
        sizes=np.abs(states),
        times=np.tile(bookkeeping.times_of(0.0, method.limits), (count, 1)),
        counts=counts,
        signs=np.zeros(0, dtype=np.int64),
        constants=numbers.constants,
        terms=numbers.terms,
        sizes_of_constants=np.abs(numbers.constants),
        sizes_of_terms=np.abs(numbers.terms),
        totals=np.zeros((count, 2), dtype=np.int64),
        caps=np.array([method.max_steps, method.max_events]),
        status=np.full(count, bookkeeping.RUNNING),
        queue=np.zeros((modes, count), dtype=np.int64),
        queued=np.zeros(modes, dtype=np.int64),
    )


def _seats(program: Program, numbers: Numbers, method: Taylor) -> lanes.Seats:
    control = aligned(ROWS, WIDTH)
    control[TOL], control[LOG_TOL] = method.tol, np.log2(method.tol)
    control[GUARD_TOL] = method.tol * step_length.SLACK
    return lanes.Seats(
        runs=np.full(WIDTH, lanes.NOBODY),
        z=aligned(program.code.inputs, WIDTH),
        constants=aligned(numbers.constants.shape[1], WIDTH),
        terms=aligned(numbers.terms.shape[1], WIDTH),
        jets=aligned(program.slots, columns(method.degree), WIDTH),
        control=control,
    )
