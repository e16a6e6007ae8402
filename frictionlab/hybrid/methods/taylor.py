"""The Taylor method, and its short cut for scenes without any nonlinearity.

The short cut is for a mode that nothing ends and whose rates are affine in the states.  There the state
changes by the same affine map in every step of one length.  The map is computed once, from the Taylor series
of the unit states, and kept for the next run with the same numbers.  A step is then a product with a matrix.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, lru_cache
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel, prepare_arrays
from frictionlab.hybrid.kernels import run_state, taylor_steps
from frictionlab.hybrid.kernels.arithmetic import PARTS, add_change
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.kernels.jets import MAX_ORDER, copy_vector, mode_jets
from frictionlab.hybrid.kernels.run_state import (
    JETS_READY,
    NOW,
    RUNNING,
    STALLED,
    STEPS,
    Truncation,
    advance_clock,
    remaining_time,
)
from frictionlab.hybrid.kernels.step_length import step_length
from frictionlab.hybrid.kernels.taylor_steps import advance_taylor
from frictionlab.hybrid.methods.base import ActiveRun, Method, SpareArrays
from frictionlab.tape.functions import AFFINE
from frictionlab.tape.program import Code, Numbers, Program
from frictionlab.validation import check_choice, check_field, explains_fields

MIN_STEP_SHARE = 0.5  # least length of the map's step, as a share of a Taylor step
DOUBLINGS, MOST_DOUBLED_STATES = 3, 32  # maps of up to 8 steps, where there are not more states
AFFINE_ORDER = 28  # least order of maps: a step costs the same at each, so a loose tolerance means long steps
LARGEST_POWER = 280  # decimal exponent of a step's power; numbers end at 1e308, and near 1e-308
AFFINE_STATE_LIMIT = 1e200  # larger states are left to the Taylor steps, which deal with overflow


UNKNOWN = -1.0  # length of the step of a map that is yet to be computed

SPARE_MAPS = SpareArrays()


class AffineMap(NamedTuple):
    """Maps of 1, 2, 4 ... steps, z(t + 2^k h) = z(t) + matrix[k]^T z(t) + shift[k], and scratch arrays."""

    matrix: np.ndarray  # (maps, states, states), row i: by how much state i before changes each state
    shift: np.ndarray  # (maps, states)
    rows: np.ndarray  # (2^(maps - 1) + 1, states) states at the starts of a block of steps, and at its end
    zeros: np.ndarray  # (operations,) the constants of the tape that is without them
    length: np.ndarray  # (1,) of the step (s); UNKNOWN, or 0 where a number of the map is not finite


@lru_cache(maxsize=64)
def is_affine(program: Program) -> bool:
    """Whether one map serves for all steps: it is free, with affine operations only."""
    plain = all(kind == AFFINE for tape in program.tapes for kind, _, _ in tape.ops)
    return plain and len(program.modes) == 1 and program.steps_follow_states


def new_affine_map(code: Code) -> AffineMap:
    """Empty arrays for the maps of a program.

    A map's square takes as long as a step for each state, so many states have the map of one step only.
    """
    n = code.inputs
    maps = 1 + (DOUBLINGS if n <= MOST_DOUBLED_STATES else 0)
    rows = np.zeros((2 ** (maps - 1) + 1, n))
    room = np.zeros((maps, n, n)), np.zeros((maps, n)), rows, np.zeros(len(code.ops))
    return AffineMap(*room, np.full(1, UNKNOWN))


@inlined
def step_from(code, numbers, truncation, start, J):
    """Longest step that suits the series from the state `start`."""
    mode_jets(code, numbers, 0, truncation.order, start, J)
    return step_length(code, truncation.order, truncation.tol, J)


@inlined
def select_unit_state(i, z):
    """Make the state `z` zero but for the component `i`, which is one."""
    for j in range(z.shape[0]):
        z[j] = 1.0 if i == j else 0.0


@inlined
def change_in_step(J, order, h, change):
    """Write the change of the states in a step along the jets.

    The state at the start is not added, so that slow motions keep all digits.
    """
    for i in range(change.shape[0]):
        total = J[i, order]
        for k in range(order - 1, 0, -1):
            total = total * h + J[i, k]
        change[i] = total * h


@kernel
def fill_affine_map(system, truncation, change, scratch):
    """Compute the map of a step that suits every state, by the series of the unit states, and its length."""
    code, order, start, J = system.code, truncation.order, scratch.states, scratch.jets
    linear = Numbers(change.zeros, system.numbers.terms)
    h = math.inf
    for i in range(code.inputs):
        select_unit_state(i, start)
        h = min(h, step_from(code, linear, truncation, start, J))
    select_unit_state(-1, start)
    mode_jets(code, system.numbers, 0, order, start, J)
    change_in_step(J, order, h, change.shift[0])
    size = largest_magnitude(change.shift[0])
    for i in range(code.inputs):
        select_unit_state(i, start)
        mode_jets(code, linear, 0, order, start, J)
        change_in_step(J, order, h, change.matrix[0, i])
        size = max(size, largest_magnitude(change.matrix[0, i]))
    for k in range(1, change.matrix.shape[0]):
        double_map(change, k)
    change.length[0] = h if size < math.inf else 0.0


@inlined
def map_step(system, truncation, change, z, J):
    """Length of the map's step, 0 where such a step is much shorter than one from the state `z`.

    So it is in overdamped scenes once fast motions have decayed.
    """
    h = change.length[0]
    return h if h >= MIN_STEP_SHARE * step_from(system.code, system.numbers, truncation, z, J) else 0.0


@inlined
def double_map(change, k):
    """Compute map number `k`: the one of half as many steps is applied to its own shift and rows."""
    before, shift = change.matrix[k - 1], change.shift[k - 1]
    apply_map(before, shift, shift, change.shift[k])
    for i in range(shift.shape[0]):
        apply_map(before, before[i], before[i], change.matrix[k, i])


@inlined
def largest_magnitude(z):
    """Largest absolute value; infinite where one is NaN."""
    size = 0.0
    for value in z:
        size = max(size, abs(value)) if value == value else np.inf
    return size


@inlined
def apply_map(matrix, shift, z, new):
    """Write z + (shift + matrix^T z) into `new`.  The change is summed first, so that z is rounded once."""
    n = z.shape[0]
    fours = n - n % PARTS
    for first in range(0, fours, PARTS):
        add_change(matrix, shift, z, first, new)
    for i in range(fours, n):
        change = shift[i]
        for j in range(n):
            change += matrix[j, i] * z[j]
        new[i] = z[i] + change


@inlined
def map_block(change):
    """Compute the states of a block of steps from the first one.

    Each is one map away from another; few depend on one another, so that a processor computes many at once.
    """
    rows, last = change.rows, change.matrix.shape[0] - 1
    apply_map(change.matrix[last], change.shift[last], rows[0], rows[1 << last])
    for k in range(last):
        half = 1 << k
        for i in range(half):
            apply_map(change.matrix[k], change.shift[k], rows[i], rows[half + i])


@kernel
def advance_affine(system, truncation, change, run, record, scratch):
    """Run until the end or until a buffer is full (RUNNING); the rest at the end by Taylor steps."""
    z, times, counts, rows = run.state, run.times, run.counts, change.rows
    if change.length[0] == UNKNOWN:
        fill_affine_map(system, truncation, change, scratch)
    h = map_step(system, truncation, change, z, scratch.jets)
    counts[JETS_READY] = 0  # the jets at hand have been overwritten
    left = remaining_time(times)
    while 0.0 < h < left and largest_magnitude(z) < AFFINE_STATE_LIMIT:
        room = record.step_modes.shape[0] - counts[STEPS]
        if room == 0:
            return RUNNING
        copy_vector(z, rows[0])
        map_block(change)
        steps, moves = 0, True
        while steps < min(room, rows.shape[0] - 1) and h < left and moves:
            row = counts[STEPS]
            record.step_times[row, 0] = times[NOW]
            record.step_times[row, 1] = h
            record.step_modes[row] = 0
            copy_vector(rows[steps], record.step_states[row])
            counts[STEPS] += 1
            steps += 1
            moves = advance_clock(times, h, left)
            left = remaining_time(times)
        copy_vector(rows[steps], z)
        if not moves:
            return STALLED
    return advance_taylor(system, truncation, run, record, scratch)


@lru_cache(maxsize=64)
def prepared_truncation(order: int, tol: float) -> Truncation:
    """Where series are truncated, prepared for kernels."""
    return prepare_arrays(Truncation(order, tol))


@cache
def longest_step(order: int) -> float:
    """Seconds of the longest step that a series may take: with longer ones, coefficients that are too small
    for floating-point numbers would matter, or powers of the step be too large."""
    return 10.0 ** (LARGEST_POWER / order)


def advance_in_parts(run: ActiveRun, truncation: Truncation, longest: float, record: run_state.Record) -> int:
    """As `advance_taylor`, with no step longer than `longest` (s)."""
    times, t_end, end = run.cursor.times, run.problem.t_end, run_state.FINISHED
    while end == run_state.FINISHED and times[run_state.NOW] < t_end:
        times[run_state.END] = min(times[run_state.NOW] + longest, t_end)
        end = taylor_steps.advance_taylor(run.system, truncation, run.cursor, record, run.scratch)
    times[run_state.END] = t_end
    return end


def advance_by_map(run: ActiveRun, truncation: Truncation, record: run_state.Record) -> int:
    """As `advance_affine`, with the map of the last run if that had the same numbers and truncation."""
    code, numbers = run.system.code, run.system.numbers
    sizes = code.inputs, len(code.ops)
    source, change = SPARE_MAPS.take(sizes, lambda: (None, prepare_arrays(new_affine_map(code))))
    if source is None or source[0] is not numbers or source[1] != truncation:
        change.length[0] = UNKNOWN
    end = advance_affine(run.system, truncation, change, run.cursor, record, run.scratch)
    SPARE_MAPS.give(sizes, ((numbers, truncation), change))
    return end


@cache
def order_of_tolerance(tol: float) -> int:
    """ceil(5 - 0.6 ln(tol)); by decimal numbers, whose logarithm is the same on every machine."""
    return math.ceil(5 - Decimal("0.6") * Decimal(tol).ln())


@cache
def order_of_free_motion(tol: float) -> int:
    """14 - 0.4 ln(tol), rounded up to a multiple of four.

    What a step costs besides its series favours long steps by high orders, if nothing else makes them short.
    Series are computed in blocks of four orders; a lower order would cost as much.
    """
    return PARTS * math.ceil((14 - Decimal("0.4") * Decimal(tol).ln()) / PARTS)


@explains_fields
@dataclass(frozen=True)
class Taylor(Method):
    """Taylor series of high order, with every event found to rounding error.

    Parameters
    ----------
    tol : float
        Relative size of the last terms kept, for coordinates and velocities each by their own scale.
    order : int or None
        Order of the series; None takes ceil(5 - 0.6 ln(tol)), 26 at 1e-15 and 14 at 1e-6; without events,
        sections and integrals 14 - 0.4 ln(tol) rounded up to a multiple of four, 28 and 20, as nothing else
        makes a step short.  Where products dominate the cost, 1 - 0.5 ln(tol) would be cheapest (Jorba & Zou
        2005).  Here much of a step's cost does not depend on the order, which favours higher ones, most of
        all for loose tolerances.  Where one affine map serves for all steps, None takes 28 at least.
    chatter : float or None
        Two flights in a row shorter than this (in seconds) are taken for chatter, and replaced by its limit
        (mode "chatter"); the error is proportional to its square.  None takes 2e-5 of the time in which the
        limit's own motion changes (:mod:`~frictionlab.hybrid.chatter_limit`), 1e-7 s for the paper's model.
        0 computes every flight.  A model without this limit mode has its flights computed down to the
        resolution of time.  When a contact's own acceleration ends two in a row that the clock no longer
        tells apart, the Zeno accumulation of impacts is closed: the gap rate is set to zero.
    accumulation : "close" or "raise"
        Whether to go on after chatter or a Zeno accumulation, counted in ``run.stats``, or end the run there.
    max_steps, max_events : int
        A run that reaches one of these ends with a status and keeps what it has computed.

    Examples
    --------
    >>> import frictionlab as fl
    >>> method = fl.Taylor(tol=1e-6)
    >>> method.degree
    14
    >>> fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05, method=method).events.target.tolist()
    ['stick']
    """

    name: ClassVar[str] = "taylor"
    entry: ClassVar[Any] = staticmethod(taylor_steps.advance_taylor)
    records_sections: ClassVar[bool] = True
    parts: ClassVar[int] = 8
    chatter_share: ClassVar[float] = 2e-5  # 1e-7 s for the paper's model

    tol: float = 1e-15
    order: int | None = None
    chatter: float | None = None
    accumulation: Literal["close", "raise"] = "close"

    def __post_init__(self) -> None:
        check_field(self, "tol", above=0.0, below=0.1, cure="take 1e-15 for full accuracy")
        if self.order is not None:
            check_field(self, "order", integer=True, least=4, most=MAX_ORDER, cure="20 is a good order")
        if self.chatter is not None:
            check_field(self, "chatter", least=0.0, cure="leave it out for a share of the motion's time")
        check_choice("accumulation", self.accumulation, ("close", "raise"))
        self.check_caps()

    @property
    def degree(self) -> int:
        return self.order or order_of_tolerance(self.tol)

    def order_of(self, program: Program) -> int:
        if self.order is not None or not program.steps_follow_states:
            return self.degree
        return max(self.degree, AFFINE_ORDER if is_affine(program) else order_of_free_motion(self.tol))

    def handle_event(self, run: ActiveRun, event: GuardZero, record: run_state.Record) -> int:
        return run.handle_event(Truncation(self.degree, self.tol), event, record)

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        truncation = prepared_truncation(run.order, self.tol)
        arrays = run.cursor, record, run.scratch
        longest = longest_step(truncation.order)
        if run.problem.t_end > longest:
            return advance_in_parts(run, truncation, longest, record)
        if not is_affine(run.problem.program):
            return taylor_steps.advance_taylor(run.system, truncation, *arrays)
        return advance_by_map(run, truncation, record)
