"""Scenes without any nonlinearity: one mode that nothing ends, with rates affine in the states.

In a step of fixed length the state then changes by one and the same affine map.  It is computed once, from
the Taylor series of the unit states, and a step is a product with a matrix.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.bookkeeping import (
    NOW,
    RUNNING,
    STALLED,
    STEPS,
    pass_time,
    time_left,
)
from frictionlab.hybrid.compiled import inlined, kernel
from frictionlab.hybrid.jets import copy, mode_jets
from frictionlab.hybrid.layout import Numbers, Program
from frictionlab.hybrid.step_length import step_length
from frictionlab.hybrid.stepping import advance
from frictionlab.hybrid.tape import AFFINE

WORTH = 0.5  # of the length of a Taylor step
FAR = 1e200  # states beyond are left to the Taylor steps, which see to what overflows


class Change(NamedTuple):
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


def change_of(code, numbers, order: int, tol: float, z: np.ndarray, J: np.ndarray) -> Change | None:
    """The change in a step that suits every state; `numbers` are those of the tape, `J` is scratch.

    None where such steps are much shorter than one from the state `z`: in overdamped scenes, once what
    decays fast has gone.
    """
    linear = Numbers(np.zeros_like(numbers.constants), numbers.terms)
    n = code.inputs
    matrix, shift = np.empty((n, n)), np.empty(n)
    h = longest(code, linear, order, tol, np.eye(n), J)
    if h < WORTH * longest(code, numbers, order, tol, z[None], J):
        return None
    changes(code, linear, order, h, np.eye(n), J, matrix)
    changes(code, numbers, order, h, np.zeros((1, n)), J, shift[:, None])
    return Change(h, matrix, shift)


@kernel
def longest(code, numbers, order, tol, starts, J):
    """Longest step that suits the series of all `starts`."""
    h = np.inf
    for start in starts:
        mode_jets(code, numbers, 0, order, start, J)
        h = min(h, step_length(code, order, tol, J))
    return h


@kernel
def changes(code, numbers, order, h, starts, J, out):
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
def largest_of(z):
    """Largest absolute value; infinite where one is no number."""
    size = 0.0
    for value in z:
        size = max(size, abs(value)) if value == value else np.inf
    return size


@inlined
def take_fixed_step(change, z, new):
    """Move the state on; `new` is scratch."""
    for i in range(z.shape[0]):
        total = change.shift[i]
        for j in range(z.shape[0]):
            total += change.matrix[i, j] * z[j]
        new[i] = z[i] + total
    copy(new, z)


@kernel
def advance_affine(code, numbers, absolute, order, tol, change, cursor, record, work):
    """Run until the end or until a buffer is full (RUNNING); the rest at the end by Taylor steps."""
    z, times, counts = cursor.state, cursor.times, cursor.counts
    left = time_left(times)
    while left > change.h and largest_of(z) < FAR:
        row = counts[STEPS]
        if row == record.step_modes.shape[0]:
            return RUNNING
        record.step_times[row, 0] = times[NOW]
        record.step_times[row, 1] = change.h
        record.step_modes[row] = 0
        copy(z, record.step_states[row])
        counts[STEPS] += 1
        take_fixed_step(change, z, work.before)
        if not pass_time(times, change.h, left):
            return STALLED
        left = time_left(times)
    return advance(code, numbers, absolute, order, tol, cursor, record, work)
