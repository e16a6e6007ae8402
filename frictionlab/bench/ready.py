"""Compiled code at hand before anything is timed, the kernel and that of all modes: as a long run has it."""

from __future__ import annotations

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.compiled import NUMBA
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.natives import natives
from frictionlab.hybrid.program import program_of
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.taylor import Taylor


def make_ready(automaton: HybridAutomaton, method: Method) -> None:
    """Compile what is missing, so that no mode is native code in one run and interpreted in the next."""
    solve(automaton, 1e-9, x0=np.zeros(len(automaton.states)), method=method, progress=False)
    if not isinstance(method, Taylor):
        return
    jets = natives(program_of(automaton)[0])
    for mode in np.flatnonzero(jets.code.native == 0) if NUMBA else ():
        jets.compile(int(mode))


def make_lanes_ready(automaton: HybridAutomaton, method: Taylor) -> None:
    """The same for the steps of several runs side by side."""
    native = natives(program_of(automaton)[0])
    for mode in np.flatnonzero(native.code.lanes == 0) if NUMBA else ():
        native.compile_step(int(mode))
