"""Newton's steps where Jacobians are singular."""

import numpy as np
import pytest

from frictionlab.stability.equilibrium_points.newton import solve_matrices


@pytest.mark.parametrize("count", [1, 2, 7, 64])
def test_each_matrix_is_solved_as_it_is_alone(count):
    """Regular, singular and not finite ones among each other."""
    draw = np.random.default_rng(count)
    matrices, right = draw.normal(size=(count, 4, 4)), draw.normal(size=(count, 4, 2))
    singular, unknown = np.arange(count) % 3 == 0, np.arange(count) % 5 == 1
    matrices[singular, 2] = matrices[singular, 0] = 0.0
    matrices[unknown & ~singular] = np.nan
    found = solve_matrices(matrices, right)
    for i, (matrix, side) in enumerate(zip(matrices, right, strict=True)):
        if singular[i]:
            least = np.linalg.lstsq(matrix, side)[0]
            np.testing.assert_allclose(found[i], least, rtol=1e-12, atol=1e-12)
        else:
            np.testing.assert_array_equal(found[i], np.linalg.solve(matrix, side))
    assert np.isnan(found).any() == (unknown & ~singular).any()


def test_where_determinants_do_not_tell_each_matrix_is_solved_alone(monkeypatch):
    """As with a LAPACK that takes other factors for the determinants."""
    matrices, right = np.stack([np.diag([1.0, 0.0]), np.diag([2.0, 4.0])]), np.ones((2, 2, 1))
    slogdet = np.linalg.slogdet
    monkeypatch.setattr(np.linalg, "slogdet", lambda a: slogdet(a)._replace(sign=np.ones(len(a))))
    np.testing.assert_allclose(solve_matrices(matrices, right)[..., 0], [[1.0, 0.0], [0.5, 0.25]], rtol=1e-15)
