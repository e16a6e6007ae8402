"""Impulses of impacts: m (1 + e) v, Coulomb's cone, and what keeps a ball in the air."""

import gc
import pickle
import weakref

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.structures import motion


def test_a_ball_gives_the_ground_m_1_plus_e_v():
    ball = fl.BouncingBall(e=0.7)
    run = fl.simulate(ball, 2.0)
    p = run.events["impulse"]
    speed = np.sqrt(2 * ball.g * ball.h) * 0.7 ** np.arange(len(p))
    assert len(p) > 2
    assert p == pytest.approx(1.7 * speed, rel=1e-12)  # m = 1 kg


def test_impulses_of_a_period_carry_the_weight():
    """On a table that vibrates the mean force is m g, whatever the motion of the table."""
    model = fl.BallOnTable()
    orbit = fl.periodic_orbit(model, fl.simulate(model, 200.0, progress=False))
    run = fl.simulate(model, orbit.period, x0=orbit.state, progress=False)
    p = run.events["impulse"]
    assert p.sum() == pytest.approx(model.g * orbit.period, rel=1e-9)


def test_balls_of_a_cradle_pass_on_what_they_get():
    model = fl.NewtonsCradle(balls=3, e=0.8)
    run = fl.simulate(model, 0.3 * model.period, progress=False)
    p = run.events
    speed = model.a * np.sqrt(model.g / model.l)
    first, second = np.flatnonzero(p["impulse_1"])[0], np.flatnonzero(p["impulse_2"])[0]
    assert p["impulse_1"][first] == pytest.approx(0.9 * speed, rel=1e-12)  # (1 + e)/2
    assert p["impulse_2"][second] == pytest.approx(0.9**2 * speed, rel=1e-12)
    assert p["impulse_2"][first] == 0.0


@fl.model
class Thrown(fl.MechanicalModel):
    """A mass thrown on the ground, with friction in the impact."""

    impact: fl.ImpactLaw = fl.FrictionalImpact(e=0.5, mu_i=0.2)
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.2, mu_s=0.2)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        ground = fl.Stop(q.y, self.impact, friction=self.friction, relative_velocity=-v.x)
        return fl.Mechanics(3.0 * (v.x**2 + v.y**2) / 2, 3.0 * q.y, contacts=(ground,))


@pytest.mark.parametrize(("slip", "rubbed"), [(2.0, -0.2 * 3.0 * 1.5 * 2.0), (0.1, -3.0 * 0.1)])
def test_friction_impulses_are_in_the_cone(slip, rubbed):
    """mu p_N in slip; m v_r where it stops."""
    run = fl.simulate(Thrown(), 0.01, x0=[0.0, 1e-9, slip, -2.0])
    p = run.events
    assert p["impulse"][0] == pytest.approx(3.0 * 1.5 * 2.0, rel=1e-8)
    assert p["friction_impulse"][0] == pytest.approx(rubbed, rel=1e-8)


@fl.model
class BlockOnSlope(fl.MechanicalModel):
    """A block lies on an inclined floor; a ball falls on it."""

    angle: float = 0.3
    m1: float = 1.0
    m2: float = 2.0
    impact: fl.ImpactLaw = fl.RestitutionImpact(e=0.0)
    coordinates = ("x1", "y1", "x2", "y2")

    def mechanics(self, q, v):
        s, c = fl.functions.sin(self.angle), fl.functions.cos(self.angle)
        block, ball = c * q.y1 - s * q.x1, c * q.y2 - s * q.x2
        kinetic = (self.m1 * (v.x1**2 + v.y1**2) + self.m2 * (v.x2**2 + v.y2**2)) / 2
        stops = fl.Stop(block, self.impact), fl.Stop(ball - block - 0.1, self.impact)
        return fl.Mechanics(kinetic, 9.81 * (self.m1 * q.y1 + self.m2 * q.y2), contacts=stops)


