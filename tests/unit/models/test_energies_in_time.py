"""Lagrange's equations where the kinetic energy depends on place and time: against equations by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

import frictionlab as fl
from frictionlab.components import Coulomb, PlasticImpact
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.contact_regimes import chatter_mode
from frictionlab.models.mechanical.mechanics import Friction, Mechanics

A, G, M, L, W, K = 0.3, 9.81, 1.3, 0.7, 2.1, 4.0  # amplitude, gravity, mass, length, frequency, stiffness
cos, sin = fl.functions.cos, fl.functions.sin


def growing_mass(q, v):
    """A mass on a spring, from which something drips and to which it returns."""
    return M * (1 + A * cos(q.phase)) * v.x**2 / 2, K * q.x**2 / 2


def base_along(q, v):
    """A pendulum whose pivot is at A cos(Omega t) along."""
    pivot = -A * W * sin(q.phase)
    return M * (pivot**2 + 2 * pivot * L * cos(q.x) * v.x + L**2 * v.x**2) / 2, -M * G * L * cos(q.x)


def base_upwards(q, v):
    """A pendulum whose pivot is at A cos(Omega t) upwards."""
    pivot = -A * W * sin(q.phase)
    kinetic = M * (pivot**2 + 2 * pivot * L * sin(q.x) * v.x + L**2 * v.x**2) / 2
    return kinetic, M * G * (A * cos(q.phase) - L * cos(q.x))


def hoop(q, v):
    """A bead on a hoop that turns about its vertical diameter."""
    return M * L**2 * (v.x**2 + (W * sin(q.x)) ** 2) / 2, -M * G * L * cos(q.x)


def crank(q, v):
    """A flywheel with a crank, whose inertia depends on its angle."""
    return (1 + A * sin(q.x) ** 2) * v.x**2 / 2, sympy.S.Zero


ENERGIES = {one.__name__: one for one in (growing_mass, base_along, base_upwards, hoop, crank)}
# x'' by hand, of t, x, x'
ACCELERATIONS = {
    "growing_mass": lambda t, x, v: (A * W * np.sin(W * t) * v - K / M * x) / (1 + A * np.cos(W * t)),
    "base_along": lambda t, x, v: -G / L * np.sin(x) + A * W**2 / L * np.cos(W * t) * np.cos(x),
    "base_upwards": lambda t, x, v: -(G - A * W**2 * np.cos(W * t)) / L * np.sin(x),
    "hoop": lambda t, x, v: W**2 * np.sin(x) * np.cos(x) - G / L * np.sin(x),
    "crank": lambda t, x, v: -A * np.sin(x) * np.cos(x) * v**2 / (1 + A * np.sin(x) ** 2),
}


@fl.model
class Moved(MechanicalModel):
    """One coordinate with one of the energies above."""

    variant: str = "hoop"
    coordinates = ("x",)

    def mechanics(self, q, v):
        """The energies, in numbers."""
        kinetic, potential = ENERGIES[self.variant](q, v)
        return Mechanics(kinetic, potential, frequency=W)


@pytest.mark.parametrize("variant", ENERGIES)
def test_motions_with_energies_in_time_are_those_of_equations_by_hand(variant):
    start, end = [0.4, 0.9], 5.0
    run = fl.simulate(Moved(variant=variant), end, x0=start, progress=False)
    slope = ACCELERATIONS[variant]
    expected = solve_ivp(
        lambda t, y: [y[1], slope(t, *y)], (0, end), start, method="DOP853", rtol=1e-13, atol=1e-14
    )
    np.testing.assert_allclose(run.final_state[:2], expected.y[:, -1], rtol=0, atol=1e-10)


@fl.model
class Trolley(MechanicalModel):
    """A pendulum on a trolley that is moved by hand, with a mass that changes: two coordinates and time."""

    coordinates = ("x", "y")

    def mechanics(self, q, v):
        """T with all of v^2, v, 1, place and time."""
        hand = -A * W * sin(q.phase)
        along, up = hand + v.x + L * cos(q.y) * v.y, L * sin(q.y) * v.y
        load = M * (1 + A * cos(q.phase))
        kinetic = load * (along**2 + up**2) / 2 + 2 * (v.x + hand * q.x) ** 2 / 2
        return Mechanics(kinetic, load * G * L * (1 - cos(q.y)) + K * q.x**2 / 2, frequency=W)


MOVED = [Moved(variant=name) for name in ENERGIES]


@pytest.mark.parametrize("model", [*MOVED, pytest.param(Trolley(), marks=pytest.mark.slow)], ids=str)
def test_printed_equations_are_those_of_sympys_own_lagrange(model):
    t, names = dynamicsymbols._t, model.coordinates
    q = [dynamicsymbols(name) for name in names]
    at = SimpleNamespace(**dict(zip(names, q, strict=True)), phase=W * t)
    about = model.mechanics(at, SimpleNamespace(**{n: x.diff(t) for n, x in zip(names, q, strict=True)}))
    expected = LagrangesMethod(about.kinetic - about.potential, q).form_lagranges_equations()
    printed = model.equations("only").motion
    rates = [x.diff(t) for x in q]
    rng = np.random.default_rng(37)
    for _ in range(3):
        values = [*zip([x.diff(t, 2) for x in q], rng.normal(size=len(q)), strict=True)]
        values += [*zip(rates, rng.normal(size=len(q)), strict=True), *zip(q, rng.normal(size=len(q)))]
        for own, other in zip(printed, expected, strict=True):
            ours = (own.lhs - own.rhs).subs({sympy.Symbol("t", real=True): t})
            ours = ours.subs({sympy.Function(n, real=True)(t): x for n, x in zip(names, q, strict=True)})
            numbers = [float(one.subs(values).subs(t, 0.37)) for one in (ours.doit(), other)]
            assert numbers[0] == pytest.approx(numbers[1], rel=1e-11, abs=1e-11)


@fl.model
class Tilted(MechanicalModel):
    """A mass on a tilted ground that moves with time, as does the mass: its landings may throw it off."""

    coordinates = ("x", "y")

    def mechanics(self, q, v):
        """W_N leaves out the tilt, as the paper's does."""
        contact = Friction(
            1 - v.x,
            lambda depth: 1e3 * depth,
            Coulomb(),
            q.y - A * cos(q.phase) - q.x * sin(q.phase) / 5,
            (0.0, -1.0),
            PlasticImpact("material"),
        )
        kinetic = M * (1 + A * cos(q.phase)) * (v.x**2 + v.y**2) / 2
        return Mechanics(kinetic, K * q.x**2 / 2 - 20 * q.y, contacts=(contact,), frequency=W)


def test_the_limit_of_impacts_keeps_the_gap_at_a_ground_that_moves():
    """d/dt of what the mode holds at zero is the next thing that it holds, and in the end zero."""
    model = Tilted()
    mode = chatter_mode(model.system())
    states = model.system().states
    values = dict(zip(states, [0.1, 0.2, 0.3, -0.4, 0.9], strict=True))

    def rate(expression):
        return sum(sympy.diff(expression, x) * r for x, r in zip(states, mode.flow, strict=True))

    first, second = mode.constraints
    assert float((rate(first) - second).subs(values)) == pytest.approx(0, abs=1e-14)
    assert float(rate(second).subs(values)) == pytest.approx(0, abs=1e-12)
    assert [event.name for event in mode.events][-1] == "period"
