"""Any tolerance and order: a run ends with "no admissible mode" nowhere, and the events do not change.

An event is found along a truncated series.  What vanishes with its guard, as the acceleration after stick
where mu_s = mu_k, must vanish whatever the tolerance is.
"""

from random import Random

import numpy as np
import pytest

import frictionlab as fl

FULL = fl.PlasticImpact("full")
# Without chaos over the time given: at 1e-3 its errors stay errors
PREDICTABLE = {
    "Den Hartog": (fl.DenHartog(N=0.8), 60.0),
    "Den Hartog, weak friction": (fl.DenHartog(N=0.3), 40.0),
    "impact oscillator": (fl.ImpactOscillator(), 25.0),
    "mode coupling": (fl.ModeCoupling(mu_k=0.5, mu_s=0.5), 30.0),
    "two blocks": (fl.TwoBlocks(k1=1.3, N1=0.8), 30.0),
    "slider": (fl.SliderOnBelt(mu_k=1.4, mu_s=1.4, impact=FULL), 0.12),
}


@pytest.mark.parametrize("name", PREDICTABLE)
def test_the_events_are_the_same_at_every_tolerance(name):
    model, t_end = PREDICTABLE[name]
    exact = fl.simulate(model, t_end).events
    assert len(exact) > 1
    for tol in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-12, 1e-16):
        events = fl.simulate(model, t_end, method=fl.Taylor(tol=tol)).events
        assert events.target.tolist() == exact.target.tolist(), tol
        # Errors of single steps add up, and grow where friction feeds the motion.
        assert np.abs(events.t - exact.t).max() < max(100 * tol, 1e-11) * t_end, tol


@pytest.mark.parametrize("mu", [0.4, 0.7, 1.0, 1.4, 2.0, 2.8])
@pytest.mark.parametrize("impact", [fl.PlasticImpact(), FULL, fl.RestitutionImpact(e=0.5)])
def test_equal_friction_at_rest_and_in_motion(mu, impact):
    """With mu_s = mu_k slip begins with no acceleration: the second derivative decides."""
    model = fl.SliderOnBelt(mu_k=mu, mu_s=mu, impact=impact)
    for tol, order in ((1e-3, None), (1e-5, 6), (1e-5, 30), (1e-7, None), (1e-9, 12)):
        run = fl.simulate(model, 0.5, method=fl.Taylor(tol=tol, order=order))
        assert run.status is fl.Status.FINISHED, (tol, order)


def _number(rng, low, high):
    return float(f"{low * (high / low) ** rng.random():.3g}")


def _law(rng):
    mu_k = _number(rng, 0.1, 2.5)
    mu_s = mu_k if rng.random() < 0.7 else mu_k * _number(rng, 1, 2)
    law = rng.choice([fl.Coulomb, fl.Stribeck, fl.ExponentialDecay])
    return (
        law(mu_k=mu_k, mu_s=mu_s)
        if law is fl.Coulomb
        else law(mu_k=mu_k, mu_s=mu_s, v_s=_number(rng, 0.01, 2))
    )


def _slider(rng):
    impact = rng.choice([fl.PlasticImpact(), FULL, fl.RestitutionImpact(e=_number(rng, 0.1, 0.9))])
    model = fl.SliderOnBelt(friction=_law(rng), F=_number(rng, 50, 800), impact=impact)
    left_out = [name for name in ("cubic", "geometry") if rng.random() < 0.4]
    return model.without(*left_out) if left_out else model


MAKERS = (
    lambda rng: (_slider(rng), 1.0),
    lambda rng: (fl.MassOnBelt(friction=_law(rng), c=_number(rng, 1e-3, 0.3), v=_number(rng, 0.1, 3)), 40.0),
    lambda rng: (fl.ModeCoupling(friction=_law(rng), c=_number(rng, 0.01, 0.3)), 30.0),
    lambda rng: (fl.SliderOnRigidBelt(friction=_law(rng)), 5.0),
    lambda rng: (fl.DenHartog(N=_number(rng, 0.2, 1.2), Omega=_number(rng, 0.2, 3)), 50.0),
    lambda rng: (fl.ImpactOscillator(e=_number(rng, 0.1, 0.99), Omega=_number(rng, 0.3, 4), c=0.1), 50.0),
    lambda rng: (fl.TwoBlocks(friction=_law(rng)), 40.0),
    lambda rng: (fl.BouncingBall(e=_number(rng, 0.2, 0.9)), 5.0),
)


@pytest.mark.parametrize("number", range(48))
def test_no_run_ends_without_an_admissible_mode(number):
    """Orders below 6 are left out: a mass that takes off from rest stalls there."""
    rng = Random(number)
    model, t_end = MAKERS[number % len(MAKERS)](rng)
    for _ in range(3):
        order = rng.choice([None, rng.randint(6, 30)])
        method = fl.Taylor(tol=10 ** -rng.uniform(3, 16 if order is None or order > 12 else 8), order=order)
        run = fl.simulate(model, t_end, method=method)
        assert run.status is fl.Status.FINISHED, (model, method)
