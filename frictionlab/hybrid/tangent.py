"""Derivatives of a tape's slots with respect to the states, exact but for rounding."""

from __future__ import annotations

from frictionlab.hybrid.compiled import kernel
from frictionlab.hybrid.jets import AFFINE, POWER, PRODUCT, RATE, SQUARE, run_tape


@kernel
def slot_tangents(code, numbers, mode, z, J, T):
    """Forward mode through a mode's tape at `z`: T[slot, i] is the slot's derivative by state i."""
    inputs, first, last = code.inputs, code.mode_ops[mode], code.mode_ops[mode + 1]
    T[:inputs] = 0.0
    for i in range(inputs):
        J[i, 0] = z[i]
        T[i, i] = 1.0
    run_tape(code, numbers, first, last, 0, code.flow[mode], -1.0, J, J)
    for op in range(first, last):
        kind, a, b, out = code.ops[op, 0], code.ops[op, 1], code.ops[op, 2], inputs + op - first
        for i in range(inputs):
            if kind == AFFINE:
                T[out, i] = 0.0
                for j in range(a, b):
                    T[out, i] += numbers.terms[j] * T[code.term_slots[j], i]
            elif kind == PRODUCT:
                T[out, i] = J[a, 0] * T[b, i] + J[b, 0] * T[a, i]
            elif kind == SQUARE:
                T[out, i] = 2.0 * J[a, 0] * T[a, i]
            elif kind == RATE:
                T[out, i] = 0.0
            elif kind == POWER:
                slope = numbers.constants[op] * J[out, 0] / J[a, 0] if J[a, 0] > 0.0 else 0.0
                T[out, i] = slope * T[a, i]
            elif kind > POWER:
                T[out, i] = J[b, 0] * T[a, i]
            else:
                T[out, i] = (T[a, i] - J[out, 0] * T[b, i]) / J[b, 0]
