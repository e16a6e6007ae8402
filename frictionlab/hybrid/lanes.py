"""Kernels for many runs of one structure: those in the same mode take their steps side by side.

Runs wait in a queue for each mode.  Up to WIDTH of the longest queue take seats; a step of all seats is one
call of the mode's native code (:mod:`native_lanes`).  Who meets an event, or anything rare, goes through the
kernels of single runs and to the queue of its next mode, and the seat is given to the next who waits.  Every
run takes the steps that it would take alone, so its numbers depend on no other run.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.arithmetic import call_native_step
from frictionlab.hybrid.bookkeeping import (
    END,
    EVENTS,
    FINISHED,
    MODE,
    NO_ADMISSIBLE_MODE,
    NOW,
    READY,
    RUNNING,
    STEPS,
    Cursor,
    pass_time,
    time_left,
)
from frictionlab.hybrid.compiled import kernel
from frictionlab.hybrid.guards import NOISE
from frictionlab.hybrid.handling import repeated
from frictionlab.hybrid.jets import COLUMNS, copy
from frictionlab.hybrid.layout import Numbers
from frictionlab.hybrid.native_vectors import FINE, LEFT, LENGTH, WIDTH
from frictionlab.hybrid.stepping import advance
from frictionlab.hybrid.transitions import NO_MODE, Rounding, enter

FEW = 2  # fewer than these in a mode go one by one
AT_ONCE = 1000  # calls after which the kernel looks up
CAPPED = -1  # the status of a run that has reached its cap of steps or events
NOBODY = -1


class Runs(NamedTuple):
    """All runs, one row each."""

    states: np.ndarray
    sizes: np.ndarray  # these, times and counts as Cursor has them
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


class Seats(NamedTuple):
    """The runs that step together; the last axis of all arrays is the seat."""

    runs: np.ndarray  # NOBODY where a seat is free
    z: np.ndarray
    constants: np.ndarray
    terms: np.ndarray
    jets: np.ndarray
    control: np.ndarray


@kernel
def cursor_of(runs, i):
    """A run as the kernels of single runs know it."""
    return Cursor(runs.states[i], runs.sizes[i], runs.times[i], runs.counts[i], runs.signs)


@kernel
def settled(runs, i, status):
    """Note how a step ended; True where the run is over."""
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
def wait_for_mode(runs, i):
    """Put a run into the queue of its mode."""
    mode = runs.counts[i, MODE]
    runs.queue[mode, runs.queued[mode]] = i
    runs.queued[mode] += 1


@kernel
def alone(code, order, tol, runs, i, most, record, work):
    """Up to `most` steps of one run, and on while its jets are at hand; then it waits, or is over."""
    numbers = Numbers(runs.constants[i], runs.terms[i])
    absolute = Numbers(runs.sizes_of_constants[i], runs.sizes_of_terms[i])
    cursor = cursor_of(runs, i)
    while most > 0 or runs.counts[i, READY]:
        most -= 1  # the record has room for one step
        status = advance(code, numbers, absolute, order, tol, cursor, record, work)
        if settled(runs, i, status):
            return
    wait_for_mode(runs, i)


@kernel
def begin(code, order, tol, runs, i, initial, record, work):
    """Choose the first mode of a run, and take its first step."""
    numbers = Numbers(runs.constants[i], runs.terms[i])
    absolute = Numbers(runs.sizes_of_constants[i], runs.sizes_of_terms[i])
    work.declared[:] = 0
    z, declared = runs.states[i], work.declared
    arrays = declared, work.zeros, work.jets, work.bounds
    mode = enter(code, numbers, absolute, initial, z, Rounding(z, NOISE), order, *arrays)
    runs.counts[i, MODE], runs.counts[i, READY] = mode, 1
    if mode == NO_MODE:
        runs.status[i] = NO_ADMISSIBLE_MODE
    else:
        alone(code, order, tol, runs, i, 0, record, work)


@kernel
def begin_runs(code, order, tol, runs, which, initial, record, work):
    """Begin some of them."""
    for i in which:
        begin(code, order, tol, runs, i, initial, record, work)


@kernel
def sit(runs, seats, seat, i):
    """Give a run a seat."""
    seats.runs[seat] = i
    copy(runs.states[i], seats.z[:, seat])
    copy(runs.constants[i], seats.constants[:, seat])
    copy(runs.terms[i], seats.terms[:, seat])


@kernel
def fill(runs, seats, mode):
    """Give free seats to who waits; returns how many are taken."""
    taken = 0
    for seat in range(WIDTH):
        if seats.runs[seat] == NOBODY and runs.queued[mode] > 0:
            runs.queued[mode] -= 1
            sit(runs, seats, seat, runs.queue[mode, runs.queued[mode]])
        if seats.runs[seat] != NOBODY:
            taken += 1
            i = seats.runs[seat]
            seats.control[LEFT, seat] = time_left(runs.times[i])
    return taken


@kernel
def stand_up(runs, seats):
    """Free all seats; who sat there waits again."""
    for seat in range(WIDTH):
        i = seats.runs[seat]
        if i != NOBODY:
            copy(seats.z[:, seat], runs.states[i])
            wait_for_mode(runs, i)
        seats.runs[seat] = NOBODY


@kernel
def moved(runs, seats, seat):
    """Note a step that was fine."""
    i = seats.runs[seat]
    goes_on = pass_time(runs.times[i], seats.control[LENGTH, seat], seats.control[LEFT, seat])
    runs.counts[i, STEPS] = 1
    if settled(runs, i, RUNNING if goes_on else repeated(runs.counts[i])):
        copy(seats.z[:, seat], runs.states[i])
        seats.runs[seat] = NOBODY


@kernel
def on_its_own(code, order, tol, runs, seats, seat, record, work):
    """The rest of a step that was not fine, from the jets that are there."""
    i = seats.runs[seat]
    seats.runs[seat] = NOBODY
    for slot in range(work.jets.shape[0]):
        copy(seats.jets[slot, : order + 1, seat], work.jets[slot])
    work.zeros[:] = 0
    copy(seats.z[:, seat], runs.states[i])
    runs.counts[i, READY] = 1
    alone(code, order, tol, runs, i, 0, record, work)


@kernel
def together(code, order, tol, runs, seats, mode, record, work):
    """Steps of the runs in a mode, until few are left in it; returns how many calls it took."""
    calls = 0
    while calls < AT_ONCE and fill(runs, seats, mode) >= FEW:
        calls += 1
        arrays = seats.z, seats.constants, seats.terms, seats.jets, seats.control
        call_native_step(code.lanes[mode], *arrays, order)
        for seat in range(WIDTH):
            if seats.runs[seat] == NOBODY:
                continue
            if seats.control[FINE, seat] != 0.0:
                moved(runs, seats, seat)
            else:
                on_its_own(code, order, tol, runs, seats, seat, record, work)
    stand_up(runs, seats)
    return calls


@kernel
def advance_runs(code, order, tol, runs, seats, record, work, rounds):
    """Go on for about so many steps; returns whether any run is left."""
    while rounds > 0:
        mode = 0
        for other in range(1, runs.queued.shape[0]):
            if runs.queued[other] > runs.queued[mode]:
                mode = other
        if runs.queued[mode] == 0:
            return False
        if code.lanes[mode] != 0 and seats.jets.shape[1] == COLUMNS and runs.queued[mode] >= FEW:
            rounds -= WIDTH * together(code, order, tol, runs, seats, mode, record, work)
        else:
            runs.queued[mode] -= 1
            alone(code, order, tol, runs, runs.queue[mode, runs.queued[mode]], 20, record, work)
            rounds -= 20
    return True
