"""What holds in every motion: the laws of contact and friction, in every mode, between events and at them."""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import frictionlab as fl
from frictionlab.components import SlidingOnly, SlidingSeparation, StickSlip, StickSlipSeparation
from tests.helpers.motion_invariants import LIMITS, unilateral, violations

FULL = fl.PlasticImpact("full")
IMPACTS = [fl.PlasticImpact(), FULL, *(fl.RestitutionImpact(e=e) for e in (0.0, 0.5, 1.0))]
INTERFACES = [StickSlipSeparation()] * 5 + [StickSlip(), SlidingSeparation(), SlidingOnly()]


def floats(low, high):
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


@st.composite
def scenes(draw):
    """A model, an initial state and a length."""
    mu_k = draw(st.one_of(st.just(0.0), floats(0.0, 3.0)))
    v = draw(st.one_of(st.sampled_from([0.0, 1.0, -1.0]), floats(-3.0, 3.0)))
    interface = draw(st.sampled_from(INTERFACES))
    assume(v != 0 or interface.sticks)  # else friction has no direction, which is refused
    model = fl.SliderOnBelt(
        mu_k=mu_k,
        mu_s=mu_k + draw(st.one_of(st.just(0.0), floats(0.0, 2.0))),
        F=draw(st.one_of(st.just(0.0), floats(0.0, 1000.0))),
        v=v,
        k2=draw(st.sampled_from([1e3, 5e3, 1e5])),
        k_nl=draw(st.sampled_from([0.0, 1e4, 1e7, 1e10])),
        k1=draw(floats(1e3, 1e5)),
        k3=draw(floats(0.0, 1e5)),
        k4=draw(floats(1e3, 1e6)),
        l1=draw(floats(0.0, 0.5)),
        m=draw(floats(0.2, 5.0)),
        J=draw(floats(0.02, 1.0)),
        c1=draw(st.sampled_from([0.0, 0.1, 10.0])),
        impact=draw(st.sampled_from(IMPACTS)),
        interface=interface,
    )
    model = model.without(*draw(st.sets(st.sampled_from(["cubic", "geometry"]))))
    n = len(model.coordinates)
    kind = draw(st.sampled_from(["rest", "small", "large"]))
    size = {"rest": 0.0, "small": 1e-3, "large": 3e-2}[kind]
    rates = {"rest": 0.0, "small": 0.1, "large": 2.0}[kind]
    state = [draw(floats(-size, size)) for _ in range(n)] + [draw(floats(-rates, rates)) for _ in range(n)]
    return model, np.array(state), draw(st.sampled_from([0.2, 0.5]))


def escapes(model, run):
    """With F_N of either sign (bilateral contact) friction can feed a motion that grows without bound."""
    places, speeds = np.split(np.abs(run.final_state), 2)
    return not unilateral(model) and (places.max() > 10.0 or speeds.max() > 1e3)


def chatters(run):
    """Whether the cap was reached in micro-flights."""
    short = run.raw.step_times[-1000:, 1].max() < 1e-4
    return run.status is fl.Status.STEP_CAP and short and (run.events.source[-1000:] == "separation").all()


def bounces_for_ever(model, run):
    """Elastic impacts (e = 1) lose nothing: flights of some 1e-7 s stay as short as they began."""
    return getattr(model.impact, "e", 0.0) == 1.0 and chatters(run)


def check(model, state, t_end):
    run = fl.simulate(model, t_end, x0=state, progress=False, method=fl.Taylor(max_steps=20_000))
    if chatters(run):  # in flights too long to be replaced by their limit
        run = fl.simulate(model, t_end, x0=state, progress=False, method=fl.Taylor(max_steps=200_000))
    if run.status is not fl.Status.FINISHED:
        assert escapes(model, run) or bounces_for_ever(model, run), run.status
    else:
        assert run.t[-1] == t_end
    assert np.isfinite(run.events.state).all()
    assert np.isfinite(run.events.before).all()
    assert (np.diff(run.t) >= 0).all()
    assert sum(run.time_in_mode.values()) == pytest.approx(run.t[-1], rel=1e-12)
    worst = violations(model, run)
    assert {name: value for name, value in worst.items() if value > LIMITS[name]} == {}
    return run, worst


@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(scenes())
def test_every_motion_obeys_its_laws(scene):
    check(*scene)
