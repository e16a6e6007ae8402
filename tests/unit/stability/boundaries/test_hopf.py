"""The Hopf point: closed forms, derivatives by other means, and cycles computed by the solver."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath
import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.stability.boundaries.hopf import hopf
from frictionlab.stability.equilibrium_points.sliding import sliding_equations
from frictionlab.stability.flow import EquilibriumDerivatives
from tests.helpers.cases import slow_but
from tests.helpers.lorenz import A, B, P, X, Y, Z, automaton, lorenz

pytestmark = pytest.mark.blas


# Closed forms


def test_van_der_pol():
    """x'' - (p - x^2) x' + x = 0: amplitude 2 sqrt(p), and no change of frequency in first order."""
    point = hopf(automaton((Y, (P - X**2) * Y - X), (X, Y), 1, p=-0.1), "p", (-0.31, 0.5))
    assert point.value == pytest.approx(0, abs=1e-12)
    assert point.frequency == pytest.approx(1 / (2 * np.pi))
    assert point.crossing_speed == pytest.approx(0.5)
    assert point.first_lyapunov == pytest.approx(-0.25)
    assert point.criticality == "supercritical"
    assert point.amplitude(0.01) == pytest.approx([0.2])
    assert point.cycle_frequency(0.01) == pytest.approx(1 / (2 * np.pi))
    assert point.amplitude([-0.01, 0.04]) == pytest.approx(np.array([[np.nan], [0.4]]), nan_ok=True)
    assert point.amplitude(point.value) == 0
    assert point.valid_until == np.inf


@pytest.mark.parametrize("bounds", [(-0.5, 2.0), (-1.0, 1.0), (-0.3, 0.1)])
def test_a_coefficient_that_is_zero_at_the_point_alone(bounds):
    """x'' - p (1 - x^2) x' + x = 0: all amplitudes are cycles at p = 0, and 2 above it."""
    point = hopf(automaton((Y, P * (1 - X**2) * Y - X), (X, Y), 1, p=-0.1), "p", bounds)
    assert point.value == pytest.approx(0, abs=1e-12)
    assert point.criticality == "degenerate"
    assert np.isnan(point.valid_until)


def test_a_mode_that_holds_all_states_has_no_vibration():
    """Van der Pol's oscillator, with an end stop behind it on which it may rest."""
    cycle = fl.Mode("cycle", (Y, (P - X**2) * Y - X), (fl.Event("stop", 5 - X, ("rest",)),))
    rest = fl.Mode("rest", (sp.S.Zero, sp.S.Zero), constraints=(X - 5, Y))
    stopped = fl.HybridAutomaton((X, Y), (cycle, rest), {P: -0.1}, coordinates=1)
    assert hopf(stopped, "p", (-0.31, 0.5)).value == pytest.approx(0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cubic", "speed", "coupling"), [(-0.3, 0.5, 0.0), (-0.3, -2.0, 0.9), (-0.3, 2.0, -0.7), (0.3, 0.5, 0.9)]
)
def test_a_cycle_that_is_known_in_other_coordinates(cubic, speed, coupling):
    """r' = speed p r + cubic r^3 - coupling r z, angle' = 3 + 0.4 r^2, z' = -2 z + r^2, in skewed states."""
    square = X**2 + Y**2
    growth = speed * P + cubic * square - coupling * Z
    flow = sp.Matrix(
        [growth * X - (3 + 0.4 * square) * Y, (3 + 0.4 * square) * X + growth * Y, square - 2 * Z]
    )
    skew = sp.Matrix([[2, 1, 0], [-1, 3, 1], [0.5, 0, 1]])
    back = dict(zip((X, Y, Z), skew.inv() * sp.Matrix([X, Y, Z]), strict=True))
    point = hopf(automaton(skew * flow.xreplace(back), (X, Y, Z), p=-0.01), "p", (-0.5, 0.6))
    total = cubic - coupling / 2
    p = -0.02 * np.sign(total * speed)  # on this side there is the cycle r^2 = -speed p / total
    radius = np.sqrt(-speed * p / total)
    plane = np.array(skew, dtype=float)[:, :2]
    assert point.crossing_speed == pytest.approx(speed)
    assert point.criticality == ("supercritical" if total < 0 else "subcritical")
    np.testing.assert_allclose(point.amplitude(p), radius * np.linalg.norm(plane, axis=1))
    assert np.isnan(point.amplitude(-p)).all()
    assert point.cycle_frequency(p) == pytest.approx((3 + 0.4 * radius**2) / (2 * np.pi))
    # w = r/2 times the length of the vector (1, -i) seen in these states.
    length = np.linalg.norm(plane @ [1, -1j])
    assert point.first_lyapunov == pytest.approx(4 * total / length**2 / 3)


