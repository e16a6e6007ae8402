"""Balanced matrices, and growth rates that are zero but for rounding."""

import mpmath
import numpy as np
import pytest
from scipy.linalg import matrix_balance

from frictionlab.stability.state_matrices import (
    balanced,
    eigenpairs_of_matrices,
    eigenvalue_order,
    eigenvalues_of_matrices,
    growth_rates,
    is_neutral,
)

pytestmark = pytest.mark.blas

MANTISSA_OF_POWERS_OF_TWO = 0.5  # the mantissa that frexp gives


def matrices():
    random = np.random.default_rng(7)
    for size in (1, 2, 3, 6, 10, 14):
        sizes = 10.0 ** random.uniform(-6, 6, size=(size, size))
        yield random.normal(size=(size, size)) * sizes * (random.random((size, size)) < 0.7)


@pytest.mark.parametrize("matrix", [*matrices()], ids=len)
def test_balancing_is_a_similarity_by_powers_of_two_and_as_good_as_lapacks(matrix):
    found = balanced(matrix)
    assert ((found == 0) == (matrix == 0)).all()
    rows, columns = np.nonzero(matrix)
    mantissas = np.frexp(found[rows, columns] / matrix[rows, columns])[0]
    assert (mantissas == MANTISSA_OF_POWERS_OF_TWO).all()
    assert (np.diag(found) == np.diag(matrix)).all()
    # scipy's stubs do not say that the first of its results is a matrix
    of_lapack: np.ndarray = matrix_balance(matrix, permute=False)[0]  # pyright: ignore[reportAssignmentType]
    assert np.linalg.norm(found) <= 1.5 * np.linalg.norm(of_lapack)


@pytest.mark.parametrize(("damping", "neutral"), [(0.0, True), (1e-17, True), (1e-9, False), (2.0, False)])
def test_an_oscillator_is_neutral_where_its_damping_is_rounding(damping, neutral):
    """Critically damped (2.0) it has one eigenvector, and its eigenvalues are ill-conditioned but stable."""
    matrix = np.array([[0.0, 1.0], [-1.0, -damping]])
    values = np.linalg.eigvals(matrix).astype(complex)
    assert is_neutral(matrix, values).tolist() == [neutral, neutral]


def test_scaled_units_change_no_verdict():
    matrix = np.array([[0.0, 1.0], [-1e12, -1e-12]])
    assert is_neutral(matrix, np.linalg.eigvals(matrix).astype(complex)).all()
    damped = matrix - 1e-3 * np.eye(2)
    assert not is_neutral(damped, np.linalg.eigvals(damped).astype(complex)).any()


@pytest.mark.parametrize("fast", [1e6, 1e9, 1e12])
def test_slow_eigenvalues_have_the_digits_of_mpmath(fast):
    """An oscillator that hardly grows, beside a state that relaxes fast, in units that mix them."""
    units = np.array([1.0, 1e3, 1e-4])
    matrix = np.array([[0.0, 1.0, 0.1], [-1.0, 1e-8, 0.2], [0.3 * fast, 0.7 * fast, -fast]])
    matrix = matrix * units / units[:, None]
    with mpmath.workdps(60):
        exact = [complex(value) for value in mpmath.eig(mpmath.matrix(matrix), left=False, right=False)]
    exact = np.array(sorted(exact, key=lambda value: (abs(value), value.imag)), dtype=complex)
    pairs = eigenpairs_of_matrices(matrix[None])
    for values in (eigenvalues_of_matrices(matrix[None])[0], pairs[0][0]):
        known = values[np.lexsort((values.imag, np.abs(values).round(6)))]
        np.testing.assert_allclose(np.real(known[:2]), np.real(exact[:2]), rtol=1e-6)
        np.testing.assert_allclose(known, exact, rtol=1e-13)
        assert (np.sign(growth_rates(known)) == np.sign(np.real(exact))).all()
    slow = np.abs(pairs[0][0]) < 1e-3 * fast
    scale = np.abs(matrix) @ np.abs(pairs[1][0][:, slow])
    left_over = matrix @ pairs[1][0][:, slow] - pairs[1][0][:, slow] * pairs[0][0][slow]
    assert (np.abs(left_over) <= 1e-14 * scale).all()


def test_rounding_of_a_free_body_is_no_slow_mode():
    """A mass that nothing holds, beside a spring: its eigenvalue is zero, and no mode grows."""
    matrix = np.array([[0.0, 0, 1, 0], [0, 0, 0, 1], [-1e12, 1e12, -1e5, 1e5], [1e12, -1e12, 1e5, -1e5]])
    matrix[2:, 2:] -= 1e-3 * np.eye(2)
    values = eigenvalues_of_matrices(matrix[None])
    assert not (growth_rates(values) > 0).any()
    (pairs,), (vectors,) = eigenpairs_of_matrices(matrix[None])
    np.testing.assert_allclose(np.sort(values[0].real)[2:], [-1e-3, 0.0], rtol=1e-5)
    scale = (np.abs(matrix) @ np.abs(vectors)).max(axis=0)
    assert (np.abs(matrix @ vectors - vectors * pairs) <= 1e-14 * scale).all()


def test_bodies_that_nothing_holds_have_eigenvalues_of_zero():
    """Two pairs of masses that nothing holds: one is damped, the other has a defective eigenvalue of zero."""
    stiffness = 1e12 * np.kron(np.eye(2), [[-1.0, 1.0], [1.0, -1.0]])
    damping = np.diag([0.0, 0.0, -1e-2, -1e-2])
    matrix = np.block([[np.zeros((4, 4)), np.eye(4)], [stiffness, 1e-7 * stiffness + damping]])
    values = eigenvalues_of_matrices(matrix[None])[0]
    assert np.count_nonzero(values == 0.0) == 3
    np.testing.assert_allclose(np.sort(values.real)[4:5], -1e-2, rtol=1e-5)
    assert np.abs(np.sort(values.real)[5:]).max() == 0.0


@pytest.mark.parametrize(
    "values", [[2j, -2j, 2j, -2j], [-1 - 2j, 2j, -1 + 2j, -2j, -1 - 2j, -1 + 2j], [1, 0, -3]]
)
def test_the_two_of_a_pair_are_neighbours(values):
    values = np.array(values, dtype=complex)
    random = np.random.default_rng(0)
    for shuffled in (random.permutation(values) for _ in range(20)):
        ordered = shuffled[eigenvalue_order(shuffled)]
        of_pairs = ordered[ordered.imag != 0.0]
        assert (of_pairs[::2] == of_pairs[1::2].conj()).all()
        assert (np.diff(ordered.real[ordered.imag >= 0.0]) >= 0.0).all()


@pytest.mark.parametrize("k", [-2.5e-10, 2.5e-10, 2.5e-9])
def test_a_slow_eigenvalue_that_rounding_makes_zero_is_found(k):
    """A light mass that creeps at -k/c beside one that vibrates: LAPACK gives zero for two of these."""
    matrix = np.zeros((1, 4, 4))
    matrix[0, :2, 2:] = np.eye(2)
    matrix[0, 2:, :2] = np.diag([-k / 2.7e-8, -6.9e-5])
    matrix[0, 2:, 2:] = np.diag([-0.42 / 2.7e-8, -1.3e-5])
    values = eigenvalues_of_matrices(matrix)[0]
    assert np.abs(values - -k / 0.42).min() < 1e-9 * abs(k / 0.42)
