"""Equilibria of many states of which few enter nonlinearly."""

import numpy as np
import pytest
import sympy

from frictionlab.stability.equilibrium_points.newton import (
    find_zeros,
    low_rank_newton,
    merge_candidates,
    newton_step,
)
from frictionlab.stability.flow import Flow
from frictionlab.tape.formulas import formulas_of
from tests.helpers.cases import slow_but

MASSES = 24


def flow_of(states, rates):
    """x' = rates, without parameters and margins."""
    return Flow((), formulas_of(states, rates), formulas_of(states, ()))


def chain_with_end_spring(force, k=1.0, kc=50.0, last_rate=None):
    """Masses in a row, each on a spring to the ground; `force` acts at the last of them.

    `last_rate` takes the place of that mass's acceleration, as a function of the first displacement.
    """
    x, v = sympy.symbols(f"x:{MASSES}"), sympy.symbols(f"v:{MASSES}")
    forces = []
    for i in range(MASSES):
        neighbours = [x[j] for j in (i - 1, i + 1) if 0 <= j < MASSES]
        forces.append(-k * x[i] - 0.1 * v[i] + sum(kc * (other - x[i]) for other in neighbours))
    forces[-1] += force(x[-1])
    if last_rate is not None:
        forces[-1] = last_rate(x[0])
    return flow_of((*x, *v), (*v, *forces))


def linear_stiffness(k=1.0, kc=50.0):
    matrix = np.diag(np.full(MASSES, k))
    for i in range(MASSES - 1):
        matrix[i : i + 2, i : i + 2] += kc * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return matrix


def test_a_step_is_that_of_the_whole_matrix():
    flow = chain_with_end_spring(lambda u: 30 * u - 4 * u**3 + sympy.tanh(u))
    x = np.random.default_rng(1).normal(size=(2 * MASSES, 50))
    cheap = low_rank_newton(flow, (), x)
    np.testing.assert_allclose(cheap.step(x), newton_step(flow, x, ()), rtol=1e-9, atol=1e-9)


def test_a_step_where_the_flow_is_undefined_is_nan_there_alone():
    flow = chain_with_end_spring(lambda u: sympy.log(u + 2))
    x = np.random.default_rng(1).normal(size=(2 * MASSES, 5)) * 0.1
    x[MASSES - 1, 3] = -3.0
    step = low_rank_newton(flow, (), x).step(x)
    assert np.isnan(step[:, 3]).all()
    assert np.isfinite(np.delete(step, 3, axis=1)).all()


@pytest.mark.parametrize("pull", slow_but([30.0], [5.0, 30.0, 200.0]))
def test_all_zeros_are_those_of_the_condensed_polynomial(pull):
    """The linear masses condensed, the last displacement u is a root of u / c = pull u - 4 u^3."""
    flow = chain_with_end_spring(lambda u: pull * u - 4 * u**3)
    compliance = np.linalg.inv(linear_stiffness())[-1, -1]
    roots = np.roots([-4.0, 0.0, pull - 1 / compliance, 0.0])
    expected = np.sort(roots.real[np.abs(roots.imag) < 1e-9])
    found = find_zeros(flow, ()).points
    np.testing.assert_allclose(np.sort(found[MASSES - 1]), expected, rtol=1e-11, atol=1e-11)
    shapes = np.linalg.inv(linear_stiffness())[:, -1:] / compliance * found[MASSES - 1]
    np.testing.assert_allclose(found[:MASSES], shapes, rtol=1e-9, atol=1e-12)
    assert not found[MASSES:].any()


def test_a_gaussian_well():
    """A law that is no polynomial: the root of the condensed equation, by bisection."""
    flow = chain_with_end_spring(lambda u: 400 * sympy.exp(-((u - 3) ** 2)))
    compliance = np.linalg.inv(linear_stiffness())[-1, -1]
    grid = np.linspace(-1, 30, 400001)
    rest = 400 * np.exp(-((grid - 3) ** 2)) - grid / compliance
    expected = grid[:-1][np.diff(np.sign(rest)) != 0]
    np.testing.assert_allclose(np.sort(find_zeros(flow, ()).points[MASSES - 1]), expected, atol=2e-4)


def test_small_and_very_nonlinear_systems_keep_whole_matrices():
    x = sympy.symbols("x:40")
    every = flow_of(x, [one - one**3 for one in x])
    few = flow_of(x[:4], [one - one**3 for one in x[:4]])
    assert low_rank_newton(every, (), np.zeros((40, 1))) is None
    assert low_rank_newton(few, (), np.zeros((4, 1))) is None


def test_a_singular_point_is_no_reference():
    singular = np.zeros((2 * MASSES, 3))
    free = chain_with_end_spring(lambda u: u**3, last_rate=lambda u: u**3)
    assert low_rank_newton(free, (), singular) is None


def test_candidates_that_agree_are_one():
    x = np.array([[1.0, 1.0 + 1e-12, 2.0, 1.0], [3.0, 3.0, 3.0, 3.1]])
    np.testing.assert_array_equal(merge_candidates(x), x[:, [0, 2, 3]])