@pytest.mark.parametrize("a", slow_but([0.5, 2.0], [0.5, 1.0, 2.0]))
def test_the_brusselator(a):
    """Kuramoto, "Chemical Oscillations, Waves, and Turbulence", Springer, 1984."""
    flow = (A - (B + 1) * X + X**2 * Y, B * X - X**2 * Y)
    point = hopf(automaton(flow, (X, Y), A=a, B=1.0), "B", (0.5 * (1 + a**2), 2 * (1 + a**2)))
    real, imaginary = (2 + a**2) / (2 * a**2), (4 - 7 * a**2 + 4 * a**4) / (6 * a**3)
    square = 0.01 / 2 / real  # |W|^2 at B = 1 + A^2 + 0.01: its growth rate is half of that
    assert point.value == pytest.approx(1 + a**2, rel=1e-12)
    assert point.crossing_speed == pytest.approx(0.5)
    assert point.criticality == "supercritical"
    assert point.first_lyapunov == pytest.approx(-real * a**2 / (2 * a**2 + 1) / a)
    assert point.amplitude(point.value + 0.01)[0] == pytest.approx(2 * np.sqrt(square))
    assert point.cycle_frequency(point.value + 0.01) == pytest.approx((a - imaginary * square) / (2 * np.pi))


def friction_oscillator():
    """x'' + 0.1 x' + x = 0.5 + 0.5 exp(-2 (v - x')) while it slips on a belt of speed v."""
    v = sp.Symbol("v", real=True)
    force = sp.Rational(1, 2) + sp.exp(-2 * (v - Y)) / 2
    return automaton((Y, force - X - 0.1 * Y), (X, Y), 1, (fl.Event("v_r", v - Y),), v=1.0)


def test_friction_that_falls_with_speed():
    point = hopf(friction_oscillator(), "v", (0.5, 2))
    assert point.value == pytest.approx(np.log(10) / 2, rel=1e-12)
    assert point.change.direction == "regain"
    assert point.crossing_speed == pytest.approx(-0.1)
    assert point.criticality == "subcritical"
    assert point.first_lyapunov == pytest.approx(0.05)  # f'''/8 for a vector of length 1, f''' = 0.4
    assert point.amplitude(point.value + 0.01) == pytest.approx([0.2])
    assert np.isnan(point.amplitude(point.value - 0.01))
    # Amplitude and speed of the cycle are 2 sqrt(v - v_c); it reaches the belt's.
    assert point.valid_until == pytest.approx(point.value + point.value**2 / 4)


@pytest.mark.slow
def test_lorenz():
    point = hopf(lorenz(), "r", (20, 30))
    assert point.value == pytest.approx(470 / 19, rel=1e-12)
    assert 2 * np.pi * point.frequency == pytest.approx(np.sqrt(8 / 3 * (10 + 470 / 19)))
    assert point.criticality == "subcritical"  # Marsden & McCracken, The Hopf Bifurcation, Springer 1976


FORCES = [-X - X**3, -X + X**2 - 4 * X**3, -3 * X + X**2]


@pytest.mark.parametrize("force", slow_but(FORCES[:1], FORCES))
def test_a_spring_alone_decides_nothing(force):
    point = hopf(automaton((Y, P * Y + force), (X, Y), 1, p=-0.1), "p", (-0.31, 0.5))
    assert point.first_lyapunov == 0
    assert point.criticality == "degenerate"
    assert np.isnan([*point.amplitude(0.1), point.cycle_frequency(0.1), point.valid_until]).all()


def test_a_linear_scene_decides_nothing():
    point = hopf(fl.SliderOnBelt().without("cubic", "geometry"), "mu_k", (0, 4))
    assert point.cubic == 0
    assert point.criticality == "degenerate"


# Derivatives


@dataclass(frozen=True)
class Stribeck(fl.FrictionLaw):
    """Friction that falls with speed, written with an absolute value."""

    mu_k: float = fl.parameter(0.4)
    fall: float = fl.parameter(0.3)

    def kinetic(self, normal_force, speed):
        """Decays to mu_k."""
        return normal_force * (self.mu_k + self.fall * sp.exp(-abs(speed)))

    def static_limit(self, normal_force):
        """At zero speed."""
        return normal_force * (self.mu_k + self.fall)


SCENES = [
    fl.SliderOnBelt(mu_k=1.4, k_nl=1e7),
    fl.SliderOnBelt(mu_k=1.4, k_nl=1e7).without("geometry"),
    fl.SliderOnBelt(k_nl=1e6, v=-2.0, friction=Stribeck()),
]


