"""Friction at the piston of a crank: at a dead centre the piston stands still and cannot hold the crank."""

from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import pi, sin

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.analysis.stated_conditions import broken_statement
from frictionlab.components import functions
from frictionlab.components.friction import FrictionLaw
from frictionlab.models import MechanicalModel, Mechanics
from frictionlab.models.mechanical.mechanics import Friction
from tests.reference.phases import until_events

INERTIA, RADIUS, PRESS = 2.0, 0.3, 1.5
STATIC, KINETIC = 0.5, 0.4


@fl.model
class Crank(MechanicalModel):
    """A flywheel and a piston, which rubs `pads` times; a torque T - k (theta - 2) turns it."""

    pads: int = 1
    T: float = fl.parameter(0.0, unit="N m", symbol="T", meaning="torque", range=(-1.0, 1.0))
    k: float = fl.parameter(0.0, unit="N m/rad", symbol="k", meaning="spring", range=(0.0, 1.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=KINETIC, mu_s=STATIC)
    coordinates = ("theta",)

    def mechanics(self, q, v):
        piston = RADIUS * functions.sin(q.theta) * v.theta
        return Mechanics(
            kinetic=INERTIA * v.theta**2 / 2,
            potential=self.k * (q.theta - 2.0) ** 2 / 2,
            contacts=(Friction(piston, PRESS / self.pads, self.friction),) * self.pads,
            loads={"theta": self.T},
        )


@fl.model
class Flywheel(MechanicalModel):
    """A piston that hardly rubs."""

    N: float = 1e-3
    friction: FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    coordinates = ("theta",)

    def mechanics(self, q, v):
        piston = Friction(-0.2 * functions.sin(q.theta) * v.theta, self.N, self.friction)
        return Mechanics(v.theta**2 / 2, contacts=(piston,))


@pytest.mark.parametrize("N", [1e-7, pytest.param(1e-5, marks=pytest.mark.slow), 1e-3])
def test_a_motion_that_changes_little_beside_its_velocity_is_verified(N):
    """Friction takes 0.06 N (1 + cos 0.3) of the energy 2 from theta = 0.3 to pi."""
    model = Flywheel(N=N)
    assert fl.verify(model, 5.0, x0=[0.3, 2.0], progress=False).ok
    at = fl.simulate(model, 5.0, x0=[0.3, 2.0], progress=False).events.state[0]
    assert at[0] == pytest.approx(np.pi, rel=1e-14)
    assert 2.0 - at[1] ** 2 / 2 == pytest.approx(0.06 * N * (1 + np.cos(0.3)), abs=1e-14)


@pytest.mark.parametrize("method", ["taylor", "DOP853", fl.RK4(step=1e-2)], ids=["taylor", "scipy", "rk4"])
def test_a_crank_turns_past_its_dead_centres(method):
    """From one to the next friction takes 2 r mu N of its energy; after each the piston slides back."""
    run = fl.simulate(Crank(), 20.0, x0=[0.5, 1.8], method=method)
    places, rates = run.events.state.T
    assert len(places) >= 7
    rtol = 1e-12 if method == "taylor" else 1e-5
    np.testing.assert_allclose(places, pi * np.arange(1, len(places) + 1), rtol=rtol)
    np.testing.assert_allclose(
        np.diff(INERTIA * rates**2 / 2),
        -2 * RADIUS * KINETIC * PRESS,
        rtol=1e3 * rtol if rtol > 1e-9 else rtol,
    )
    assert set(run.events.target) == {"slip+", "slip-"}
    assert not run.time_in_mode.get("stick")


@fl.model
class CrankOnBearing(Crank):
    """Its bearing rubs as well: that of which v_r is not zero at a dead centre."""

    def mechanics(self, q, v):
        stated = super().mechanics(q, v)
        return replace(stated, contacts=(*stated.contacts, Friction(-0.1 * v.theta, PRESS, self.friction)))


@pytest.mark.parametrize(
    ("method", "rel"),
    [("taylor", 1e-12), ("DOP853", 1e-6), (fl.RK4(step=1e-2), 1e-6)],
    ids=["taylor", "scipy", "rk4"],
)
def test_a_bearing_rubs_on_where_the_piston_stands_still(method, rel):
    """From one dead centre to the next both take energy, and the crank stops where there is none left."""
    run = fl.simulate(CrankOnBearing(), 25.0, x0=[0.5, 1.8], method=method, progress=False)
    *passed, (end, _) = run.events.state
    places, rates = np.array(passed).T
    assert places == pytest.approx(pi * np.arange(1, len(places) + 1), rel=rel)
    lost = KINETIC * PRESS * (2 * RADIUS + 0.1 * pi)
    assert np.diff(INERTIA * rates**2 / 2) == pytest.approx([-lost] * (len(places) - 1), rel=rel)
    beyond = _length_of_path(places[-1], end) * RADIUS + 0.1 * (end - places[-1])
    assert INERTIA * rates[-1] ** 2 / 2 == pytest.approx(KINETIC * PRESS * beyond, rel=rel)
    assert run.final_state == pytest.approx([end, 0.0], abs=1e-12)


@pytest.mark.parametrize("method", ["taylor", "DOP853", "Radau"])
def test_a_crank_that_a_spring_moves_from_rest_comes_to_rest(method):
    """There friction has taken what the spring has given."""
    run = fl.simulate(CrankOnBearing(k=1.0), 60.0, x0=[0.5, 0.0], method=method, progress=False)
    assert run.status.ok
    places = [0.5, *run.events.state[:, 0]]
    rubbed = sum(RADIUS * _length_of_path(a, b) + 0.1 * abs(b - a) for a, b in pairwise(places))
    given = (2.0 - places[0]) ** 2 / 2 - (2.0 - places[-1]) ** 2 / 2
    assert given == pytest.approx(KINETIC * PRESS * rubbed, rel=1e-6)
    assert run.final_state == pytest.approx([places[-1], 0.0], abs=1e-12)


@fl.model
class CrankAndRod(MechanicalModel):
    """A torque turns a crank, whose rod moves a piston that has a mass and rubs."""

    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=0.8)
    coordinates = ("theta",)
    cyclic = ("theta",)

    def mechanics(self, q, v):
        s, c = functions.sin(q.theta), functions.cos(q.theta)
        slope = -0.4 * s - 0.16 * s * c / functions.sqrt(1.0 - 0.16 * s**2)
        kinetic = 0.15 * v.theta**2 + (slope * v.theta) ** 2 / 2
        return Mechanics(
            kinetic, contacts=(Friction(-slope * v.theta, 5.0, self.friction),), loads={"theta": 3.0}
        )


