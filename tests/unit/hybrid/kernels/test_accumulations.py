"""Zeno accumulations of several contacts: a box on two corners, against closed forms and event by event.

With rates u of the distances, an impact at corner i changes those by -(1 + e_i) u_i G_ji/G_ii, where
G = W^T M^-1 W.  For small angles G and the accelerations in flight are constant.
"""

from functools import cache

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from tests.helpers.automata import ONCE
from tests.helpers.cases import slow_but
from tests.reference.moreau import RigidSystem, time_steps

WIDE, NARROW = (
    0.05,
    0.2,
)  # moments of inertia for which an impact at one corner presses the other, or lifts it
B, GRAVITY = 0.3, 9.81  # half the distance of the corners, and gravity
METHODS = {"default": fl.Taylor(), "loose": fl.Taylor(tol=1e-6)}


@cache
def box():
    """Distances and rates of two corners, unit mass; both fly, one is held, or both rest."""
    y, angle, v, turn, inertia, *es = sp.symbols("y angle v turn J e_1 e_2", real=True)
    arms = (-B, B)
    gaps, rates = [y + arm * angle for arm in arms], [v + arm * turn for arm in arms]
    soft = 1 + B**2 / inertia

    def hit(i):
        def pushed(e):
            p = -(1 + e) * rates[i] / soft
            return {v: v + p, turn: turn + arms[i] * p / inertia}

        closed = Reset(pushed(0), {gaps[i]: 2, rates[i]: 1})
        return Event(f"corner {i + 1}", gaps[i], (), Reset(pushed(es[i]), {gaps[i]: 1}), closed)

    def flow(*forces):
        turning = sum(arm * force for arm, force in zip(arms, forces, strict=True)) / inertia
        return (v, turn, sp.expand(sum(forces) - GRAVITY), sp.expand(turning))

    load = GRAVITY / soft
    rest = Mode("rest", (v, turn, sp.S.Zero, sp.S.Zero), (), (*gaps, *rates))
    left = Mode("left", flow(load, 0), (hit(1),), (gaps[0], rates[0]))
    right = Mode("right", flow(0, load), (hit(0),), (gaps[1], rates[1]))
    flight = Mode("flight", flow(0, 0), (hit(0), hit(1)))
    numbers = {inertia: WIDE, es[0]: 0.3, es[1]: 0.3}
    return HybridAutomaton((y, angle, v, turn), (rest, left, right, flight), numbers, 2)


def walk(inertia, es, gaps, rates):
    """When both corners rest, from one event to the next in 40 digits.

    A corner whose own bounces would end within 1e-20 of the time since the start is closed.
    """
    with mp.workdps(40):
        soft, cross = 1 + mp.mpf(B) ** 2 / inertia, 1 - mp.mpf(B) ** 2 / inertia
        share, free = cross / soft, -mp.mpf(GRAVITY)
        g, u, held, t = [mp.mpf(x) for x in gaps], [mp.mpf(x) for x in rates], [False, False], mp.mpf(0)
        for _ in range(20_000):
            a = [free * (1 - share) if held[1 - i] else free for i in (0, 1)]
            times = [fall_time(g[i], u[i], a[i]) if not held[i] else mp.inf for i in (0, 1)]
            i = int(times[1] < times[0])
            h, j = times[i], 1 - i
            t += h
            for k in (0, 1):
                if not held[k]:
                    g[k], u[k] = g[k] + u[k] * h + a[k] * h**2 / 2, u[k] + a[k] * h
            closes = es[i] == 0 or -2 * es[i] * u[i] < mp.mpf(10) ** -20 * t * (1 - es[i]) * -a[i]
            u[j] -= (1 + (0 if closes else es[i])) * share * u[i]
            g[i], u[i] = mp.mpf(0), mp.mpf(0) if closes else -es[i] * u[i]
            held = [closes, False] if i == 0 else [False, closes]
            if closes and g[j] < mp.mpf(10) ** -38 and abs(u[j]) < mp.mpf(10) ** -18:
                return float(t)
    raise AssertionError("the box does not come to rest")


def fall_time(gap, rate, acceleration):
    """When a distance comes to zero; now if it is zero and shrinks."""
    if gap <= 0 and rate < 0:
        return mp.mpf(0)
    return (rate + mp.sqrt(rate**2 - 2 * acceleration * gap)) / -acceleration


CASES = [
    (inertia, e_1, e_2)
    for inertia in (WIDE, NARROW)
    for e_1, e_2 in ((0.3, 0.3), (0.3, 0.6), (0.0, 0.5), (0.7, 0.1), (0.05, 0.05), (0.0, 0.0))
]


