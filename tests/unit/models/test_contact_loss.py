"""Contacts end where they would pull, and slide in one direction only where a belt gives it."""

from collections.abc import Mapping
from math import acos, atan2, exp, pi, sin, sqrt
from types import MappingProxyType

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import frictionlab as fl
from frictionlab.analysis.stated_conditions import broken_statement
from frictionlab.components import functions
from frictionlab.components.contact import Interface, SlidingOnly, StickSlip
from frictionlab.components.friction import FrictionLaw
from frictionlab.models import MechanicalModel, Mechanics
from frictionlab.models.mechanical.mechanics import Friction
from tests.reference.phases import until_events

ROLES: Mapping[str, type] = MappingProxyType({"friction": FrictionLaw})


def number(default, symbol):
    return fl.parameter(default, unit="", symbol=symbol, meaning=symbol, range=(-1e4, 1e4))


@fl.model
class Disc(MechanicalModel):
    """A disc under a torque, pressed by N0 + N1 cos(t)."""

    T: float = number(0.0, "T")
    N0: float = number(1.0, "N_0")
    N1: float = number(2.0, "N_1")
    steady: bool = False
    friction: FrictionLaw = fl.Coulomb(mu_k=0.2, mu_s=0.3)
    coordinates = ("turn",)

    def mechanics(self, q, v):
        press = self.N0 if self.steady else self.N0 + self.N1 * functions.cos(q.phase)
        return Mechanics(
            kinetic=v.turn**2 / 2,
            contacts=(Friction(-v.turn, press, self.friction),),
            loads={"turn": self.T},
            frequency=1,
        )


def test_a_disc_at_rest_does_not_begin_to_turn():
    run = fl.simulate(Disc(), 20.0)
    assert run.status.ok
    assert not run.final_state[:2].any()
    assert "separation" in run.mode


def test_a_normal_force_that_would_pull_is_none():
    """Stick to mu_s N = T, slip to N = 0, no contact to N = 0, slip again: by hand."""
    T = 0.1
    run = fl.simulate(Disc(T=T), 5.0)
    begin, lost, back = acos((T / 0.3 - 1) / 2), 2 * pi / 3, 4 * pi / 3
    assert run.events.guard.tolist() == ["cone-", "F_N", "F_N"]
    assert run.events.target.tolist() == ["slip-", "separation", "slip-"]
    np.testing.assert_allclose(run.events.t, [begin, lost, back], rtol=1e-13)

    def braked(a, b):
        return 0.2 * (b - a + 2 * sin(b) - 2 * sin(a))

    speed = T * (5.0 - begin) - braked(begin, lost) - braked(back, 5.0)
    assert run.final_state[1] == pytest.approx(speed, rel=1e-12)
    assert not broken_statement(run)


def test_a_given_normal_force_below_zero_is_refused():
    with pytest.raises(ValueError, match="normal force of contact 1 of Disc must be at least 0, got -1"):
        fl.simulate(Disc(steady=True, N0=-1.0), 1.0)


@fl.model
class Landing(MechanicalModel):
    """A ball on a belt, with a damper in the contact: beside a spring, or by Hunt and Crossley's law."""

    hunt: bool = False
    k: float = number(100.0, "k")
    c: float = number(3.0, "c")
    g: float = number(0.0, "g")
    friction: FrictionLaw = fl.Coulomb(mu_k=0.1, mu_s=0.1)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        if self.hunt:
            force, damper = self.k * (-q.y) ** 1.5 * (1 - self.c * v.y), 0.0
        else:
            force, damper = self.k * -q.y, self.c
        rubbing = Friction(50.0 - v.x, force, self.friction, penetration=-q.y, damper=damper)
        return Mechanics((v.x**2 + v.y**2) / 2, self.g * q.y, contacts=(rubbing,))


def test_a_damped_contact_lets_go_where_its_force_is_zero():
    """Its coefficient of restitution: Schwager & Poeschel, Granular Matter 9 (2007) 465-469, Eq. (17)."""
    run = fl.simulate(Landing(), 1.0, x0=[0.0, 0.0, 0.0, -2.0])
    damping = 1.5
    omega = sqrt(100.0 - damping**2)
    restitution = exp(-damping / omega * (pi - atan2(2 * damping * omega, omega**2 - damping**2)))
    assert run.final_state[3] == pytest.approx(2.0 * restitution, rel=1e-12)
    # all of the impulse is rubbed
    assert run.final_state[2] == pytest.approx(0.1 * 2.0 * (1 + restitution), rel=1e-12)
    assert run.events.target.tolist() == ["relaxation", "separation"]
    assert not broken_statement(run)
    assert fl.energy_audit(run, progress=False).error < 1e-13


