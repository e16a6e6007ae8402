"""Does a run keep to the conditions of its modes?  A check that is independent of how events are found."""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.guards import majorant
from frictionlab.hybrid.jets import run_tape
from frictionlab.hybrid.layout import Numbers
from frictionlab.hybrid.trajectory import Trajectory


def violation(run: Trajectory) -> float:
    """Most that a sample of a run violates a condition of its mode, as a share of the condition's terms.

    Event functions must not be negative, constraints must be zero.
    """
    program, numbers = run._problem.program, run._problem.numbers
    absolute, J = Numbers(*map(np.abs, numbers)), np.zeros((program.slots, 1))
    code, sizes, worst = program.code, J.copy(), 0.0
    for z, mode in zip(run.states, run._samples[2], strict=True):
        J[: len(z), 0] = z
        run_tape(code, numbers, code.mode_ops[mode], code.mode_ops[mode + 1], 0, code.flow[mode], -1.0, J, J)
        majorant(code, absolute, mode, 0, z, J, sizes)
        guards = code.function_slots[code.mode_guards[mode] : code.mode_guards[mode + 1]]
        fixed = code.function_slots[code.mode_constraints[mode] : code.mode_constraints[mode + 1]]
        amounts = np.append(-J[guards, 0], np.abs(J[fixed, 0]))
        terms = np.append(sizes[guards, 0], sizes[fixed, 0])
        worst = max([worst, *(amounts[terms > 0] / terms[terms > 0])])
    return float(worst)