@pytest.mark.parametrize(("inertia", "e_1", "e_2"), slow_but(CASES[1::3], CASES, several=True))
def test_a_box_comes_to_rest_when_the_walk_does(inertia, e_1, e_2):
    """The last event is the walk's, and nothing moves after it."""
    model = box().replace(J=inertia, e_1=e_1, e_2=e_2)
    for x0 in ([0.5, 0.2, 0.0, 0.0], [0.1, 0.02, 0.0, -0.4]):
        gaps, rates = [x0[0] - B * x0[1], x0[0] + B * x0[1]], [x0[2] - B * x0[3], x0[2] + B * x0[3]]
        run = fl.solve(model, 3.0, x0=x0, progress=False)
        assert run.mode[-1] == "rest"
        assert run.events.t[-1] == pytest.approx(walk(inertia, (e_1, e_2), gaps, rates), rel=2e-11)
        assert np.abs(run.final_state).max() < 1e-12
        energies = run.v[:, 0] ** 2 / 2 + inertia * run.v[:, 1] ** 2 / 2 + GRAVITY * run.q[:, 0]
        assert np.diff(energies).max() < 1e-13


@ONCE
@pytest.mark.parametrize("name", METHODS)
def test_a_box_that_rocks_from_corner_to_corner(name):
    """Plastic corners: each takes over with the share r = G_12/G_11 of the closing rate u, and the next lands
    after 2 r u/(g (1 - r)): the end is a geometric series."""
    model, height = box().replace(J=NARROW, e_1=0.0, e_2=0.0), 0.06
    r = (1 - B**2 / NARROW) / (1 + B**2 / NARROW)
    fall = GRAVITY * (1 - r)
    rate = np.sqrt(2 * fall * height)
    run = fl.solve(
        model, 1.0, x0=[height / 2, height / (2 * B), 0.0, 0.0], method=METHODS[name], progress=False
    )
    assert run.mode[[0, -1]].tolist() == ["left", "rest"]
    assert run.events.t[-1] == pytest.approx(rate / fall * (1 + 2 * r / (1 - r)), rel=1e-12)


def flat_box(laws, load=None, arms=(-B, B), heights=(0.1, 0.1), mu=0.3):
    @fl.model
    class FlatBox(fl.MechanicalModel):
        """A box that slides on rough corners; small angles."""

        coordinates = ("x", "y", "angle")

        def mechanics(self, q, v):
            def corner(law, arm, height):
                distance, along = q.y + arm * q.angle, v.x + height * v.angle
                return fl.Stop(distance, law, friction=fl.Coulomb(mu, mu), relative_velocity=-along)

            kinetic = (v.x**2 + v.y**2 + NARROW * v.angle**2) / 2
            loads = {} if load is None else {"y": load * q.t}
            contacts = tuple(map(corner, laws, arms, heights))
            return fl.Mechanics(kinetic, GRAVITY * q.y, loads=loads, contacts=contacts)

    return FlatBox()


@pytest.mark.slow
def test_with_friction_a_box_slides_as_far_as_moreaus_scheme_says():
    law = fl.FrictionalImpact(e=0.3, mu_i=0.3)
    start, t_end = [0.0, 0.1, 0.05, 3.0, 0.0, 0.0], 0.8
    run = fl.simulate(flat_box((law, law)), t_end, x0=start, progress=False)
    assert run.status.ok
    assert run.stats["accumulations"] > 0
    system = RigidSystem(
        masses=np.diag([1.0, 1.0, NARROW]),
        forces=lambda q: np.array([0.0, -GRAVITY, 0.0]),
        gaps=lambda q: np.array([q[1] - B * q[2], q[1] + B * q[2]]),
        normals=np.array([[0, 1, -B], [0, 1, B]]),
        tangents=np.array([[1, 0, 0.1], [1, 0, 0.1]]),
        restitution=np.array([0.3, 0.3]),
        friction=0.3,
    )
    steps = time_steps(system, np.array(start[:3]), np.array(start[3:]), t_end, 2e-4)
    assert steps[-1, 1] == pytest.approx(run.q[-1, 0], abs=4e-3)
    energies = (run.v**2 @ [1.0, 1.0, NARROW]) / 2 + GRAVITY * run.q[:, 1]
    assert np.diff(energies).max() < 1e-13


@pytest.mark.parametrize(
    ("arms", "heights"),
    [
        ((-B, B), (0.1, 0.1)),
        pytest.param((-B, 0.05, B), (0.1, 0.0, 0.2), marks=pytest.mark.slow),  # many modes to derive
    ],
)
def test_a_box_that_slides_comes_to_rest_on_all_corners_at_once(arms, heights):
    """After v^2/(2 mu g).  Its rotation, on which each v_r depends, is zero but for rounding."""
    laws = (fl.PlasticImpact("full"),) * len(arms)
    run = fl.simulate(
        flat_box(laws, arms=arms, heights=heights), 0.5, x0={"x'": 1.0}, t_eval=[0.0, 0.5], progress=False
    )
    assert run.status.ok
    assert len(run.events) == 1
    assert run.events.t[0] == pytest.approx(1.0 / (0.3 * GRAVITY), rel=1e-13)
    assert run.q[-1] == pytest.approx([1.0 / (0.6 * GRAVITY), 0.0, 0.0], abs=1e-13)
    assert np.abs(run.v[-1]).max() < 1e-13


