"""Powers with a parameter as exponent in what a user's model states: where the base can be negative they are
refused, and what the message says to write instead gives the right motion."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.special import ellipj

import frictionlab as fl
from frictionlab.models import Mechanics
from frictionlab.models.mechanical.mechanics import Friction, Stop


@fl.model
class Hardening(fl.MechanicalModel):
    """A mass on a spring whose force is a power of its extension."""

    p: float = fl.parameter(3.0, symbol="p")
    k: float = fl.parameter(1.0, symbol="k")
    stated: str = "odd"
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        """The force, stated in several ways."""
        kinetic, rest = (v.x**2 + v.y**2) / 2, q.y**2 / 2
        odd = self.k * q.x * abs(q.x) ** (self.p - 1)
        if self.stated == "odd":
            return Mechanics(kinetic, rest, loads={"x": -odd})
        if self.stated == "energy":
            return Mechanics(kinetic, rest + self.k * abs(q.x) ** (self.p + 1) / (self.p + 1))
        if self.stated == "cube":  # with a number as exponent, about x = 1
            return Mechanics(kinetic, rest + abs(2 - 2 * q.x) ** 3 / 24)
        if self.stated == "quadratic":
            return Mechanics(kinetic, rest, loads={"x": (1 - q.x) * abs(1 - q.x)})
        if self.stated == "square":
            return Mechanics(kinetic, rest, loads={"x": -self.k * q.x * (q.x**2) ** ((self.p - 1) / 2)})
        if self.stated == "stop":
            stop = Stop(q.x, fl.RestitutionImpact(e=1.0))
            return Mechanics(kinetic, rest, contacts=(stop,), loads={"x": -self.k * q.x**self.p})
        if self.stated == "pressed":
            normal = self.k * (1 + q.y**2) ** self.p
            return Mechanics(kinetic, rest, contacts=(Friction(1 - v.x, normal, fl.Coulomb()),))
        if self.stated == "speed":
            return Mechanics(kinetic, rest, dissipation=self.k * (v.x - v.y) ** self.p)
        if self.stated == "gap":
            return Mechanics(kinetic, rest, loads={"x": (1 - q.x) ** (-self.p)})
        return Mechanics(kinetic, rest, loads={"x": -self.k * q.x**self.p})


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (
            "bare",
            r"the load on 'x' .* must not have .* p as exponent of x, .* write abs\(x\)\*\*p, or",
        ),
        ("speed", r"dissipation .* as exponent of .*: write abs\("),
        ("gap", r"the load on 'x' .* as exponent of .*: write abs\("),
    ],
)
def test_a_base_that_can_be_negative_is_refused(stated, message):
    with pytest.raises(ValueError, match=message):
        fl.simulate(Hardening(stated=stated), 1.0, x0=[-0.5, 0, 0, 0], progress=False)


@dataclass(frozen=True, repr=False)
class Falling(fl.Coulomb):
    """Friction that falls with a power of the speed's distance from one at which it ends."""

    p: float = fl.parameter(1.5, symbol="p")
    ends: bool = True

    def kinetic(self, normal_force, speed):
        """mu_k N (1 - u)^p, or with a law that has a value at every speed, mu_k N / (1 + u)^p."""
        return self.mu_k * normal_force * ((1 - speed) ** self.p if self.ends else (1 + speed) ** -self.p)


def test_the_base_of_a_friction_law_is_looked_at_too():
    """Without: a run to speeds above 1 has no friction force, which is found along runs only."""
    message = "the friction law of MassOnBelt must not have the parameter p as exponent of 1 - speed"
    with pytest.raises(ValueError, match=message):
        fl.simulate(fl.MassOnBelt(friction=Falling(mu_s=0.4)), 1.0, progress=False)
    law = Falling(mu_s=0.4, ends=False)
    assert fl.simulate(fl.MassOnBelt(friction=law), 1.0, progress=False).status.ok


@pytest.mark.parametrize("stated", ["pressed", "stop"])
def test_a_base_that_is_positive_is_no_reason_to_refuse(stated):
    assert fl.simulate(Hardening(stated=stated), 1.0, x0=[0.5, 0, 0, 0], progress=False).status.ok


@pytest.mark.parametrize("stated", ["odd", "square", "energy"])
@pytest.mark.parametrize("tol", [1e-6, 1e-15])
def test_the_cure_gives_the_motion_of_a_cubic_spring(stated, tol):
    """x'' = -x^3 has x = A cn(A t, 1/2) with the parameter m = 1/2."""
    run = fl.simulate(
        Hardening(stated=stated), 20.0, x0=[-0.5, 0, 0, 0], method=fl.Taylor(tol=tol), progress=False
    )
    _, cn, _, _ = ellipj(0.5 * run.t, 0.5)
    assert run.status.ok
    np.testing.assert_allclose(run["x"], -0.5 * cn, atol=1e-13 + 10 * tol)


@pytest.mark.parametrize(("stated", "p", "centre"), [("odd", 1.7, 0), ("cube", 2, 1), ("quadratic", 2, 1)])
def test_a_power_that_is_not_odd_has_the_period_of_its_closed_form(stated, p, centre):
    """The period of x'' = -x |x|^(p - 1) is 4 sqrt((p + 1)/2) A^((1 - p)/2) B(1/(p + 1), 1/2)/(p + 1)."""
    from scipy.special import beta

    start = 0.8
    period = 4 * np.sqrt((p + 1) / 2) * start ** ((1 - p) / 2) * beta(1 / (p + 1), 0.5) / (p + 1)
    model = Hardening(p=p, stated=stated)
    run = fl.simulate(model, 3 * period, x0=[centre + start, 0, 0, 0], progress=False)
    assert run.final_state[0] == pytest.approx(centre + start, abs=1e-12)
    assert run.final_state[2] == pytest.approx(0.0, abs=1e-11)
