"""Derivatives of runs by parameters, through stick and forces, against central differences."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.analysis.parameter_flow import parameter_flow, sampled_flow, varied_names

MODEL = fl.MassOnBelt(c=0.05)
START = np.array([1.5, 0.0])
T_END = 20.0


def moved(name, share=1e-5, t_end=T_END):
    """Runs with a parameter a little larger and a little smaller, and the difference of its values."""
    value = MODEL.parameters[name]
    steps = (value * (1 + share), value * (1 - share))
    high, low = (fl.simulate(MODEL.replace(**{name: v}), t_end, x0=START, progress=False) for v in steps)
    return high, low, 2 * share * value


def test_states_and_event_times_move_as_differences_say():
    run = fl.simulate(MODEL, T_END, x0=START, progress=False)
    assert (run.events.target == "stick").sum() >= 2
    t, names = np.linspace(0.0, T_END, 57), varied_names(run.automaton)
    found, whole = sampled_flow(run, names, t), parameter_flow(run, names)
    assert found.states == pytest.approx(run(t), abs=1e-13)
    assert found.end == pytest.approx(np.hstack([whole.state, whole.parameters]), abs=1e-12)
    for i, name in enumerate(names):
        high, low, step = moved(name)
        assert found.slopes[:, :, 2 + i] == pytest.approx((high(t) - low(t)) / step, abs=1e-6), name
        times = (high.events.t - low.events.t) / step
        assert found.event_slopes[:, 2 + i] == pytest.approx(times, abs=1e-6), name


def test_by_the_state_it_is_the_tangent_flow():
    run = fl.simulate(MODEL, T_END, x0=START, progress=False)
    assert parameter_flow(run, ("k",)).state == pytest.approx(fl.tangent_flow(run).matrix, abs=1e-12)


def test_integrals_have_derivatives():
    """The integral of x' is x: their derivatives are those of the state."""
    run = fl.simulate(MODEL, T_END, x0=START, progress=False)
    found = parameter_flow(run, ("k", "mu_s"), (run.automaton.states[1],))
    assert found.integrals_by_parameters[0] == pytest.approx(found.parameters[0], abs=1e-9)
    assert found.integrals_by_state[0] == pytest.approx(found.state[0] - [1.0, 0.0], abs=1e-9)


def test_a_parameter_in_an_exponent_has_none():
    model = fl.SliderOnBelt(friction=fl.PressureDependent(mu_k=1.0, mu_s=3.0))
    run = fl.simulate(model, 0.05, x0="near", progress=False)
    found = parameter_flow(run, ("n", "k1"))
    assert np.isnan(found.parameters[:, 0]).all()
    assert np.isfinite(found.parameters[:, 1]).all()