@pytest.mark.parametrize("hunt", [False, True], ids=["Kelvin-Voigt", "Hunt-Crossley"])
def test_bounces_with_a_damper_agree_with_another_integrator(hunt):
    model = Landing(hunt=hunt, c=4.0 if not hunt else 0.2, k=400.0, g=9.81)

    def rates(_, z):
        depth, rate = max(-z[1], 0.0), z[3]
        law = 400.0 * depth**1.5 * (1 - model.c * rate) if hunt else 400.0 * depth - model.c * rate
        force = max(law, 0.0) if z[1] < 0.0 else 0.0
        return [z[2], rate, 0.1 * force, force - 9.81]

    start = [0.0, 0.3, 0.0, 0.0]
    found = solve_ivp(rates, (0.0, 1.2), start, "DOP853", rtol=1e-11, atol=1e-12, max_step=1e-3).y[:, -1]
    run = fl.simulate(model, 1.2, x0=start)
    assert len(run.events) >= 3
    np.testing.assert_allclose(run.final_state, found, rtol=1e-4 if not hunt else 1e-8, atol=1e-6)


@fl.model
class Bumper(MechanicalModel):
    """A mass against a contact without friction: a spring with a damper, or Hunt and Crossley's law."""

    hunt: bool = False
    m: float = number(2.0, "m")
    k: float = number(100.0, "k")
    c: float = number(3.0, "c")
    g: float = number(0.0, "g")
    coordinates = ("y",)

    def mechanics(self, q, v):
        if self.hunt:
            contact = fl.Contact(-q.y, lambda d: self.k * d**1.5, lambda d: self.k * self.c * d**1.5)
        else:
            contact = fl.Contact(-q.y, lambda d: self.k * d, self.c)
        return Mechanics(self.m * v.y**2 / 2, self.m * self.g * q.y, contacts=(contact,))


def test_a_damped_contact_without_friction_lets_go_where_its_force_is_zero():
    """Schwager and Poeschel's restitution, as above."""
    run = fl.simulate(Bumper(), 1.0, x0=[0.0, -2.0])
    damping = 3.0 / 4.0
    omega = sqrt(50.0 - damping**2)
    restitution = exp(-damping / omega * (pi - atan2(2 * damping * omega, omega**2 - damping**2)))
    assert run.final_state[1] == pytest.approx(2.0 * restitution, rel=1e-12)
    assert run.events.target.tolist() == ["relaxation", "separation"]
    assert run.normal_force.min() >= 0.0
    assert fl.energy_audit(run, progress=False).error < 1e-13


def test_hunt_and_crossleys_restitution_is_that_of_its_quadrature():
    """a - ln(1 + a) = -b - ln(1 - b) with a = c v, b = c e v, whatever k, m and the exponent: v dv over F."""
    run = fl.simulate(Bumper(hunt=True, c=0.4), 2.0, x0=[0.0, -2.0])
    a, b = 0.4 * 2.0, 0.4 * run.final_state[1]
    assert -b - np.log1p(-b) == pytest.approx(a - np.log1p(a), rel=1e-10)


@pytest.mark.parametrize("hunt", [False, True], ids=["Kelvin-Voigt", "Hunt-Crossley"])
def test_bounces_without_friction_are_those_of_another_integrator(hunt):
    """Contact and what is between, one after another, each to its end by DOP853."""
    model = Bumper(hunt=hunt, k=400.0, c=0.2 if hunt else 3.0, g=9.81)
    k, c, m = model.k, model.c, model.m

    def force(z):
        depth = max(-z[0], 0.0)
        return k * depth**1.5 * (1 - c * z[1]) if hunt else -k * z[0] - c * z[1]

    def pressed(t, z):
        return [z[1], force(z) / m - 9.81]

    def apart(t, z):
        return [z[1], -9.81]

    def opens(t, z):
        return -z[0] if hunt else force(z)  # 1 - c v stays above zero

    def lands(t, z):
        return z[0]

    phases = {"apart": (apart, ((lands, "pressed"),)), "pressed": (pressed, ((opens, "apart"),))}
    z, _ = until_events(phases, "apart", [0.3, 0.0], 1.5, atol=1e-14)
    run = fl.simulate(model, 1.5, x0=[0.3, 0.0])
    assert len(run.events) >= 3
    assert ("relaxation" in run.events.target) != hunt
    assert run.final_state == pytest.approx(z, abs=1e-9)


