"""A run of a tenth of a second that needs every kind of file in the cache of compiled code.

The pendulum x'' = -sin(x): its jets by native code, which has kernels for functions, and lanes of steps.
"""

import numpy as np
import sympy as sp

import frictionlab as fl
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.compilation.decorators import kernel
from frictionlab.hybrid.codegen.jet_codegen import LEFT, MEASURE, MOVE, lane_count
from frictionlab.hybrid.codegen.native_cache import NativeCode
from frictionlab.hybrid.ensemble.arrays import new_batch
from frictionlab.hybrid.kernels.arithmetic import call_jets, call_lane_step
from frictionlab.hybrid.kernels.run_state import jet_columns
from frictionlab.hybrid.problem import Problem
from frictionlab.tape.packing import program_of

ORDER, STEP, STEPS = 12, 0.1, 20


@kernel
def taylor_steps(address, z, constants, terms, J):
    """Some steps of native jets, summed in the plainest way."""
    for _ in range(STEPS):
        call_jets(address, z, constants, terms, J, ORDER)
        for i in range(z.shape[0]):
            total, power = 0.0, 1.0
            for k in range(ORDER + 1):
                total += J[i, k] * power
                power *= STEP
            z[i] = total


@kernel
def lane_steps(address, z, constants, terms, J, control):
    """One step of several runs."""
    call_lane_step(address, z, constants, terms, J, control, MEASURE, ORDER)
    call_lane_step(address, z, constants, terms, J, control, MOVE, ORDER)


def final_states() -> bytes:
    """What the run ends with, from whatever the cache holds; what it lacks is compiled."""
    x, y = sp.symbols("x y")
    program, numbers = program_of(HybridAutomaton((x, y), (Mode("m", (y, -sp.sin(x)), (), ()),), {}, 1))
    native = NativeCode(program)
    if not native.code.native[0]:
        native.compile(0)
    if not native.code.lanes[0]:
        native.compile_step(0)
    z, J = np.array([1.0, 0.5]), np.zeros((program.slots, jet_columns(ORDER)))
    taylor_steps(native.code.native[0], z, *numbers, J)
    problem = Problem(program, numbers, np.zeros(2), 1.0)
    lanes = new_batch([problem] * lane_count(), fl.Taylor(order=ORDER)).lanes
    lanes.constants[:], lanes.terms[:] = numbers.constants[:, None], numbers.terms[:, None]
    lanes.z[:], lanes.control[LEFT] = z[:, None], 1.0
    lane_steps(native.code.lanes[0], lanes.z, lanes.constants, lanes.terms, lanes.jets, lanes.control)
    return z.tobytes() + lanes.z.tobytes()
