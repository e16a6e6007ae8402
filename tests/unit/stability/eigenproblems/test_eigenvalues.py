"""Eigenvalues: the paper's numbers, its matrix of Eq. (19), and differences of the flow."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
import sympy
from scipy.linalg import eigh

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.components import SlidingSeparation, StickSlip
from frictionlab.models import MassOnBelt, ModeCoupling, SliderOnBelt, TwoBlocks
from frictionlab.stability import eigenvalues, equilibrium, jacobian
from frictionlab.stability.state_matrices import is_neutral

pytestmark = pytest.mark.blas

# Claim C4: pairs of the coupled modes, with half a unit of the last printed digits.
PAPER = {
    0.3: [(-0.05 + 100j, 0.005 + 0.5j), (-0.04 + 89.4j, 0.005 + 0.05j)],
    1.4: [(-0.05 + 98.7j, 0.005 + 0.05j), (-0.048 + 93.7j, 0.0005 + 0.05j)],
    2.5: [(11.98 + 102.6j, 0.005 + 0.05j), (-12.08 + 102.6j, 0.005 + 0.05j)],
}
TOGGLES = [names for size in range(4) for names in combinations(("cubic", "nonsmooth", "geometry"), size)]


@pytest.mark.parametrize("mu_k", PAPER)
def test_claim_c4(mu_k):
    result = eigenvalues(SliderOnBelt(mu_k=mu_k))
    for value, digits in PAPER[mu_k]:
        off = result.values - value
        hit = (np.abs(off.real) <= digits.real) & (np.abs(off.imag) <= digits.imag)
        assert hit.sum() == 1
        assert np.conj(result.values[hit][0]) in result.values
    assert result.stable == (mu_k < 2)


def test_the_unstable_pair_at_mu_k_2_5():
    values = eigenvalues(SliderOnBelt(mu_k=2.5)).values
    fastest = values[np.argmax(values.real)]
    assert fastest.real == pytest.approx(11.98069, abs=5e-6)
    assert abs(fastest.imag) == pytest.approx(102.61479, abs=5e-6)


def test_order_frequencies_and_vectors():
    model = SliderOnBelt(mu_k=1.4)
    result = eigenvalues(model)
    assert result.values.shape == (10,)
    assert np.all(np.diff(np.abs(result.values.imag)) >= 0)
    np.testing.assert_array_equal(result.values[::2], np.conj(result.values[1::2]))
    np.testing.assert_allclose(result.frequencies, np.abs(result.values.imag) / (2 * np.pi))
    np.testing.assert_array_equal(result.growth_rates, result.values.real)
    matrix = jacobian(model, result.equilibrium.state)
    np.testing.assert_allclose(matrix @ result.vectors, result.vectors * result.values, atol=1e-9)


def printed_stiffness(model):
    """K of Eq. (19) as printed; its Pi, which the paper does not define, is F_N - A phi (x1 - x2)."""
    p, point = model.parameters, equilibrium(model)
    x1, _, x2, _, phi = point.q
    A, mu, sigma = p["k2"] + 3 * p["k_nl"] * point.penetration**2, p["mu_k"], x1 - x2
    Pi = point.normal_force - A * phi * sigma
    k1, k3, k4, k5, k6, l1, l2 = (p[name] for name in "k1 k3 k4 k5 k6 l1 l2".split())
    b = k5 * l1 - k6 * l2
    return np.array(
        [
            [k1 + k3 / 2 + A * mu * phi, -k3 / 2 + A * mu, -A * mu * phi, -A * mu, A * mu * sigma],
            [-k3 / 2 + A * phi, k3 / 2 + A, -A * phi, -A, A * sigma],
            [-A * mu * phi, -A * mu, k4 + A * mu * phi, A * mu, -A * mu * sigma],
            [-A * phi, -A, A * phi, A + k5 + k6, -A * sigma + b],
            [-Pi, A * sigma, Pi, -A * sigma + b, A * sigma**2 + k5 * l1**2 + k6 * l2**2],
        ]
    )


@pytest.mark.parametrize("mu_k", [0.0, 1.4, 2.9])
def test_equation_19(mu_k):
    model = SliderOnBelt(mu_k=mu_k, k_nl=1e6, M=2, m=3, J=0.3, l1=0.1, k6=2e4, c5=0.7)
    matrix = jacobian(model, equilibrium(model).state)
    mass = np.diag([2, 2, 3, 3, 0.3])
    stiffness = printed_stiffness(model)
    np.testing.assert_allclose(-mass @ matrix[5:, :5], stiffness, rtol=1e-12, atol=1e-9)
    p = model.parameters
    damping = np.diag([p["c1"], p["c2"], p["c4"], p["c5"] + p["c6"], p["c5"] * 0.1**2 + p["c6"] * 0.2**2])
    damping[3, 4] = damping[4, 3] = p["c5"] * 0.1 - p["c6"] * 0.2
    np.testing.assert_allclose(-mass @ matrix[5:, 5:], damping, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(matrix[:5], np.eye(5, 10, 5))


@pytest.mark.parametrize("names", TOGGLES)
def test_the_jacobian_is_the_flows_derivative(names):
    model = SliderOnBelt(mu_k=1.4, k_nl=1e7).without(*names)
    automaton = model.automaton()
    mode = next(m for m in automaton.modes if m.name in ("slip+", "slip"))
    flow = sympy.lambdify([automaton.states, list(automaton.parameters)], mode.flow, modules="numpy")
    n = automaton.coordinates
    state, values = np.concatenate([equilibrium(model).q, np.zeros(n)]), list(automaton.parameters.values())
    steps = 1e-30j * np.eye(2 * n)
    columns = [np.imag(np.array(flow(state + step, values), dtype=complex)) / 1e-30 for step in steps]
    np.testing.assert_allclose(jacobian(model, state), np.array(columns).T, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(flow(state, values), 0, atol=1e-9)


def test_non_smooth_behaviour_does_not_matter_for_stability():
    reference = eigenvalues(SliderOnBelt(mu_k=1.4)).values
    for interface in (StickSlip(), SlidingSeparation()):
        np.testing.assert_array_equal(
            eigenvalues(SliderOnBelt(mu_k=1.4, interface=interface)).values, reference
        )
    np.testing.assert_array_equal(eigenvalues(SliderOnBelt(mu_k=1.4).without("nonsmooth")).values, reference)


def test_the_belt_may_run_backwards():
    forwards = SliderOnBelt(mu_k=1.0)
    backwards = forwards.replace(v=-1.0)
    assert equilibrium(backwards).friction_force < 0
    smooth = backwards.without("nonsmooth")
    np.testing.assert_array_equal(eigenvalues(backwards).values, eigenvalues(smooth).values)


def test_no_sliding_without_a_running_belt():
    with pytest.raises(ValueError, match="v must not be 0"):
        eigenvalues(SliderOnBelt(v=0))


UNDAMPED = [
    TwoBlocks(),
    TwoBlocks(m1=1e-6, k2=1e6),
    TwoBlocks(k12=1e-9),
    MassOnBelt(),
    MassOnBelt(k=1e10),
    ModeCoupling(c=0.0, mu_k=0.2),
    ModeCoupling(c=0.0, mu_k=ModeCoupling().critical_friction),
    SliderOnBelt(c1=0, c2=0, c4=0, c5=0, c6=0),
]


@pytest.mark.parametrize("model", UNDAMPED, ids=repr)
def test_without_damping_nothing_grows_and_nothing_decays(model):
    found = eigenvalues(model)
    assert (found.growth_rates == 0.0).all()
    assert found.marginal
    assert not found.stable
    assert repr(found).startswith("Eigenvalues(marginal: 0/s at")


def test_two_blocks_have_the_frequencies_of_the_closed_form():
    found = eigenvalues(TwoBlocks(k12=1.2))
    assert found.values.imag == pytest.approx([-1, 1, -np.sqrt(3.4), np.sqrt(3.4)], rel=1e-14)


@pytest.mark.parametrize("c", [2e-12, 2e-6, 2e-3])
def test_little_damping_is_damping(c):
    """Rayleigh damping: every growth rate is -c/(2 m)."""
    for model in (TwoBlocks(c=c), MassOnBelt(c=c), ModeCoupling(c=c, mu_k=0.2)):
        found = eigenvalues(model)
        assert found.growth_rates == pytest.approx(-c / 2, rel=1e-6, abs=1e-15)
        assert found.stable
        assert not found.marginal


def test_what_barely_flutters_is_unstable():
    """Beyond mu_c the growth rate is the root of what is left: 1e-10 beyond it is 2e-6 1/s."""
    model = ModeCoupling(c=0.0)
    k11, k12, k22 = model.stiffnesses
    for beyond in (1e-10, 1e-6, 0.1):
        mu_k = model.critical_friction + beyond
        found = eigenvalues(model.replace(mu_k=mu_k))
        root = np.sqrt(beyond * k12 * model.k3)  # of omega^2 = (k11 + k22)/2 +- i root
        exact = np.sqrt(-(k11 + k22) / 2 + 1j * root).real
        assert found.growth_rates.max() == pytest.approx(exact, rel=1e-4)
        assert not found.stable
        assert not found.marginal


def test_critical_damping_is_stable_though_its_eigenvalue_has_no_condition_number():
    for c in (2.0, 2.0 + 1e-12):
        found = eigenvalues(MassOnBelt(c=c))
        assert found.growth_rates == pytest.approx(-1.0, abs=1e-5)
        assert found.stable


def test_zero_is_told_beside_other_eigenvalues_of_its_frequency():
    """A Jordan block at 0 and one at -5, a pair at rest and one that decays, turned at random."""
    turned = np.linalg.qr(np.random.default_rng(0).normal(size=(8, 8)))[0]
    block = np.zeros((8, 8))
    block[:2, :2] = [[0, 1], [0, 0]]
    block[2:4, 2:4] = [[-5, 1], [0, -5]]
    block[4:6, 4:6] = [[0, 2], [-2, 0]]
    block[6:, 6:] = [[-1e-6, 2], [-2, -1e-6]]
    matrix = turned @ block @ turned.T
    values = np.linalg.eigvals(matrix).astype(complex)
    zero = np.abs(values.real) < 5e-7  # the double zero is known to the root of rounding
    assert zero.sum() == 4
    np.testing.assert_array_equal(is_neutral(matrix, values), zero)


def test_shares_of_three_free_masses():
    """Those of kinetic energy, beside the rigid motion's double eigenvalue 0."""
    x, v, masses = sympy.symbols("x:3"), sympy.symbols("v:3"), np.array([1.0, 5.0, 2.0])
    springs = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    flow = (*v, *(sympy.Matrix(-springs / masses[:, None]) * sympy.Matrix(x)))
    found = eigenvalues(HybridAutomaton((*x, *v), (Mode("only", flow),), {}, 3))
    expected = masses[:, None] * eigh(springs, np.diag(masses))[1] ** 2
    np.testing.assert_allclose(found.participation[:, ::2], expected, atol=1e-13)
