"""A bouncing ball and Coulomb friction have known answers; nothing here knows the slider on the belt."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.automata import ONCE, V, X, automaton, ball, coulomb

ACCUMULATION = 3 * np.sqrt(2 / 9.81)  # fall sqrt(2 h/g), then flights that halve


@ONCE
def test_bouncing_ball_comes_to_rest():
    run = fl.solve(ball(), 3.0, x0=[1.0, 0.0])
    assert run.status is fl.Status.FINISHED
    assert abs(ACCUMULATION - 1.354570922957) < 1e-12
    assert run.events.t[-1] == pytest.approx(ACCUMULATION, abs=1e-11)
    assert run.events.closed.tolist() == [False] * (len(run.events) - 1) + [True]
    assert run.stats["accumulations"] == 1
    assert (run.events.target[:-1] == "flight").all()
    assert run.events.target[-1] == "rest"
    assert run.final_state.tolist() == [0.0, 0.0]
    assert run.time_in_mode["rest"] == pytest.approx(3.0 - ACCUMULATION, abs=1e-11)


@ONCE
def test_an_accumulation_can_end_the_run():
    method = fl.Taylor(accumulation="raise")
    closed, raised = fl.solve(ball(), 3.0, x0=[1.0, 0.0]), fl.solve(ball(), 3.0, x0=[1.0, 0.0], method=method)
    assert raised.status is fl.Status.ACCUMULATED
    assert not raised.status.ok
    assert raised.events.t.tolist() == closed.events.t.tolist()
    assert raised.t[-1] == pytest.approx(ACCUMULATION, abs=1e-11)
    assert np.isfinite(raised.states).all()


def test_without_a_closing_reset_the_run_stalls_and_says_so():
    g = sp.Symbol("g")
    flight = fl.Mode("flight", (V, -g), (fl.Event("floor", X, (), fl.Reset({X: sp.S.Zero, V: -V / 2})),))
    run = fl.solve(automaton(flight, g=9.81), 3.0, x0=[1.0, 0.0])
    assert run.status is fl.Status.STALLED
    assert run.events.t[-1] == pytest.approx(ACCUMULATION, abs=1e-11)
    assert np.isfinite(run.states).all()


def test_parameters_are_replaced_by_name():
    belt = coulomb(0.2, 1.0, 0.5)
    slower = belt.replace(belt=0.1)
    assert slower.modes is belt.modes  # so that nothing is derived again
    assert {s.name: v for s, v in slower.parameters.items()} == {"belt": 0.1, "mu_s": 1.0, "mu_k": 0.5}
    with pytest.raises(
        TypeError, match="HybridAutomaton has no parameter 'speed': known are belt, mu_s, mu_k"
    ):
        belt.replace(speed=0.1)