@pytest.mark.parametrize("model", slow_but(SCENES[:1], SCENES))
def test_derivatives_along_directions(model):
    """Against mpmath's differences of the automaton's flow with many digits."""
    scene = model.without("nonsmooth").automaton()
    symbols = [*scene.states, *scene.parameters]
    flow = sp.lambdify(symbols, scene.modes[0].flow, modules="mpmath")
    m, rng = len(scene.states), np.random.default_rng(1)
    start = np.concatenate([0.01 * rng.normal(size=m), list(scene.parameters.values())])
    directions = rng.normal(size=(3, m)) * np.repeat([0.01, 1.0], m // 2)
    equations = sliding_equations(model)
    assert equations is not None
    at = EquilibriumDerivatives(equations.flow, start[:m], equations.values(model))

    def expected(*directions):
        def moved(i):
            return lambda *s: flow(*(start + sum(mpmath.mpf(a) * d for a, d in zip(s, directions))))[i]

        with mpmath.workdps(60):
            zero, once = (0.0,) * len(directions), (1,) * len(directions)
            return np.array([mpmath.diff(moved(i), zero, once) for i in range(m)], dtype=float)

    padded = np.hstack([directions, np.zeros((3, len(start) - m))])
    for count in (2, 3):
        np.testing.assert_allclose(
            at.along(at.flow.rates, *directions[:count]), expected(*padded[:count]), rtol=1e-10
        )
    parameter = np.zeros(len(start))
    parameter[symbols.index(sp.Symbol("k2", real=True))] = 1.0
    k2 = at.flow.parameters.index("k2")
    np.testing.assert_allclose(at.by_parameter[:, k2], expected(parameter), rtol=1e-10)
    mixed = at.slopes_of_product(directions[0])[:, m + k2]
    np.testing.assert_allclose(mixed, expected(parameter, padded[0]), rtol=1e-10)


# Other views of the same point


@pytest.mark.parametrize(
    ("model", "bounds", "names"),
    [
        pytest.param(fl.SliderOnBelt(k_nl=1e7), (0, 0.8), "mu_k F k2 k_nl l1", marks=pytest.mark.slow),
        (SCENES[2], (0, 4), "mu_k l1"),
        pytest.param(SCENES[2], (0, 4), "F k2 k_nl", marks=pytest.mark.slow),
    ],
)
def test_speed_of_crossing(model, bounds, names):
    """Against differences of the eigenvalue; and the same point found along other parameters."""
    point = hopf(model, "mu_k", bounds)
    critical = model.replace(mu_k=point.value)
    for name in names.split():
        value = critical.parameters[name]
        same = hopf(critical, name, (0.99 * value, 1.02 * value))
        locus = fl.root_locus(critical, name, value * (1 + 1e-5 * np.array([-2, -1, 1, 2])))
        column = np.abs(locus.values[0] - 2j * np.pi * point.frequency).argmin()
        difference = np.array([1, -8, 8, -1]) @ locus.values[:, column] / (12e-5 * value)
        assert same.value == pytest.approx(value, rel=1e-10)
        assert same.slope == pytest.approx(difference, rel=1e-6)
        assert same.first_lyapunov == pytest.approx(point.first_lyapunov, rel=1e-7)


@pytest.mark.slow
def test_an_absolute_value_in_a_law_does_not_matter():
    @dataclass(frozen=True)
    class Plain(Stribeck):
        def kinetic(self, normal_force, speed):
            return normal_force * (self.mu_k + self.fall * sp.exp(-speed))

    plain, kinked = (hopf(SCENES[2].replace(friction=law()), "mu_k", (0, 4)) for law in (Plain, Stribeck))
    assert plain.first_lyapunov == pytest.approx(kinked.first_lyapunov)
    assert plain.valid_until == pytest.approx(kinked.valid_until)


def test_no_such_point():
    with pytest.raises(
        ValueError, match=r"bounds of mu_k must enclose .* got no change of stability in \(0, 1\)"
    ):
        hopf(fl.SliderOnBelt(), "mu_k", (0, 1))
    with pytest.raises(ValueError, match=r"got divergence at 0\.25 in"):
        hopf(automaton((Y, (P - 0.25) * X - Y), (X, Y), 1, p=0.0), "p", (-0.2, 0.7))
    undamped = dict.fromkeys(("c1", "c2", "c4", "c5", "c6"), 0.0)
    with pytest.raises(ValueError, match=r"mu_k = 1\.5138.* got two that coalesce.* some damping"):
        hopf(fl.SliderOnBelt(**undamped), "mu_k", (0, 4))
