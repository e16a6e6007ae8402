"""The energy balance of what moves with time: it closes, and works are those of an integration by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import frictionlab as fl
from frictionlab.components import Coulomb, PlasticImpact, RestitutionImpact
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.mechanics import Friction, Mechanics, Stop

A, G, M, L, W, K, E = 0.3, 9.81, 1.3, 0.7, 2.1, 4.0, 0.6
cos, sin = fl.functions.cos, fl.functions.sin


def pivot(q, v):
    """A pendulum whose pivot is moved along: T with all of v^2, v and 1."""
    hand = -A * W * sin(q.phase)
    return M * (hand**2 + 2 * hand * L * cos(q.x) * v.x + (L * v.x) ** 2) / 2


STATED = {
    "mass": lambda q, v: Mechanics(M * (1 + A * cos(q.phase)) * v.x**2 / 2, K * q.x**2 / 2, frequency=W),
    "spring": lambda q, v: Mechanics(M * v.x**2 / 2, K * (1 + A * cos(q.phase)) * q.x**2 / 2, frequency=W),
    "pivot": lambda q, v: Mechanics(pivot(q, v), -M * G * L * cos(q.x), frequency=W),
    "hoop": lambda q, v: Mechanics(M * L**2 * (v.x**2 + (W * sin(q.x)) ** 2) / 2, -M * G * L * cos(q.x)),
    "sawtooth": lambda q, v: Mechanics(M * v.x**2 / 2, (1 + q.phase) * q.x**2 / 2, frequency=W),
    # a ball on a plate that moves up and down
    "plate": lambda q, v: Mechanics(
        M * v.x**2 / 2,
        M * G * q.x,
        contacts=(Stop(q.x - A * sin(q.phase) / 10, RestitutionImpact(E)),),
        frequency=W,
    ),
    # the same, seen from the plate
    "on the plate": lambda q, v: Mechanics(
        M * (v.x + A * W * cos(q.phase) / 10) ** 2 / 2,
        M * G * (q.x + A * sin(q.phase) / 10),
        contacts=(Stop(q.x, RestitutionImpact(E)),),
        frequency=W,
    ),
    # a block on an elastic ground that moves up and down, and rubs on a belt of changing speed
    "ground": lambda q, v: Mechanics(
        M * (v.x**2 + v.y**2) / 2,
        K * q.x**2 / 2 - M * G * q.y,
        contacts=(
            Friction(
                1 + A * sin(q.phase) - v.x,
                lambda depth: 500 * depth,
                Coulomb(mu_k=0.2, mu_s=0.3),
                q.y - A * sin(2 * q.phase),
                impact=PlasticImpact("full"),
            ),
        ),
        frequency=W,
    ),
    # F_N that is no function of the penetration alone
    "pressed": lambda q, v: Mechanics(
        M * (v.x**2 + v.y**2) / 2,
        K * q.x**2 / 2 - M * G * q.y,
        contacts=(
            Friction(
                1 - v.x,
                lambda depth: 500 * (1 + A * sin(q.phase)) * depth,
                Coulomb(mu_k=0.2, mu_s=0.3),
                q.y - A * sin(2 * q.phase),
            ),
        ),
        frequency=W,
    ),
    # a block on a trolley with friction between the two
    "trolley": lambda q, v: Mechanics(
        M * (v.x - A * W * sin(q.phase)) ** 2 / 2 + (v.x + v.y + cos(q.phase)) ** 2 / 2,
        K * q.x**2 / 2,
        v.y**2 / 2,
        contacts=(Friction(0.2 - v.y, 3 + sin(q.phase), Coulomb(mu_k=0.2, mu_s=0.3)),),
        frequency=W,
    ),
}
TWO = "ground", "pressed", "trolley"


@fl.model
class InTime(MechanicalModel):
    """One or two coordinates and something that moves."""

    variant: str = "mass"

    @property
    def coordinates(self):
        """x, or x and y."""
        return ("x", "y") if self.variant in TWO else ("x",)

    def mechanics(self, q, v):
        """As the variant has it."""
        return STATED[self.variant](q, v)


def audited(variant, t_end=6.0):
    """A run that starts in motion, and its balance."""
    n = 2 if variant in TWO else 1
    start = [*([0.4] * n), *([0.3] * n)]
    run = fl.simulate(InTime(variant=variant), t_end, x0=start, progress=False)
    assert run.status.ok
    return run, fl.energy_audit(run, progress=False)


@pytest.mark.parametrize("variant", STATED)
def test_the_balance_of_what_moves_with_time_closes(variant):
    _, audit = audited(variant)
    assert audit.error < 1e-12
    assert audit.works["impacts"][-1] <= 1e-13


# By hand: q'' of t, q, q', and the power with which time does work.
BY_HAND = {
    "mass": (
        lambda t, x, v: (A * W * np.sin(W * t) * v - K / M * x) / (1 + A * np.cos(W * t)),
        lambda t, x, v, a: M * A * W * np.sin(W * t) * v**2 / 2,
        "moving masses",
    ),
    "spring": (
        lambda t, x, v: -K / M * (1 + A * np.cos(W * t)) * x,
        lambda t, x, v, a: -K * A * W * np.sin(W * t) * x**2 / 2,
        "moving springs",
    ),
    # the force on the pivot times its velocity: that of the bob's acceleration along
    "pivot": (
        lambda t, x, v: -G / L * np.sin(x) + A * W**2 / L * np.cos(W * t) * np.cos(x),
        lambda t, x, v, a: (
            M * (-A * W**2 * np.cos(W * t) + L * (a * np.cos(x) - v**2 * np.sin(x))) * -A * W * np.sin(W * t)
        ),
        "moving masses",
    ),
    # the moment of the hoop's motor, d/dt (m L^2 sin^2 x W), times W
    "hoop": (
        lambda t, x, v: W**2 * np.sin(x) * np.cos(x) - G / L * np.sin(x),
        lambda t, x, v, a: M * (L * W) ** 2 * np.sin(2 * x) * v,
        "moving masses",
    ),
}


@pytest.mark.parametrize("variant", BY_HAND)
def test_the_work_of_time_is_that_of_an_integration_by_hand(variant):
    slope, power, name = BY_HAND[variant]

    def rates(t, y):
        a = slope(t, y[0], y[1])
        return [y[1], a, power(t, y[0], y[1], a)]

    _, audit = audited(variant)
    expected = solve_ivp(rates, (0, 6.0), [0.4, 0.3, 0.0], method="DOP853", rtol=1e-13, atol=1e-14)
    assert audit.works[name][-1] == pytest.approx(expected.y[2, -1], abs=1e-11)
    assert np.abs(audit.works["impacts"]).max() == 0.0


def test_impacts_on_a_plate_lose_what_restitution_says_and_the_plate_does_the_rest():
    """Flights in closed form; an impact at the relative rate r loses m (1 - e^2) r^2/2."""
    run, audit = audited("plate", 1.5)

    def plate(t):
        return A * np.sin(W * t) / 10

    t, x, v, lost, done = 0.0, 0.4, 0.3, 0.0, 0.0
    for _ in range(4):  # the first impacts, well apart

        def height(s, x=x, v=v, t=t):
            return x + v * s - G * s**2 / 2 - plate(t + s)

        some = np.linspace(1e-9, 1.5, 4000)
        below = int(np.argmax([height(s) < 0 for s in some]))
        flight = brentq(height, some[below - 1] if below else 0.0, some[below], xtol=1e-15)
        x, v, t = x + v * flight - G * flight**2 / 2, v - G * flight, t + flight
        speed = A * W * np.cos(W * t) / 10
        lost -= M * (1 - E**2) * (v - speed) ** 2 / 2
        done += -M * (1 + E) * (v - speed) * speed
        v = speed - E * (v - speed)
    fourth = [e for e in run.events if e.guard == "impact"][3]
    assert fourth.t == pytest.approx(t, abs=1e-11)
    index = np.searchsorted(audit.t, fourth.t, side="right") - 1
    assert audit.works["impacts"][index] == pytest.approx(lost, rel=1e-10)
    assert audit.works["moving contacts"][index] == pytest.approx(done, rel=1e-9)


def test_the_same_motion_seen_from_the_plate_has_the_same_works():
    """A stop that moves, and a base that moves with the body: one energy, one work, one loss."""
    ground = fl.energy_audit(
        fl.simulate(InTime(variant="plate"), 1.0, x0=[0.4, 0.3], t_eval=[0, 1.0], progress=False)
    )
    model = InTime(variant="on the plate")
    start = [0.4, 0.3 - A * W / 10]
    moved = fl.energy_audit(fl.simulate(model, 1.0, x0=start, t_eval=[0, 1.0], progress=False))
    assert moved.total[-1] == pytest.approx(ground.total[-1], rel=1e-11)
    assert moved.works["impacts"][-1] == pytest.approx(ground.works["impacts"][-1], rel=1e-11)


def test_a_ground_that_moves_does_the_work_of_its_force():
    run, audit = audited("pressed")
    t = np.linspace(0, 6.0, 60001)
    force, phase = run.output("normal_force", t), run(t)[:, -1]
    power = -force * 2 * W * A * np.cos(2 * phase)
    assert audit.works["moving contacts"][-1] == pytest.approx(np.trapezoid(power, t), rel=1e-4)
