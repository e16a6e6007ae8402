"""The limit of chatter against numpy's eigenvalues of the limit mode, and what it must not depend on."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.hybrid.chatter_limit import chatter_limit
from tests.helpers.cases import slow_but

MODEL = fl.SliderOnBelt(mu_k=1.4)


def fastest_eigenvalue(model):
    """Magnitude, 1/s, in the limit mode where all states are zero."""
    automaton = model.automaton()
    (limit,) = (mode for mode in automaton.modes if mode.limit)
    flow = sp.Matrix(limit.flow).subs(dict(automaton.parameters))  # numbers first: these are long expressions
    jacobian = flow.jacobian(list(automaton.states)).subs(dict.fromkeys(automaton.states, 0))
    return np.abs(np.linalg.eigvals(np.array(jacobian, dtype=float))).max()


@pytest.mark.parametrize("stiffness", slow_but([1.0], [1.0, 1e2, 1e4]))
def test_the_limit_is_a_share_of_the_fastest_motions_time(stiffness):
    """The sum over all states is not less than the fastest, nor much more than as many as fast as it."""
    model = MODEL.replace(k3=60.0 * stiffness, k4=15.0 * stiffness)
    rate = 1.0 / chatter_limit(model.automaton(), 1.0)
    fastest = fastest_eigenvalue(model)
    assert fastest <= rate <= 10 * fastest


@pytest.mark.parametrize("method", [fl.Taylor(), fl.Scipy("DOP853")])
def test_a_method_takes_it_where_none_is_given(method):
    run = fl.simulate(MODEL, 0.01, method=method, progress=False)
    assert run.automaton.values["chatter"] == method.chatter_limit(MODEL.automaton())
    given = type(method)(chatter=1e-3)
    run = fl.simulate(MODEL, 0.01, method=given, progress=False)
    assert run.automaton.values["chatter"] == 1e-3


def test_an_ensemble_has_the_limits_of_its_runs():
    models = [MODEL, MODEL.replace(k4=1e4)]
    ends = fl.ensemble(models, 0.5, progress=False)
    for model, end in zip(models, ends.states):
        assert end.tolist() == fl.simulate(model, 0.5, progress=False).final_state.tolist()


def thrown(acceleration, **parameters):
    """A ball on a floor that throws it off, under this acceleration; its limit mode has the same motion."""
    y, v, s, chatter = sp.symbols("y v s chatter")
    flight = Mode("flight", (v, acceleration(y, v), -s), (Event("floor", y, (), Reset({v: s}, {y: 1})),))
    limit = Mode("limit", (v, acceleration(y, v), -s), (), (y, v), limit=True)
    return HybridAutomaton((y, v, s), (flight, limit), {chatter: 0.0, **parameters}, 1)


@pytest.mark.parametrize(
    ("acceleration", "rate"),
    [
        (lambda y, v: -10.0, 1.0),  # of s' = -s alone
        (lambda y, v: -9.0 * y - 10.0, 1.0 + 3.0),
        (lambda y, v: -9.0 * y - 2.0 * v, 1.0 + 2.0 + 3.0),
        (lambda y, v: -9.0 * y - 2.0 * sp.Abs(v), 1.0 + 3.0),  # |v| has the slope 0 at 0
    ],
)
def test_the_rate_of_a_users_automaton(acceleration, rate):
    assert chatter_limit(thrown(acceleration), 1e-3) == pytest.approx(1e-3 / rate, rel=1e-15)


def test_the_frequency_of_a_load_counts():
    y, v, phase, omega = sp.symbols("y v phase omega")
    limit = Mode("limit", (v, sp.cos(phase), omega), (), (y, v), limit=True)
    automaton = HybridAutomaton((y, v, phase), (limit,), {omega: 50.0}, 1)
    assert chatter_limit(automaton, 1.0) == pytest.approx(1 / 50)


@pytest.mark.parametrize("acceleration", [lambda y, v: 1 / y, lambda y, v: sp.sqrt(y)])
def test_without_a_derivative_at_zero_every_flight_is_computed(acceleration):
    assert chatter_limit(thrown(acceleration), 1e-3) == 0.0


def test_free_fall_has_no_time_of_its_own():
    y, v = sp.symbols("y v")
    limit = Mode("limit", (v, sp.Integer(-10)), (), (y, v), limit=True)
    assert chatter_limit(HybridAutomaton((y, v), (limit,), {}, 1), 1e-3) == 0.0


def test_an_automaton_without_a_limit_mode_has_none():
    assert chatter_limit(fl.BouncingBall().automaton(), 1e-3) == 0.0