@pytest.mark.slow
def test_a_tall_box_tips_rocks_and_comes_to_rest():
    """It slips, tips, sticks and falls back, ever less: slip and stick are part of the accumulation."""
    law, mu, heights = fl.FrictionalImpact(e=0.0, mu_i=0.8), 0.8, (0.5, 0.5)
    model = flat_box((law, law), heights=heights, mu=mu)
    run = fl.simulate(model, 1.5, x0={"x'": 1.0}, progress=False)
    assert run.status.ok
    assert len(run.events) < 100
    assert np.abs(run.v[-1]).max() < 1e-12
    system = RigidSystem(
        masses=np.diag([1.0, 1.0, NARROW]),
        forces=lambda q: np.array([0.0, -GRAVITY, 0.0]),
        gaps=lambda q: np.array([q[1] - B * q[2], q[1] + B * q[2]]),
        normals=np.array([[0, 1, -B], [0, 1, B]]),
        tangents=np.array([[1, 0, 0.5], [1, 0, 0.5]]),
        restitution=np.zeros(2),
        friction=mu,
    )
    steps = time_steps(system, np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.5, 1e-4)
    assert steps[-1, 1] == pytest.approx(run.q[-1, 0], abs=1e-5)


@pytest.mark.slow
def test_a_load_parts_what_came_to_rest():
    """It grows with time, and lifts both corners at once where it is the weight."""
    law = fl.RestitutionImpact(e=0.3)
    run = fl.simulate(
        flat_box((law, law), load=5.0), 2.5, x0=[0.0, 0.1, 0.05, 5.0, 0.0, 0.0, 0.0], progress=False
    )
    assert run.status.ok
    lifted = run.events.t[[guard.startswith("off") for guard in run.events.guard]]
    assert lifted[-1] == pytest.approx(GRAVITY / 5.0, rel=1e-9)
    assert run.final_state[1] == pytest.approx(5.0 * (2.5 - GRAVITY / 5.0) ** 3 / 6, rel=1e-9)


def test_many_boxes_side_by_side_end_as_one_after_another():
    starts = np.array([[0.5, 0.2, 0.0, 0.0], [0.1, 0.02, 0.0, -0.4], [0.3, -0.1, 0.5, 0.0]])
    many = fl.ensemble([box()] * 3, 3.0, x0=starts, progress=False)
    single = [fl.solve(box(), 3.0, x0=one, progress=False).final_state for one in starts]
    assert np.array_equal(many.states, single)


@pytest.mark.parametrize("balls", slow_but([4], [3, 4, 5, 7]))
def test_elastic_balls_that_touch_pass_the_blow_on_for_ever(balls):
    """Ten swings: rounding errors of the distances grow meanwhile, and are no events."""
    model = fl.NewtonsCradle(balls=balls, e=1.0)
    run = fl.simulate(model, 10 * model.period, progress=False)
    assert run.status.ok
    assert np.abs(run.final_state - [-model.a, *[0.0] * (2 * balls - 1)]).max() < 1e-13
    energies = (run.v**2 + run.q**2).sum(axis=1) / 2
    assert energies == pytest.approx(np.full(len(energies), model.a**2 / 2), rel=1e-13)


@pytest.mark.parametrize("frequency", slow_but([1.0], [1.0, 2.0, 31.4]))
def test_a_table_that_shakes_with_the_weight_of_its_ball(frequency):
    """A Omega^2 = g: the force of the contact touches zero once in a period, and the ball stays."""

    @fl.model
    class Ball(fl.MechanicalModel):
        """Above a table that shakes."""

        Omega: float = fl.parameter(1.0, unit="rad/s", symbol="O", meaning="frequency", range=(1.0, 100.0))
        impact: fl.ImpactLaw = fl.RestitutionImpact(e=0.5)
        coordinates = ("y",)

        def mechanics(self, q, v):
            shaken = {"y": GRAVITY * fl.functions.cos(q.phase)}
            stop = fl.Stop(q.y, self.impact)
            return fl.Mechanics(
                v.y**2 / 2, GRAVITY * q.y, loads=shaken, contacts=(stop,), frequency=self.Omega
            )

    for height in (0.0, 0.1):
        run = fl.simulate(Ball(Omega=frequency), 10 * 2 * np.pi / frequency, x0={"y": height}, progress=False)
        assert run.status.ok
        assert np.abs(run.final_state[:2]).max() < 1e-12