def test_a_crank_that_has_turned_many_times_is_no_false_alarm():
    """Sums of the terms of its mass grew with a power of the angle, and the sizes that judge with them."""
    found = fl.verify(CrankAndRod(), 5.0, x0=[0.7, 2.0], progress=False)
    assert found.ok, str(found)
    (place, rate), turns = found.run.events.state[-1], len(found.run.events)
    way = 0.4 * np.cos(0.7) + np.sqrt(1.0 - 0.16 * np.sin(0.7) ** 2) - 0.6 + (turns - 1) * 0.8
    begin = (
        0.15 + (0.4 * np.sin(0.7) * (1 + 0.4 * np.cos(0.7) / np.sqrt(1 - 0.16 * np.sin(0.7) ** 2))) ** 2 / 2
    ) * 4
    assert turns > 15
    assert place == pytest.approx(turns * pi, rel=1e-12)
    assert 0.15 * rate**2 == pytest.approx(begin + 3.0 * (place - 0.7) - 2.5 * way, rel=1e-11)


@pytest.mark.parametrize("torque", [1e-3, -0.05])
@pytest.mark.parametrize("beside", [0.0, 1e-13, 1e-10, 1e-6, -1e-3, 0.02, 0.3])
@pytest.mark.parametrize("centre", [0.0, pi])
def test_beside_a_dead_centre_the_piston_holds_as_much_as_its_lever_allows(torque, beside, centre):
    """At rest the torque is held up to mu_s N r |sin theta|, which is nothing at the dead centre."""
    start = centre + beside
    run = fl.simulate(Crank(T=torque), 0.5, x0=[start, 0.0])
    lever = RADIUS * abs(sin(start))
    assert run.status.ok
    assert not broken_statement(run)
    if abs(torque) <= STATIC * PRESS * lever:
        assert run.mode[0] == "stick"
        assert run.final_state.tolist() == [start, 0.0]
    else:
        # as long as it is far from the limit friction takes little of the torque's work
        turned, rate = run.final_state - [start, 0.0]
        work = INERTIA * rate**2 / 2
        taken = KINETIC * PRESS * RADIUS * _length_of_path(start, start + turned)
        assert work == pytest.approx(torque * turned - taken, rel=1e-10)
        assert work > 0.0


def _length_of_path(begin, end):
    """Integral of |sin|, of which no more than one dead centre lies between."""
    edges = sorted((begin, end))
    middle = pi * np.ceil(edges[0] / pi)
    if edges[0] < middle < edges[1]:
        return _length_of_path(edges[0], middle) + _length_of_path(middle, edges[1])
    return abs(np.cos(edges[1]) - np.cos(edges[0]))


def independent_crank(k, start, t_end):
    """Turning points, and where it stays, by scipy, with friction against the crank's rate."""

    def rates(_, x, sign):
        return [x[1], (-k * (x[0] - 2.0) - sign * KINETIC * PRESS * RADIUS * abs(sin(x[0]))) / INERTIA]

    def then(_, x):
        pull = -k * (x[0] - 2.0)
        held = abs(pull) <= STATIC * PRESS * RADIUS * abs(sin(x[0]))
        return ("rest", [x[0], 0.0]) if held else (np.sign(pull), [x[0], np.sign(pull) * 1e-13])

    phases = {"rest": (lambda _, x: [0.0, 0.0], ())}
    phases |= {
        sign: (partial(rates, sign=sign), ((lambda _, x, sign=sign: sign * x[1], then),))
        for sign in (1.0, -1.0)
    }
    end, turns = until_events(phases, np.sign(start[1]), start, t_end, max_step=0.02)
    return [x[0] for _, _, x in turns], end


@pytest.mark.parametrize("pads", [1, 2])
def test_a_crank_on_a_spring_swings_through_its_dead_centres_and_sticks(pads):
    turns, end = independent_crank(0.15, [2.0, 1.2], 200.0)
    run = fl.simulate(Crank(pads=pads, k=0.15), 200.0, x0=[2.0, 1.2])
    assert run.status.ok
    assert set(run.mode[-1].split(" | ")) == {"stick"}
    rest = np.abs(run.events.state[:, 1]) < 1e-9
    assert len(turns) == 3
    assert max(turns) > pi
    np.testing.assert_allclose(run.events.state[rest, 0], turns, rtol=1e-8)
    np.testing.assert_allclose(run.final_state, end, rtol=1e-8, atol=1e-10)
