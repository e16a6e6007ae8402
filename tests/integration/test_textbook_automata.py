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
def test_every_bounce_is_where_it_should_be():
    times = fl.solve(ball(), 3.0, x0=[1.0, 0.0]).events.t[:30]
    fall = np.sqrt(2 / 9.81)
    exact = fall * (1 + 2 * (1 - 0.5 ** np.arange(30)))
    assert times == pytest.approx(exact, abs=1e-14)


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


@ONCE
def test_stick_slip_on_a_belt_has_its_closed_form_period():
    period = 5 + 2 * np.pi - 2 * np.arctan(2.5)  # stick 2 a/v, then an arc; a = 0.5, v = 0.2
    assert period == pytest.approx(8.902605407815, abs=1e-12)
    run = fl.solve(coulomb(0.2, 1.0, 0.5), 60.0, x0=[0.0, 0.2])
    onsets, releases = run.events.t[run.events.target == "stick"], run.events.t[run.events.source == "stick"]
    assert len(onsets) == 6
    assert np.diff(onsets) == pytest.approx(period, abs=1e-11)
    assert releases[0] == pytest.approx(5.0, abs=1e-13)
    assert run.mode[0] == "stick"
    sticking = run.mode == "stick"
    assert run["v"][sticking] == pytest.approx(0.2, abs=1e-15)


@ONCE
def test_coulomb_oscillator_turns_where_it_should_and_stops():
    run = fl.solve(coulomb(0.0, 1.0, 1.0), 20.0, x0=[10.3, 0.0])
    assert run.events.t == pytest.approx(np.pi * np.arange(1, 6), abs=1e-12)
    assert run.events.state[:, 0] == pytest.approx([-8.3, 6.3, -4.3, 2.3, -0.3], abs=1e-12)
    assert run.events.target.tolist() == ["-", "+", "-", "+", "stick"] or run.events.target.tolist() == [
        "+", "-", "+", "-", "stick",
    ]  # fmt: skip
    assert run.final_state == pytest.approx([-0.3, 0.0], abs=1e-12)
    assert run.status.ok


def test_parameters_are_replaced_by_name():
    belt = coulomb(0.2, 1.0, 0.5)
    slower = belt.replace(belt=0.1)
    assert slower.modes is belt.modes  # so that nothing is derived again
    assert {s.name: v for s, v in slower.parameters.items()} == {"belt": 0.1, "mu_s": 1.0, "mu_k": 0.5}
    with pytest.raises(
        TypeError, match="HybridAutomaton has no parameter 'speed': known are belt, mu_s, mu_k"
    ):
        belt.replace(speed=0.1)
