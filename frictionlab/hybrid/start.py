"""The mode at t = 0, chosen by the rule that follows every event."""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.guards import NOISE
from frictionlab.hybrid.layout import Numbers
from frictionlab.hybrid.problem import Problem, Unbuilt
from frictionlab.hybrid.transitions import UNBUILT, Rounding, enter


def start(problem: Problem, order: int, absolute: Numbers, work) -> int:
    """First admissible mode at the initial state, -1 where there is none; leaves its jets in `work`.

    Raises
    ------
    ValueError
        Where the mode that was asked for cannot be entered there.
    Unbuilt
        Where a mode is to be tried that has yet to be derived.
    """
    program = problem.program
    candidates = program.initial if problem.mode is None else np.array([problem.mode], dtype=np.int64)
    work.declared[:] = 0
    arguments = (
        candidates,
        problem.x0,
        Rounding(problem.x0, NOISE),
        order,
        work.declared,
        work.zeros,
        work.jets,
        work.bounds,
    )
    mode = int(enter(program.code, problem.numbers, absolute, *arguments))
    if mode <= UNBUILT:
        raise Unbuilt(UNBUILT - mode)
    if mode < 0 and problem.mode is not None:
        raise ValueError(
            f"the run cannot start in mode {program.modes[problem.mode]!r}: at x0 one of its conditions "
            "does not hold or fails at once; leave mode=None to have the mode chosen"
        )
    return mode
