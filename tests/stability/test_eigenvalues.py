"""Eigenvalues: the paper's numbers, its matrix of Eq. (19), and differences of the flow."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
import sympy

from frictionlab.components import SlidingSeparation, StickSlip
from frictionlab.models import SliderOnBelt
from frictionlab.stability import eigenvalues, equilibrium, jacobian

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
    matrix = jacobian(model, result.equilibrium.q)
    np.testing.assert_allclose(matrix @ result.vectors, result.vectors * result.values, atol=1e-9)


def printed_stiffness(model):
    """K of Eq. (19) as printed; its Pi, which the paper does not define, is F_N - A phi (x1 - x2)."""
    p, point = model.parameters, equilibrium(model)
    x1, _, x2, _, phi = point.q
    A, mu, sigma = p["k2"] + 3 * p["k_nl"] * point.gap**2, p["mu_k"], x1 - x2
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
    matrix = jacobian(model, equilibrium(model).q)
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
    np.testing.assert_allclose(jacobian(model, state[:n]), np.array(columns).T, rtol=1e-12, atol=1e-9)
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
