"""Balanced matrices, and growth rates that are zero but for rounding."""

import numpy as np
import pytest
from scipy.linalg import matrix_balance

from frictionlab.stability.equilibrium_problem import balanced, is_neutral

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