@pytest.mark.parametrize(
    "law", [fl.RestitutionImpact(e=0.0), fl.PlasticImpact("full"), fl.RestitutionImpact(0.5)]
)
@pytest.mark.parametrize("number", range(4))
def test_each_body_gets_its_change_of_momentum(law, number):
    """The block never leaves the floor where e = 0: its gap is a rounding error of its place."""
    angle, along, m1, m2 = np.random.default_rng(number).uniform([-1.0, -3.0, 0.5, 0.5], [1.0, 3.0, 2.0, 2.0])
    n = np.array([-np.sin(angle), np.cos(angle)])
    block = along * np.array([n[1], -n[0]])
    model = BlockOnSlope(angle=angle, m1=m1, m2=m2, impact=law)
    run = fl.simulate(model, 0.35, x0=[*block, *(block + 0.3 * n), *np.zeros(4)], progress=False).events
    changes, p1, p2 = (run.state - run.before)[:, 4:], run["impulse_1"], run["impulse_2"]
    assert p1.max() > 0.1
    assert m1 * changes[:, :2] == pytest.approx(np.outer(p1 - p2, n), abs=1e-12)
    assert m2 * changes[:, 2:] == pytest.approx(np.outer(p2, n), abs=1e-12)


class HalfStopping(fl.RestitutionImpact):
    def friction(self, impulse, stopping_impulse):
        return stopping_impulse / 2


@fl.model
class ThrownOnSpring(Thrown):
    """The ground gives way."""

    def mechanics(self, q, v):
        ground = fl.Friction(-v.x, 50.0 * -q.y, self.friction, penetration=-q.y, impact=self.impact)
        return fl.Mechanics(3.0 * (v.x**2 + v.y**2) / 2, 3.0 * q.y, contacts=(ground,))


@pytest.mark.parametrize("model", [Thrown, ThrownOnSpring])
def test_friction_of_a_law_of_ones_own_acts_at_every_contact(model):
    run = fl.simulate(model(impact=HalfStopping(e=0.5)), 1e-6, x0=[0.0, 1e-9, 2.0, -2.0], progress=False)
    assert run.events.state[0, 2:] == pytest.approx([1.0, 1.0], rel=1e-8)
    assert run.events["friction_impulse"][0] == pytest.approx(-3.0 * 2.0 / 2, rel=1e-8)


def test_what_has_no_impacts_has_no_impulses():
    for run in (
        fl.solve(fl.BouncingBall().automaton(), 0.1, x0=[1.0, 0.0]),
        fl.simulate(fl.MassOnBelt(), 1.0),
    ):
        with pytest.raises(KeyError, match=r"the events have no 'impulse'; they have .*has an impact law"):
            run.events["impulse"]


def test_impulses_of_a_structure_derive_no_equations(monkeypatch):
    pads = fl.SlidingContacts(
        [[1.0, 0.0]], [[0.0, 1.0]], fl.LinearContact(k2=10.0), v=0.3, impact=fl.RestitutionImpact(e=0.5)
    )
    structure = fl.Structure(np.eye(2), np.zeros((2, 2)), contacts=pads)
    run = fl.simulate(structure, 0.1, x0=[0.0, -0.05, 0.0, 1.0], progress=False)
    monkeypatch.setattr(motion, "structure_system", None)
    assert run.events["impulse"] == pytest.approx([1.5], rel=1e-12)


def test_they_are_computed_once_and_a_run_is_free_when_nobody_has_it():
    run = fl.simulate(fl.BouncingBall(), 2.0)
    first, some = run.events["impulse"], run.events[:2]
    assert run.events["impulse"] is first
    gone = weakref.ref(run)
    del run
    assert some["impulse"].tolist() == first[:2].tolist()
    gc.disable()
    try:
        del some
        assert gone() is None
    finally:
        gc.enable()


def test_they_are_columns_beside_the_states_of_all_events_or_some():
    run = fl.simulate(fl.NewtonsCradle(), 5.0, progress=False)
    struck = run.events[run.events["impulse_2"] > 0.0]
    assert len(struck) < len(run.events)
    assert np.array_equal(struck["impulse_2"], run.events["impulse_2"][run.events["impulse_2"] > 0.0])
    assert np.array_equal(struck["x1'"], struck.state[:, 3])
    frame = pickle.loads(pickle.dumps(struck)).to_dataframe()
    assert np.array_equal(frame["impulse_2"], struck["impulse_2"])
    assert frame.attrs["units"]["impulse_2"] == "N s"
