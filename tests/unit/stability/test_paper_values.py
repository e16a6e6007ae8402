"""The paper's critical friction coefficients and Fig. 6, and what holds for every state matrix."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import frictionlab as fl
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem

S = fl.SliderOnBelt
CRITICAL = [
    (S(k_nl=0.0), 1.51752661, 1e-8),
    (S(), 1.51378354, 1e-8),
    (S(k_nl=1e7), 0.58293736, 1e-8),
    (S().without("geometry"), 1.97391014, 1e-8),
    (S(F=800, k_nl=1e7, k4=5e6, k5=5e6, k6=5e6), 1.735143, 1e-6),
]


@pytest.mark.parametrize(("model", "value", "digits"), CRITICAL)
def test_critical_friction(model, value, digits):
    assert fl.critical_value(model, "mu_k", bounds=(0, 4)) == pytest.approx(value, abs=0.51 * digits)


def test_the_root_against_thirty_digits():
    """Eq. (18) and Eq. (19) again, in mpmath: the real part vanishes at the critical value to 1e-12 of it."""
    model = S()
    value = fl.critical_value(model, "mu_k", bounds=(0, 4))
    below, above = (_growth(mu) for mu in (value * (1 - 1e-12), value * (1 + 1e-12)))
    assert below < 0 < above


def _growth(mu):
    """Largest growth rate at Table 1, with K of Eq. (19) as printed and Pi = F_N - A phi (x1 - x2)."""
    F, l = 200, 0.2
    k1, k2, k3, k4, k5, k_nl = 10**4, 5000, 6000, 10**4, 10**4, 10**4
    with mpmath.workdps(30):
        mu = mpmath.mpf(mu)

        def rest(gap):
            N = k2 * gap + k_nl * gap**3
            x1 = (mu * N + N - F) / k1
            y1, x2, y2 = x1 + 2 * (N - F) / mpmath.mpf(k3), -mu * N / k4, -N / (2 * k5)
            return x1, y1, x2, y2, N * (x1 - x2) / (2 * k5 * l**2), N

        def excess(gap):
            x1, y1, x2, y2, phi, _ = rest(gap)
            return y2 - (x1 - x2) * phi - y1 - gap

        gap = mpmath.findroot(excess, 0.024)
        x1, _, x2, _, phi, N = rest(gap)
        A, s = k2 + 3 * k_nl * gap**2, x1 - x2
        Pi = N - A * phi * s
        half = mpmath.mpf(k3) / 2
        K = [
            [k1 + half + A * mu * phi, -half + A * mu, -A * mu * phi, -A * mu, A * mu * s],
            [-half + A * phi, half + A, -A * phi, -A, A * s],
            [-A * mu * phi, -A * mu, k4 + A * mu * phi, A * mu, -A * mu * s],
            [-A * phi, -A, A * phi, A + 2 * k5, -A * s],
            [-Pi, A * s, Pi, -A * s, A * s**2 + 2 * k5 * l**2],
        ]
        c = mpmath.mpf(1) / 10
        damping, mass = [c, c, c, 2 * c, 2 * c * l**2], [1, 1, 1, 1, c]
        matrix = mpmath.zeros(10)
        for i in range(5):
            matrix[i, 5 + i] = 1
            matrix[5 + i, 5 + i] = -damping[i] / mass[i]
            for j in range(5):
                matrix[5 + i, j] = -K[i][j] / mass[i]
        values, _ = mpmath.eig(matrix)
        return max(mpmath.re(v) for v in values)


@pytest.mark.parametrize("model", [S(), S().without("geometry"), S(F=1000, l1=0.1, c5=2.0, M=3.0, J=0.4)])
def test_trace_and_determinant(model):
    view = equilibrium_problem(model)
    values = np.linspace(0, 3, 41)
    _, matrices = view.linearised({"mu_k": values})
    spectra = view.spectra({"mu_k": values})
    p = model.parameters
    trace = p["c1"] / p["M"] + p["c2"] / p["M"] + p["c4"] / p["m"] + (p["c5"] + p["c6"]) / p["m"]
    if "phi" in model.coordinates:
        trace += (p["c5"] * p["l1"] ** 2 + p["c6"] * p["l2"] ** 2) / p["J"]
    np.testing.assert_allclose(np.trace(matrices, axis1=1, axis2=2), -trace, rtol=1e-13)
    np.testing.assert_allclose(spectra.sum(axis=1), -trace, rtol=1e-9)
    n = len(model.coordinates)
    # For x'' + C x' + K x = 0 in first order the determinant is that of M^-1 K.
    stiffness = np.linalg.det(-matrices[:, n:, :n])
    np.testing.assert_allclose(np.linalg.det(matrices), stiffness, rtol=1e-10)
    np.testing.assert_allclose(np.prod(spectra, axis=1), stiffness, rtol=1e-10)


@pytest.mark.slow
def test_ten_thousand_are_those_of_single_models():
    values = np.linspace(0, 3, 10_000)
    locus = fl.root_locus(S(F=1000), "mu_k", values)
    for i in range(0, 10_000, 1111):
        single = fl.eigenvalues(S(F=1000, mu_k=values[i])).values
        np.testing.assert_allclose(
            np.sort_complex(locus.values[i]), np.sort_complex(single[single.imag > 0]), rtol=1e-10
        )
    # Continuous, with steps of 3e-4: where two modes coalesce the eigenvalues go like a square root.
    assert np.abs(np.diff(locus.values, axis=0)).max() < 1.0


def test_participation_is_the_share_of_kinetic_energy():
    model = S(mu_k=0.0, c1=0, c2=0, c4=0, c5=0, c6=0, M=2.0, J=0.3).without("geometry")
    locus = fl.root_locus(model, "k4", [1e4])
    masses = np.array([2.0, 2.0, 1.0, 1.0])
    energy = masses[:, None] * np.abs(locus.shapes[0]) ** 2
    np.testing.assert_allclose(locus.participation[0], energy / energy.sum(axis=0), atol=1e-10)