def test_a_contact_without_friction_rests_where_its_law_says():
    model = Bumper(hunt=True, g=9.81)
    point = fl.equilibrium(model)
    assert point.q[0] == pytest.approx(-((2.0 * 9.81 / 100.0) ** (2 / 3)), rel=1e-12)
    depth = -point.q[0]
    exact = np.roots([2.0, 300.0 * depth**1.5, 150.0 * depth**0.5])
    assert fl.eigenvalues(model).values == pytest.approx(np.sort_complex(exact), rel=1e-10)
    fl.testing.check_model(model, t_end=1.0)
    assert tuple(model.without("nonsmooth").automaton().names) == ("contact",)
    assert [str(one.lhs) for one in model.equations("contact").forces] == ["F_N(t)"]


def test_what_is_no_contact_is_refused():
    def stated(**given):
        @fl.model
        class Wrong(MechanicalModel):
            coordinates = ("y",)

            def mechanics(self, q, v):
                given_at = {name: make(q, v) for name, make in given.items()}
                contact = fl.Contact(**{"penetration": -q.y, "normal_force": -q.y, **given_at})
                return Mechanics(v.y**2 / 2, contacts=(contact,))

        return Wrong().automaton()

    def rubbed(**given):
        @fl.model
        class Wrong(MechanicalModel):
            friction: FrictionLaw = fl.Coulomb()
            coordinates = ("x",)

            def mechanics(self, q, v):
                return Mechanics(v.x**2 / 2, contacts=(Friction(1.0 - v.x, 1.0, self.friction, **given),))

        return Wrong().automaton()

    with pytest.raises(TypeError, match="penetration of a Contact of Wrong must be an expression"):
        stated(penetration=lambda q, v: None)
    with pytest.raises(ValueError, match=r"damper of Wrong must not depend on y'.*multiplies the rate"):
        stated(damper=lambda q, v: v.y)
    with pytest.raises(TypeError, match="normal_force of Wrong must be an expression"):
        stated(normal_force=lambda q, v: None)
    with pytest.raises(TypeError, match="nor has a damper without a penetration"):
        rubbed(damper=2.0)


@fl.model
class Carried(MechanicalModel):
    """A block on a belt of speed v (1 + a cos(t)), or v (1 + x); its contact has an interface of its own."""

    place: bool = False
    v: float = number(-1.0, "v")
    a: float = number(0.3, "a")
    interface: Interface = SlidingOnly()
    friction: FrictionLaw = fl.Coulomb(mu_k=0.2, mu_s=0.3)
    coordinates = ("x",)

    def mechanics(self, q, v):
        speed = self.v * (1 + q.x if self.place else 1 + self.a * functions.cos(q.phase))
        return Mechanics(
            kinetic=v.x**2 / 2,
            contacts=(Friction(speed - v.x, 1.0, self.friction, interface=StickSlip()),),
            frequency=1,
        )


@pytest.mark.parametrize("place", [False, True], ids=["time", "place"])
def test_sliding_only_follows_a_belt_whose_speed_varies(place):
    """With a constant force it moves as a falling body, also where it overtakes the belt."""
    model = Carried(place=place)
    assert tuple(model.automaton().names) == ("slip",)
    run = fl.simulate(model, 3.0)
    np.testing.assert_allclose(run.final_state[:2], [-0.9, -0.6], rtol=1e-13)


def test_a_belt_that_turns_round_ends_sliding_only():
    run = fl.simulate(Carried(a=2.0), 3.0)
    assert run.status is fl.Status.NO_ADMISSIBLE_MODE
    assert run.events.guard.tolist() == ["belt"]
    assert run.events.t[0] == pytest.approx(2 * pi / 3, rel=1e-13)


@pytest.mark.parametrize("model", [fl.DenHartog(), fl.MassOnBelt(v=0.0)], ids=["ground", "belt at rest"])
def test_without_a_belt_that_moves_there_is_no_direction_of_sliding(model):
    assert "nonsmooth" not in model.nonlinearities
    with pytest.raises(ValueError, match=r"contact 1 of \w+ must rub a belt that moves"):
        model.without("nonsmooth")
