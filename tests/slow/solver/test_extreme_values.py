"""Far from the usual values: every run ends with a status, without a NaN, and keeps to its laws."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components import SlidingOnly
from tests.helpers.energy_balance import assert_balanced
from tests.helpers.motion_invariants import LIMITS, violations

USUAL = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
PRINTED = fl.SliderOnBelt(mu_k=1.4)
DECADES = {
    "M": np.logspace(-4, 4, 5),
    "m": np.logspace(-4, 4, 5),
    "J": np.logspace(-6, 3, 5),
    "F": np.logspace(-6, 6, 7),
    "k1": np.logspace(-3, 9, 7),
    "k2": np.logspace(-3, 9, 7),
    "k3": np.logspace(-6, 6, 5),
    "k_nl": np.logspace(0, 12, 7),
    "c1": np.logspace(-6, 6, 7),
    "c2": np.logspace(-6, 6, 7),
    "v": [-10.0, -1e-6, 0.0, 1e-9, 1e-3, 100.0],
    "mu_k": [0.0, 1e-9, 3.0, 10.0],
}
CASES = [(name, float(value)) for name, values in DECADES.items() for value in values]
ENDS = {fl.Status.FINISHED, fl.Status.STEP_CAP, fl.Status.EVENT_CAP}


def ended(model, t_end=0.5, **options):
    """A run with a cap on its steps; its status and numbers are as they have to be."""
    method = options.pop("method", fl.Taylor(max_steps=100_000, max_events=100_000))
    run = fl.simulate(model, t_end, method=method, progress=False, **options)
    assert run.status in ENDS
    assert np.isfinite(run.states).all()
    assert np.isfinite(run.events.state).all()
    assert (np.diff(run.t) >= 0).all()
    return run


@pytest.mark.parametrize("model", [USUAL, PRINTED], ids=["full gap rate", "Eq. (13)"])
@pytest.mark.parametrize(("name", "value"), CASES, ids=lambda x: f"{x:g}" if isinstance(x, float) else x)
def test_parameters_over_many_decades(name, value, model):
    changes = {name: value} | ({"mu_s": max(3.0, value)} if name == "mu_k" else {})
    run = ended(model.replace(**changes), 0.2)
    worst = violations(run.source, run)
    assert {what: size for what, size in worst.items() if size > 100 * LIMITS[what]} == {}
    assert_balanced(run)


@pytest.mark.parametrize("damping", [0.0, 1.0, 1e3, 1e5])
def test_damping_up_to_overdamped(damping):
    """Stiff for an explicit method: the steps shrink, the answer stays right."""
    model = USUAL.replace(**dict.fromkeys(("c1", "c2", "c4", "c5", "c6"), damping))
    run = ended(model, 0.05)
    other = fl.simulate(model, 0.05, method=fl.Scipy("Radau", rtol=1e-10, atol=1e-14), progress=False)
    assert np.abs(run.final_state - other.final_state).max() < 1e-6
    assert_balanced(run)


def test_a_million_events():
    """Without a limit for chatter every flight is walked through."""
    model, x0 = PRINTED.replace(F=0.0), [0, 1e-3, 0, 0, 0, 0, 0, 0, 0, 0]
    walked = {"chatter": 0.0, "max_steps": 2_000_000}
    run = ended(model, 5.0, x0=x0, method=fl.Taylor(max_events=1_000_000, **walked))
    assert run.status is fl.Status.EVENT_CAP or run.status is fl.Status.FINISHED
    assert (np.diff(run.events.t) >= 0).all()
    assert_balanced(ended(model, 5.0, x0=x0, method=fl.Taylor(max_events=20_000, **walked)))


def test_energy_over_a_thousand_seconds():
    """No damping, no friction, no moving load, contact that lasts: nothing may be lost in 10,000 periods."""
    still = dict.fromkeys(("c1", "c2", "c4", "c5", "c6", "mu_k"), 0.0)
    model = USUAL.replace(interface=SlidingOnly(), **still).without("geometry")
    run = fl.simulate(model, 1000.0, x0="rest", progress=False)
    x1, y1, x2, y2, dx1, dy1, dx2, dy2 = run.states.T
    gap, p = y2 - y1, model
    energy = 0.5 * (p.M * (dx1**2 + dy1**2) + p.m * (dx2**2 + dy2**2)) + p.F * y1
    energy += 0.5 * (p.k1 * x1**2 + p.k4 * x2**2 + (p.k5 + p.k6) * y2**2 + p.k3 * (x1 - y1) ** 2 / 2)
    energy += 0.5 * p.k2 * gap**2 + 0.25 * p.k_nl * gap**4
    scale = (0.5 * p.M * (dx1**2 + dy1**2)).max()
    assert np.ptp(energy) < 1e-11 * scale
    assert_balanced(run)


@pytest.mark.parametrize("model", [USUAL, PRINTED], ids=["full gap rate", "Eq. (13)"])
def test_the_error_follows_the_tolerance(model):
    exact = fl.simulate(model, 2.0, progress=False).final_state
    for tol in 10.0 ** -np.arange(4, 17):
        found = ended(model, 2.0, method=fl.Taylor(tol=tol))
        assert np.abs(found.final_state - exact).max() < max(1e3 * tol, 1e-10)
        assert_balanced(found, max(tol, 1e-9))


@pytest.mark.parametrize("order", [4, 6, 10, 16, 20, 30, 40])
def test_every_order_gives_the_same_motion(order):
    t_end = 0.1 if order == 4 else 2.0  # which takes six million steps a second
    exact = fl.simulate(USUAL, t_end, progress=False)
    found = fl.simulate(USUAL, t_end, method=fl.Taylor(order=order), progress=False)
    assert found.events.target.tolist() == exact.events.target.tolist()
    assert found.status is fl.Status.FINISHED
    assert np.abs(found.events.t - exact.events.t).max() < 1e-10
    if order > 4:
        assert_balanced(found)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_units_do_not_matter(scale):
    """Lengths in another unit: forces follow, stiffnesses stay, k_nl goes with 1/L^2, J with L^2."""
    p = PRINTED
    other = p.replace(
        F=p.F * scale,
        v=p.v * scale,
        l1=p.l1 * scale,
        l2=p.l2 * scale,
        J=p.J * scale**2,
        k_nl=p.k_nl / scale**2,
    )
    one, two = (fl.simulate(model, 1.5, progress=False) for model in (p, other))
    units = np.array([scale, scale, scale, scale, 1.0] * 2)
    assert two.events.target.tolist() == one.events.target.tolist()
    assert np.abs(two.events.t - one.events.t).max() < 1e-10
    assert np.abs(two.final_state / units - one.final_state).max() < 1e-9
    for run in (one, two):
        assert_balanced(run)


def test_a_family_swept_through_grazing():
    """The slider is set off with ever more lift; where it just touches or just misses, both are right."""
    lifts = np.concatenate([np.linspace(0.0, 0.2, 21), 0.1 + np.logspace(-12, -2, 11)])
    for lift in lifts:
        run = ended(USUAL, 0.3, x0=[0, 0, 0, 0, 0, 0, float(lift), 0, 0, 0])
        worst = violations(USUAL, run)
        assert {what: size for what, size in worst.items() if size > LIMITS[what]} == {}
        assert_balanced(run)
