"""Newton's steps: singular Jacobians, and many states of which few enter nonlinearly."""

import numpy as np
import pytest
import sympy

from frictionlab.stability.equilibrium_points.newton import (
    find_zeros,
    follow_zero,
    low_rank_newton,
    merge_candidates,
    newton_step,
    solve_matrices,
)
from frictionlab.stability.flow import Flow
from frictionlab.tape.formulas import formulas_of
from tests.helpers.cases import slow_but


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


X, Y, Z, P = sympy.symbols("x y z p")


@pytest.mark.parametrize("mixed", [0, 1])
@pytest.mark.parametrize("unit", [1e-6, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize(
    ("x", "force", "last"),
    [
        (-1.0, X**3 - X, 2 / 27**0.5),
        (-1.0, sympy.Piecewise((X, X < 0), (10 * X, True)), np.inf),
        (0.0, X, np.inf),
    ],
    ids=["fold", "corner", "line"],
)
def test_a_zero_is_followed_alike_in_all_units(x, force, last, unit, mixed):
    """x with force(x) = p from p = force(x), beside z = p in any unit, or as x + z in one coordinate; and
    y + y^3 = x^2, moved by x alone."""
    one, other = X - mixed * Z / unit, Y / unit
    rates = [P - force.subs(X, one), unit * (one**2 - other - other**3), unit * P - Z]
    flow = Flow(("p",), formulas_of((X, Y, Z, P), rates), formulas_of((X, Y, Z, P), ()))
    p, y = float(force.subs(X, x)), max(np.roots([1, 0, 1, -(x**2)]), key=np.real).real
    at = np.array([0.38, 0.39, 0.7, 0.8, 1.0, 3.0])
    start = np.array([x + mixed * p, unit * y, unit * p])
    zeros = follow_zero(flow, start, (p,), lambda *_: np.True_, (at,), len(at))
    assert np.isfinite(zeros).all(axis=0).tolist() == (at < last).tolist()
    left = flow.rhs(zeros, (at,))[:, at < last]
    np.testing.assert_allclose(left / [[1.0], [unit], [unit]], 0.0, atol=1e-9)


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


@pytest.mark.parametrize(("a", "w"), [(0.5, 2.0), (0.5, 3.0), (1.0, 1.0)])
def test_a_zero_is_lost_at_a_fold_also_where_another_state_follows(a, w):
    """p = x + a sin(w x + 1) + sin(y)/2 with y = x^2 folds where dp/dx = 0; others lie beyond."""
    x = np.linspace(-4.0, 4.0, 80001)
    p = x + a * np.sin(w * x + 1) + np.sin(x**2) / 2
    at, turns, middle = np.linspace(-3, 3, 61) + a * np.sin(1), np.diff(p) < 0, len(x) // 2
    high = p[middle + turns[middle:].argmax()]
    low = p[middle - turns[middle::-1].argmax() + 1]
    rates = [P - X - a * sympy.sin(w * X + 1) - sympy.sin(Y) / 2, X**2 - Y]
    flow = Flow(("p",), formulas_of((X, Y, P), rates), formulas_of((X, Y, P), ()))
    zeros = follow_zero(flow, np.zeros(2), (a * np.sin(1),), lambda *_: np.True_, (at,), len(at))
    exists = (low < at) & (at < high)
    np.testing.assert_array_equal(np.isfinite(zeros).all(axis=0), exists)
    np.testing.assert_allclose(np.interp(zeros[0, exists], x, p), at[exists], atol=1e-7)
