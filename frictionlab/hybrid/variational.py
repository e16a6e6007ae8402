"""Taylor series of the variational equation: a tape differentiated operation by operation.

An array T of tangent jets has one array of jets (see :mod:`frictionlab.hybrid.jets`) for each direction:
T[d, slot, k] is coefficient k of the slot's derivative in direction d.
"""

from __future__ import annotations

from frictionlab.hybrid.compiled import inlined, kernel
from frictionlab.hybrid.jets import AFFINE, PRODUCT, SQUARE, copy, run_tape, states_at
from frictionlab.hybrid.stepping import step_length

SHORTEST = 1e-9  # share of a run's step below which the series of its tangents are taken to diverge


@inlined
def cross(J, a, D, b, first, k):
    """Sum of J[a, j] D[b, k - j] over first <= j <= k."""
    total = 0.0
    for j in range(first, k + 1):
        total += J[a, j] * D[b, k - j]
    return total


@kernel
def operation_tangent(code, numbers, op, out, k, J, D):
    """Coefficient k of the derivative `D` of an operation's result, whose jets are `J`."""
    kind, a, b = code.ops[op, 0], code.ops[op, 1], code.ops[op, 2]
    if kind == AFFINE:
        total = 0.0
        for j in range(a, b):
            total += numbers.terms[j] * D[code.term_slots[j], k]
        return total
    if kind == PRODUCT:
        return cross(J, a, D, b, 0, k) + cross(J, b, D, a, 0, k)
    if kind == SQUARE:
        return 2.0 * cross(J, a, D, a, 0, k)
    return (D[a, k] - cross(J, out, D, b, 0, k) - cross(J, b, D, out, 1, k)) / J[b, 0]


@kernel
def tangent_jets(code, numbers, first, last, order, flow, J, T):
    """Tangent jets of the slots that the operations [first, last) write.

    The jets `J` are given, and so is column 0 of the states' tangents; ``flow`` as in ``run_tape``.
    """
    inputs = code.inputs
    for k in range(order + 1):
        for op in range(first, last):
            out = inputs + op - first
            for d in range(T.shape[0]):
                T[d, out, k] = operation_tangent(code, numbers, op, out, k, J, T[d])
        if k < order:
            share = 1.0 / (k + 1)
            for d in range(T.shape[0]):
                for i in range(inputs):
                    T[d, i, k + 1] = T[d, flow[i], k] * share


@kernel
def carry(code, numbers, mode, order, tol, length, z, frame, J, T):
    """Carry the state `z` and the rows of `frame`, tangent vectors, over a time in a mode.

    In as many steps as the tangents need: near an equilibrium the state's series would allow any step.
    Returns whether it got there.
    """
    first, last, flow = code.mode_ops[mode], code.mode_ops[mode + 1], code.flow[mode]
    left = length
    while left > 0.0:
        copy(z, J[: z.shape[0], 0])
        run_tape(code, numbers, first, last, order, flow, -1.0, J, J)
        for d in range(frame.shape[0]):
            copy(frame[d], T[d, : z.shape[0], 0])
        tangent_jets(code, numbers, first, last, order, flow, J, T)
        step = left
        for d in range(frame.shape[0]):
            step = min(step, step_length(code, order, tol, T[d]))
        if not step > SHORTEST * length:
            return False
        states_at(J, order, step, z)
        for d in range(frame.shape[0]):
            states_at(T[d], order, step, frame[d])
        left -= step
    return True


@kernel
def carry_steps(code, numbers, order, tol, times, modes, states, z, frame, J, T):
    """:func:`carry` over the steps of a run; returns the number of the step that failed, or -1."""
    for i in range(modes.shape[0]):
        copy(states[i], z)
        if not carry(code, numbers, modes[i], order, tol, times[i, 1], z, frame, J, T):
            return i
    return -1
