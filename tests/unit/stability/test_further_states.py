"""States beyond coordinates and velocities: equilibria, eigenvalues, boundaries and starts have them all."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import frictionlab as fl
from frictionlab.models.symbols import symbol
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem

pytestmark = pytest.mark.blas
VISCOUS = 0.1  # N s/m


@fl.model
class LuGre(fl.Model):
    """A mass on a belt, by the friction of Canudas de Wit, Olsson, Astrom and Lischinsky (1995)."""

    m: float = fl.parameter(1.0, unit="kg", symbol="m", meaning="mass", range=(0.1, 10.0))
    k: float = fl.parameter(2.0, unit="N/m", symbol="k", meaning="stiffness", range=(0.1, 10.0))
    v: float = fl.parameter(0.1, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.01, 10.0))
    s0: float = fl.parameter(1e3, unit="N/m", symbol="s_0", meaning="bristles", range=(1.0, 1e5))
    s1: float = fl.parameter(0.5, unit="N s/m", symbol="s_1", meaning="their damping", range=(0.0, 10.0))
    coordinates = ("x",)
    period = 4.4

    def derive(self):
        """x, x' and the bristles' deflection z; the belt stays the faster."""
        states = x, rate, z = symbol("x"), symbol("x'"), symbol("z")
        relative = self.v - rate
        bristles = relative - self.s0 * relative * z / (0.3 + 0.4 * sp.exp(-((relative / 0.2) ** 2)))
        friction = self.s0 * z + self.s1 * bristles + VISCOUS * relative
        flow = (rate, (friction - self.k * x) / self.m, bristles)
        sliding = fl.Mode("sliding", flow, (fl.Event("v_r", relative),))
        return fl.HybridAutomaton(states, (sliding,), {}, 1)


def by_hand(model):
    """The equilibrium and the state matrix: d g/d v_r is that of Stribeck's curve."""
    k, v, s0, s1 = model.k, model.v, model.s0, model.s1
    bell = 0.4 * np.exp(-((v / 0.2) ** 2))
    curve, slope = 0.3 + bell, -2 * v / 0.2**2 * bell
    by_rate, by_z = -slope * v / curve, -s0 * v / curve  # d z'/d x', d z'/d z, at s0 z = g
    matrix = [[0, 1, 0], [-k, s1 * by_rate - VISCOUS, s0 + s1 * by_z], [0, by_rate, by_z]]
    return np.array([(curve + VISCOUS * v) / k, 0.0, curve / s0]), np.array(matrix)


@pytest.mark.parametrize(
    "of", [lambda model: model, lambda model: model.automaton()], ids=["model", "its automaton"]
)
def test_bristles_are_part_of_the_equilibrium(of):
    model = LuGre()
    state, matrix = by_hand(model)
    values = np.sort_complex(np.linalg.eigvals(matrix))
    assert values.real.max() > 0.1  # with z = 0 they seem to decay
    found = fl.eigenvalues(of(model))
    np.testing.assert_allclose(found.equilibrium.state, state, rtol=1e-13, atol=1e-15)
    np.testing.assert_array_equal(found.equilibrium.q, found.equilibrium.state[:1])
    assert "z 0.0006" in repr(found.equilibrium)
    np.testing.assert_allclose(np.sort_complex(found.values), values, rtol=1e-9)


def test_boundaries_agree_with_eigenvalues():
    model = LuGre()

    def growth(v):
        return np.linalg.eigvals(by_hand(model.replace(v=v))[1]).real.max()

    critical = brentq(growth, 0.2, 1.0, xtol=1e-14)
    (change,) = fl.stability_changes(model, "v", (0.15, 1.0))
    assert (change.direction, change.value) == ("regain", pytest.approx(critical, rel=1e-9))
    point = fl.hopf(model, "v", (0.15, 1.0))
    np.testing.assert_allclose(point.state, by_hand(model.replace(v=critical))[0], rtol=1e-9, atol=1e-15)
    at = fl.eigenvalues(model.replace(v=point.value))
    assert at.growth_rates.max() == pytest.approx(0, abs=1e-9)
    assert at.values.imag.max() / (2 * np.pi) == pytest.approx(point.frequency, rel=1e-9)
    plane = fl.stability_map(model, ("v", [0.1, 1.0]), ("k", [1.0, 2.0]), progress=False)
    np.testing.assert_allclose(plane.growth[1], [growth(0.1), growth(1.0)], rtol=1e-9)


def test_a_start_near_it_has_its_further_states():
    model = LuGre()
    state, _ = by_hand(model)
    start = fl.simulate(model, 1e-3, x0="near", progress=False).problem.x0[:3]
    np.testing.assert_allclose(start, state * [1.01, 1, 1], rtol=1e-12, atol=1e-15)


def test_equilibria_that_differ_in_a_further_state_only():
    """A temperature with two states of rest beside one place: each is an equilibrium of its own."""
    x, rate, heat = symbol("x"), symbol("x'"), symbol("T")
    p = symbol("p")
    flow = (rate, p - x - rate, -(heat - 1) * (heat - 2))
    model = fl.HybridAutomaton((x, rate, heat), (fl.Mode("only", flow),), {p: 3.0}, 1)
    cold, hot = fl.equilibria(model)
    np.testing.assert_allclose([cold.state, hot.state], [[3, 0, 1], [3, 0, 2]], rtol=1e-12, atol=1e-15)
    for which, growth in ((cold, 1.0), (hot, -0.5)):
        values = equilibrium_problem(model, which).spectra({})
        assert values.real.max() == pytest.approx(growth)
    assert fl.eigenvalues(model).growth_rates.max() == pytest.approx(1.0)


@pytest.mark.parametrize("law", [fl.RateAndState(v_0=0.1), fl.RateAndStateSlip(v_0=0.1)])
@pytest.mark.parametrize("distance", [-1e-10, 3e-12, 1e-14])
def test_a_state_that_is_small_by_chance_has_its_equilibrium(law, distance):
    """psi = -log(v/v_0), which v = v_0 (1 + distance) leaves unknown to rounding."""
    v = 0.1 * (1.0 + distance)
    state = fl.equilibrium(fl.MassOnBelt(friction=law, v=v, N=2.0)).state
    assert state[2] == pytest.approx(-np.log(v / 0.1), abs=4e-16)
