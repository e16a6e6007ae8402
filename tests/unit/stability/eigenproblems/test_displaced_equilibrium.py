"""`x0="near"`: every growing mode is displaced, in the model's own scale, also from the origin."""

from __future__ import annotations

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.models.symbols import symbol


@fl.model
class Wheel(fl.Model):
    """A van der Pol oscillator beside a mass that a load deflects: y is zero where it rests."""

    omega: float = fl.parameter(1.0, unit="rad/s", symbol=r"\omega", meaning="frequency", range=(0.1, 1e7))
    length: float = fl.parameter(
        1.0, unit="m", symbol="l", meaning="where damping is zero", range=(1e-9, 1e9)
    )
    load: float = fl.parameter(0.0, unit="m/s^2", symbol="p", meaning="load per mass", range=(0.0, 10.0))
    growth: float = fl.parameter(0.2, unit="1", symbol="g", meaning="growth per omega", range=(0.0, 1.0))
    coordinates = ("y", "x")
    period = 6.3

    def derive(self):
        """Negative damping within the length, positive beyond."""
        y, x, v, w = states = symbol("y"), symbol("x"), symbol("y'"), symbol("x'")
        damping = self.growth * self.omega * (1 - y**2 / self.length**2)
        flow = (v, w, damping * v - self.omega**2 * y, self.load - self.omega * w - self.omega**2 * x)
        return fl.HybridAutomaton(states, (fl.Mode("rolls", flow),), {}, 2)


@pytest.mark.parametrize("load", [0.0, 3.0])
@pytest.mark.parametrize(("omega", "length"), [(1.0, 1.0), (1e3, 1e-6), (1e-3, 1e4)])
def test_a_growing_mode_that_rests_is_displaced_in_its_own_scale(omega, length, load):
    """From the origin, and beside a coordinate that is deflected; the same motion in other units."""
    model = Wheel(omega=omega, length=length, load=load)
    start = fl.simulate(model, 1e-9 / omega, x0="near", progress=False).problem.x0
    assert 1e-3 < abs(start[0]) / length < 0.1
    assert start[1] == pytest.approx(1.01 * load / omega**2 if load else 0.0, rel=1e-12)
    usual = fl.simulate(Wheel(load=1.0 if load else 0.0), 1e-9, x0="near", progress=False).problem.x0
    assert start[0] / length == pytest.approx(usual[0], rel=0.8)


def test_it_grows_to_its_limit_cycle():
    """Of radius 2 for small growth; from the equilibrium itself it would rest."""
    found = fl.steady_state(Wheel(growth=0.05), "near", transient=400.0, window=60.0, progress=False)
    assert found.kind == "periodic"
    assert np.ptp(found.trajectory.states[:, 0]) == pytest.approx(4.0, rel=2e-3)


def test_a_linear_model_has_no_scale():
    """Any displacement is as good as another: one hundredth in the largest state."""
    run = fl.simulate(Wheel(growth=0.0), 1e-9, x0="near", progress=False)
    assert np.abs(run.problem.x0).max() == pytest.approx(0.01)


@fl.model
class BetweenBelts(fl.MechanicalModel):
    """A mass between two belts that run against each other, whose friction falls with speed."""

    v: float = fl.parameter(2.0, unit="m/s", symbol="v", meaning="speed of both belts", range=(0.01, 1e3))
    k: float = fl.parameter(4.0, unit="N/m", symbol="k", meaning="stiffness", range=(0.1, 1e9))
    friction: fl.FrictionLaw = fl.Stribeck(mu_k=0.2, mu_s=0.6, v_s=1.0)
    coordinates = ("x",)
    period = 3.0

    def mechanics(self, q, v):
        """Both press with 1 N."""
        from frictionlab.models import Friction, Mechanics

        pads = tuple(Friction(side * self.v - v.x, 1.0, self.friction) for side in (1, -1))
        return Mechanics(v.x**2 / 2, self.k * q.x**2 / 2, contacts=pads)


def test_two_belts_set_the_scale_by_their_speed():
    """The linear motion meets stick where x omega = v, and leaves the linear range before."""
    for k in (4.0, 4e6):
        model = BetweenBelts(k=k)
        assert fl.eigenvalues(model).growth_rates.max() > 0
        start = fl.simulate(model, 1e-9, x0="near", progress=False).problem.x0
        assert 1e-3 < abs(start[0]) * k**0.5 / 2.0 <= 0.02
