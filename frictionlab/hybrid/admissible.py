"""The violation of the modes' conditions along a run, checked independently of how events are located."""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.kernels.jets import majorant, run_tape
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.tape.program import Numbers
from frictionlab.hybrid.trajectory import Trajectory


def condition_violation(run: Trajectory) -> float:
    """Largest violation of a mode's condition at the samples of a run, as a share of the condition's size.

    Event functions must not be negative, constraints must be zero.  The size of a condition is the largest
    sum of its absolute terms along the run, in whatever mode: at the beginning of a flight the penetration is
    all rounding, and a flight may be arbitrarily short.
    """
    states, modes, worst = run.states, run.sample_arrays[2], 0.0
    for mode in np.unique(modes):
        inside = states[modes == mode]
        amounts, terms = _condition_values(run.problem, mode, np.vstack([inside, run.raw.step_states]))
        # in other modes it may be undefined, as sqrt(penetration) in flight
        sizes = np.where(np.isfinite(terms), terms, 0.0).max(axis=0)
        shares = amounts[: len(inside), sizes > 0] / sizes[sizes > 0]
        worst = max(worst, shares.max(initial=0.0))
    return float(worst)


def _condition_values(problem: Problem, mode: int, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By how much states (N, n) violate a mode's conditions (N, k), and the sums of their absolute terms."""
    code, numbers = problem.program.code, problem.numbers
    absolute, J = Numbers(*map(np.abs, numbers)), np.zeros((problem.program.slots, 1))
    guards = code.function_slots[code.mode_guards[mode] : code.mode_guards[mode + 1]]
    fixed = code.function_slots[code.mode_constraints[mode] : code.mode_constraints[mode + 1]]
    amounts = np.empty((len(states), len(guards) + len(fixed)))
    terms, sums = np.empty_like(amounts), J.copy()
    for i, z in enumerate(states):
        J[: len(z), 0] = z
        run_tape(code, numbers, code.mode_ops[mode], code.mode_ops[mode + 1], 0, code.flow[mode], -1.0, J, J)
        majorant(code, absolute, mode, 0, z, J, sums)
        amounts[i] = np.append(-J[guards, 0], np.abs(J[fixed, 0]))
        terms[i] = np.append(sums[guards, 0], sums[fixed, 0])
    return amounts, terms
