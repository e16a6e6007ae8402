"""The Taylor method, and its short cut for scenes without any nonlinearity.

One mode that nothing ends, with rates affine in the states: in a step of fixed length the state then changes
by one and the same affine map.  It is computed once, from the Taylor series of the unit states, and a step is
a product with a matrix.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels import run_state, taylor_steps
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.kernels.jets import MAX_ORDER, copy_vector, mode_jets
from frictionlab.hybrid.kernels.run_state import (
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
from frictionlab.hybrid.methods.base import ActiveRun, Method
from frictionlab.hybrid.tape.functions import AFFINE
from frictionlab.hybrid.tape.program import Numbers, Program, System
from frictionlab.validation import check_choice, check_number, store_plain_numbers

MIN_STEP_SHARE = 0.5  # of the length of a Taylor step
AFFINE_STATE_LIMIT = 1e200  # states beyond are left to the Taylor steps, which see to what overflows


class AffineMap(NamedTuple):
    """z(t + h) = z(t) + matrix z(t) + shift."""

    h: float
    matrix: np.ndarray
    shift: np.ndarray


def is_affine(program: Program) -> bool:
    """Whether one map serves for all steps: no events, sections or integrals, and affine operations only."""
    code = program.code
    riders = code.sections.size > 0 or code.inputs > code.groups[3]
    plain = all(kind == AFFINE for tape in program.tapes for kind, _, _ in tape.ops)
    return plain and len(program.modes) == 1 and not program.guards and not riders


def affine_map(system: System, truncation: Truncation, z: np.ndarray, J: np.ndarray) -> AffineMap | None:
    """The change in a step that suits every state; `J` is scratch.

    None where such steps are much shorter than one from the state `z`: in overdamped scenes, once what
    decays fast has gone.
    """
    code, numbers, _ = system
    linear = Numbers(np.zeros_like(numbers.constants), numbers.terms)
    n = code.inputs
    matrix, shift = np.empty((n, n)), np.empty(n)
    h = longest_common_step(code, linear, truncation, np.eye(n), J)
    if h < MIN_STEP_SHARE * longest_common_step(code, numbers, truncation, z[None], J):
        return None
    affine_map_columns(code, linear, truncation.order, h, np.eye(n), J, matrix)
    affine_map_columns(code, numbers, truncation.order, h, np.zeros((1, n)), J, shift[:, None])
    finite = np.isfinite(matrix).all() and np.isfinite(shift).all()
    return AffineMap(h, matrix, shift) if finite else None


@kernel
def longest_common_step(code, numbers, truncation, starts, J):
    """Longest step that suits the series of all `starts`."""
    h = np.inf
    for start in starts:
        mode_jets(code, numbers, 0, truncation.order, start, J)
        h = min(h, step_length(code, truncation.order, truncation.tol, J))
    return h


@kernel
def affine_map_columns(code, numbers, order, h, starts, J, out):
    """Write the change from each of the `starts` in a step of length `h` into the columns of `out`.

    Without the start itself, so that slow motions keep all digits.
    """
    for j in range(starts.shape[0]):
        mode_jets(code, numbers, 0, order, starts[j], J)
        for i in range(out.shape[0]):
            total = J[i, order]
            for k in range(order - 1, 0, -1):
                total = total * h + J[i, k]
            out[i, j] = total * h


@inlined
def largest_magnitude(z):
    """Largest absolute value; infinite where one is no number."""
    size = 0.0
    for value in z:
        size = max(size, abs(value)) if value == value else np.inf
    return size


@inlined
def apply_affine_map(change, z, new):
    """Move the state on; `new` is scratch."""
    for i in range(z.shape[0]):
        total = change.shift[i]
        for j in range(z.shape[0]):
            total += change.matrix[i, j] * z[j]
        new[i] = z[i] + total
    copy_vector(new, z)


@kernel
def advance_affine(system, truncation, change, run, record, scratch):
    """Run until the end or until a buffer is full (RUNNING); the rest at the end by Taylor steps."""
    z, times, counts = run.state, run.times, run.counts
    left = remaining_time(times)
    while left > change.h and largest_magnitude(z) < AFFINE_STATE_LIMIT:
        row = counts[STEPS]
        if row == record.step_modes.shape[0]:
            return RUNNING
        record.step_times[row, 0] = times[NOW]
        record.step_times[row, 1] = change.h
        record.step_modes[row] = 0
        copy_vector(z, record.step_states[row])
        counts[STEPS] += 1
        apply_affine_map(change, z, scratch.states)
        if not advance_clock(times, change.h, left):
            return STALLED
        left = remaining_time(times)
    return advance_taylor(system, truncation, run, record, scratch)


@cache
def order_of_tolerance(tol: float) -> int:
    """ceil(1 - 0.7 ln(tol)), 4 at least; by decimal numbers, whose logarithm is the same everywhere."""
    return max(4, math.ceil(1 - Decimal("0.7") * Decimal(tol).ln()))


@dataclass(frozen=True)
class Taylor(Method):
    """Taylor series of high order, with every event found to rounding error.

    Parameters
    ----------
    tol : float
        Relative size of the last terms kept, for coordinates and velocities each by their own scale.
    order : int or None
        Order of the series; None takes ceil(1 - 0.7 ln(tol)), 26 at 1e-15.  Where products dominate the
        cost, 0.5 would be cheapest (Jorba & Zou 2005); these models are mostly affine, which favours more.
    chatter : float
        Two flights in a row shorter than this (in seconds) are taken for chatter, and replaced by its limit
        (mode "chatter"); the error is proportional to its square.  0 computes every flight.
    dwell : float
        Two flights in a row shorter than this (in seconds), where there is no such limit, are taken for a
        Zeno accumulation of impacts, which is closed: the gap rate is set to zero.
    accumulation : "close" or "raise"
        Whether to go on after chatter or a Zeno accumulation, counted in ``run.stats``, or end the run there.
    max_steps, max_events : int
        A run that reaches one ends with a status and keeps what it has.

    Examples
    --------
    >>> import frictionlab as fl
    >>> method = fl.Taylor(tol=1e-6)
    >>> method.degree
    11
    >>> fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05, method=method).events.target.tolist()
    ['stick']
    """

    name: ClassVar[str] = "taylor"
    entry: ClassVar[Any] = staticmethod(taylor_steps.advance_taylor)
    riders: ClassVar[bool] = True
    parts: ClassVar[int] = 8

    tol: float = 1e-15
    order: int | None = None
    chatter: float = 1e-7
    dwell: float = 1e-12
    accumulation: Literal["close", "raise"] = "close"

    def __post_init__(self) -> None:
        store_plain_numbers(self)
        check_number("tol", self.tol, above=0.0, below=0.1, cure="take 1e-15 for full accuracy")
        if self.order is not None:
            check_number(
                "order", self.order, integer=True, least=4, most=MAX_ORDER, cure="20 is a good order"
            )
        check_number("chatter", self.chatter, least=0.0, cure="1e-7 s is the default")
        check_number("dwell", self.dwell, least=0.0, cure="1e-12 s is the default")
        check_choice("accumulation", self.accumulation, ("close", "raise"))
        self.check_caps()

    @property
    def degree(self) -> int:
        return self.order or order_of_tolerance(self.tol)

    @property
    def limits(self) -> tuple[float, float]:
        return self.dwell, self.chatter

    @property
    def raises(self) -> bool:
        return self.accumulation == "raise"

    def handle_event(self, run: ActiveRun, event: GuardZero, record: run_state.Record) -> int:
        return run.handle_event(Truncation(self.degree, self.tol), event, record)

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        cursor, truncation = run.cursor, Truncation(self.degree, self.tol)
        if is_affine(run.problem.program):
            change = affine_map(run.system, truncation, cursor.state, run.scratch.jets)
            cursor.counts[run_state.JETS_READY] = 0  # the jets at hand have been overwritten
            if change is not None:
                return advance_affine(run.system, truncation, change, cursor, record, run.scratch)
        return taylor_steps.advance_taylor(run.system, truncation, cursor, record, run.scratch)
