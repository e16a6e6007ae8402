"""How runs are timed: code is compiled before, and runs take turns, so that a slow moment affects all."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.compilation.machine_code import HAS_MACHINE_CODE
from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import solve
from frictionlab.tape.packing import program_of


def warm_up(automaton: HybridAutomaton, method: Method) -> None:
    """Compile what is missing, so that no mode is native code in one run and interpreted in the next."""
    solve(automaton, 1e-9, x0=np.zeros(len(automaton.states)), method=method, progress=False)
    if not isinstance(method, Taylor):
        return
    jets = native_code(program_of(automaton)[0])
    for mode in np.flatnonzero(jets.code.native == 0) if HAS_MACHINE_CODE else ():
        jets.compile(int(mode))


def warm_up_lanes(automaton: HybridAutomaton, method: Taylor) -> None:
    """Compile what the steps of several runs side by side need."""
    native = native_code(program_of(automaton)[0])
    for mode in np.flatnonzero(native.code.lanes == 0) if HAS_MACHINE_CODE else ():
        native.compile_step(int(mode))


def times_in_turns(
    runs: Sequence[Callable[[], Any]], repeats: int, clock: Callable[[], float] = time.process_time
) -> list[list[float]]:
    """All times of each, after one call to warm up; in turns, so that a slow moment affects all.

    The `clock` is the time of this process, in which other work on the machine counts little.
    """
    for run in runs:
        run()
    spent = [[_time_call(run, clock) for run in runs] for _ in range(repeats)]
    return [list(column) for column in zip(*spent, strict=True)]


def least_times(
    runs: Sequence[Callable[[], Any]], repeats: int, clock: Callable[[], float] = time.process_time
) -> list[float]:
    """The least of the :func:`times_in_turns` of each."""
    return list(map(min, times_in_turns(runs, repeats, clock)))


def _time_call(run: Callable[[], Any], clock: Callable[[], float]) -> float:
    begin = clock()
    run()
    return clock() - begin
