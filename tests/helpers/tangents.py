"""Derivatives of a tape against those of sympy."""

import numpy as np
import pytest
import sympy as sp

from frictionlab.hybrid.kernels.jets import slot_gradients
from frictionlab.tape.packing import program_of


def check_tangents(automaton, mode, z):
    program, numbers = program_of(automaton)
    jets, tangents = np.zeros((program.slots, 1)), np.zeros((program.slots, len(z)))
    slot_gradients(program.code, numbers, mode, z, jets, tangents)
    flow = sp.Matrix(automaton.modes[mode].flow)
    at = {**automaton.parameters, **dict(zip(automaton.states, z))}
    exact = np.array(flow.jacobian(automaton.states).subs(at).evalf(30), dtype=float)
    assert tangents[program.code.flow[mode]] == pytest.approx(exact, rel=1e-12, abs=1e-12)
