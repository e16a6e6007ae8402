"""Derivatives of runs by parameters, through stick and forces, against central differences."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.analysis.parameter_flow import parameter_flow, varied_names
from tests.helpers.cases import slow_but

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
    found, whole = parameter_flow(run, names, t), parameter_flow(run, names)
    assert found.states == pytest.approx(run(t), abs=1e-13)
    assert found.end == pytest.approx(whole.end, abs=1e-12)
    for i, name in enumerate(names):
        high, low, step = moved(name)
        assert found.slopes[:, :, 2 + i] == pytest.approx((high(t) - low(t)) / step, abs=1e-6), name
        times = (high.events.t - low.events.t) / step
        assert found.event_slopes[:, 2 + i] == pytest.approx(times, abs=1e-6), name


def test_by_the_state_it_is_the_tangent_flow():
    run = fl.simulate(MODEL, T_END, x0=START, progress=False)
    assert parameter_flow(run, ("k",)).end[:, :2] == pytest.approx(fl.tangent_flow(run).matrix, abs=1e-12)


def test_integrals_have_derivatives():
    """The integral of x' is x: their derivatives are those of the state."""
    run = fl.simulate(MODEL, T_END, x0=START, progress=False)
    end = parameter_flow(run, ("k", "mu_s"), integrands=(run.automaton.states[1],)).end
    assert end[2] == pytest.approx(end[0] - [1.0, 0.0, 0.0, 0.0], abs=1e-9)


@dataclass(frozen=True)
class PowerContact(fl.ContactLaw):
    """F_N = k_p delta^p."""

    k_p: float = fl.parameter(5e4, unit="N/m^p")
    p: float = fl.parameter(1.5)

    def force(self, penetration):
        return self.k_p * penetration**self.p


FULL = fl.PlasticImpact("full")
EXPONENTS = {
    "pressure, sliding": (fl.SliderOnBelt(friction=fl.PressureDependent(mu_k=1.0, mu_s=3.0)), 0.05, "n k1"),
    "pressure, stick and flight": (
        fl.SliderOnBelt(friction=fl.PressureDependent(mu_k=1.4, mu_s=3.0), impact=FULL),
        0.3,
        "n k1",
    ),
    "contact": (fl.SliderOnBelt(contact=PowerContact()), 0.05, "p k_p"),
    "contact, stick and flight": (
        fl.SliderOnBelt(mu_k=1.4, contact=PowerContact(), impact=FULL).without("geometry"),
        0.3,
        "p k_p k1",
    ),
}


@pytest.mark.parametrize("case", slow_but([case for case in EXPONENTS if "flight" in case], EXPONENTS))
def test_exponents_move_runs_as_differences_say(case):
    """At the zero of its base, where contact begins and ends, the logarithm of it is no number."""
    model, t_end, named = EXPONENTS[case]
    flight, names = "flight" in case, named.split()
    x0 = "rest" if flight else fl.simulate(model, 1e-6, x0="near", progress=False).problem.x0
    run = fl.simulate(model, t_end, x0=x0, progress=False)
    assert (run.events.target == "separation").any() == flight
    found = parameter_flow(run, names).end[:, len(run.names) :]
    for i, name in enumerate(names):
        value, rows = model.parameters[name], []
        for level in range(3):
            step = 1e-4 * value / 2**level
            models = (model.replace(**{name: value + side * step}) for side in (1, -1))
            high, low = (fl.simulate(m, t_end, x0=x0, progress=False).final_state for m in models)
            rows.append((high - low) / (2 * step))
        for power in (1, 2):
            rows = [(4**power * b - a) / (4**power - 1) for a, b in pairwise(rows)]
        assert found[:, i] == pytest.approx(rows[0], abs=1e-6 * np.abs(rows[0]).max()), name
