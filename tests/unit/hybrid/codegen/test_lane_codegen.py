"""Steps of several runs side by side against the kernels of single runs: the same to the last bit."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.automaton import Event, HybridAutomaton, Mode
from frictionlab.automaton.matrix_rows import matrix_rows
from frictionlab.compilation import machine_code
from frictionlab.compilation.decorators import kernel
from frictionlab.hybrid.codegen import native_cache
from frictionlab.hybrid.codegen.jet_codegen import LEFT, LENGTH, MEASURE, MOVE, REGULAR, lane_count
from frictionlab.hybrid.ensemble.arrays import new_batch
from frictionlab.hybrid.kernels.arithmetic import call_lane_step
from frictionlab.hybrid.kernels.run_state import (
    END,
    Truncation,
    new_record,
    new_run_state,
    new_scratch,
)
from frictionlab.hybrid.kernels.step_length import step_length
from frictionlab.hybrid.kernels.taylor_steps import advance_taylor
from frictionlab.hybrid.problem import Problem
from frictionlab.tape.functions import FUNCTIONS
from frictionlab.tape.packing import program_of
from frictionlab.tape.program import system_of
from tests.helpers.cases import slow_but

pytestmark = pytest.mark.skipif(not machine_code.HAS_MACHINE_CODE, reason="needs numba")
METHODS = [fl.Taylor(tol=1e-15), fl.Taylor(tol=1e-9), fl.Taylor(tol=1e-4), fl.Taylor(order=4)]
X, Y, A, P = sp.symbols("x y a p")
INNER = {sp.log: 2 + X, sp.tan: X / 2}  # away from their poles
LAYER = Event("layer", 2 + sp.exp(-((10 * A * (X - 2)) ** 2)))  # never zero


def of_rate(rate, **values):
    """x' = `rate`, y' = -x, without guards."""
    parameters = {A: 3.0} | {sp.Symbol(name): value for name, value in values.items()}
    return HybridAutomaton((X, Y), (Mode("m", (rate, -X), (), ()),), parameters, 1)


SCENES = {f.name: of_rate(Y + f.expression(A * INNER.get(f.expression, X)) / 8) for f in FUNCTIONS} | {
    "quotient": of_rate(Y + X / (1 + (A * X) ** 2)),
    "power": of_rate(Y - X * (1 + (A * X) ** 2) ** P, p=0.3),
    "nested": of_rate(sp.tanh(A * X) * (1 + sp.exp(-(Y**2))) + sp.sin(A * sp.cos(X)) / (2 + Y**2)),
    "guard": HybridAutomaton((X, Y), (Mode("m", (Y, -X), (LAYER,)),), {A: 3.0}, 1),
}


@kernel
def step_of_lanes(code, lanes, order):
    """Both parts."""
    arrays = lanes.z, lanes.constants, lanes.terms, lanes.jets, lanes.control
    call_lane_step(code.lanes[0], *arrays, MEASURE, order)
    call_lane_step(code.lanes[0], *arrays, MOVE, order)


def with_step(automaton):
    """Native steps of the only mode, and the numbers."""
    program, numbers = program_of(automaton)
    native = native_cache.native_code(program)
    native.compile_step(0)
    return program, numbers, native.code


def alone(program, numbers, code, method, state):
    """Length and end of a run's step, and the length that its last terms suggest."""
    cursor = new_run_state(len(state), 0)
    cursor.state[:], cursor.sizes[:], cursor.times[END] = state, np.abs(state), 1e3
    record, work = new_record(program.code, 1, 2, 0), new_scratch(program.slots, program.code, method.degree)
    truncation = Truncation(method.degree, method.tol)
    with np.errstate(all="ignore"):
        advance_taylor(system_of(code, numbers), truncation, cursor, record, work)
    assert cursor.times[END] == 1e3
    return record.step_times[0, 1], cursor.state, step_length(code, method.degree, method.tol, work.jets)


# Every function in one flow: test_steps_heed_every_function_as_those_of_a_run_alone of the ensembles.
QUICK = "quotient", "nested", "guard"


@pytest.mark.parametrize("name", slow_but(QUICK, SCENES))
def test_a_step_of_lanes_is_that_of_a_run_alone(name):
    fine, shortened = fine_and_shortened(SCENES[name], METHODS)
    assert fine > 0.9 * 10 * lane_count() * len(METHODS)
    assert shortened > 0


def test_a_polynomial_of_a_degree_as_high_as_the_order_is_left_to_runs_alone():
    """There its last terms do not tell how long a step may be; below they do, and no step is shortened."""
    automaton = of_rate(Y - A * X**12)
    assert fine_and_shortened(automaton, METHODS[:2]) == (2 * 10 * lane_count(), 0)
    assert fine_and_shortened(automaton, METHODS[2:]) == (0, 0)


def fine_and_shortened(automaton, methods):
    """How many steps of lanes are fine, which are compared, and how many the bound shortens."""
    program, numbers, code = with_step(automaton)
    fine = shortened = 0
    for method in methods:
        group = new_batch([Problem(program, numbers, np.zeros(2), 1.0)] * lane_count(), method)
        lanes = group.lanes
        lanes.constants[:], lanes.terms[:] = numbers.constants[:, None], numbers.terms[:, None]
        for states in np.random.default_rng(0).uniform(-1.2, 1.2, size=(10, lane_count(), 2)):
            lanes.z[:], lanes.control[LEFT] = states.T, 1e3
            step_of_lanes(code, lanes, method.degree)
            for lane in np.flatnonzero(lanes.control[REGULAR]):
                h, end, suggested = alone(program, numbers, code, method, states[lane])
                assert lanes.control[LENGTH, lane] == h
                np.testing.assert_array_equal(lanes.z[:, lane], end)
                fine, shortened = fine + 1, shortened + (h < suggested)
    return fine, shortened


def test_a_mode_with_a_large_matrix_is_not_compiled():
    states = sp.symbols("x:17", real=True)
    rows = tuple(matrix_rows(np.ones((17, 17)), states))
    native = native_cache.native_code(program_of(HybridAutomaton(states, (Mode("m", rows),)))[0])
    native.share([0])
    assert not native.requested
