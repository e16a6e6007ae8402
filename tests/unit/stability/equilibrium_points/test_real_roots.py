"""Roots between two points, and those of polynomials."""

import numpy as np
import pytest
from scipy.optimize import brentq

from frictionlab.stability.equilibrium_points.real_roots import (
    MAX_ROOT_STEPS,
    ROOT_RTOL,
    ROOT_XTOL,
    bracketed_root,
    real_roots,
)

HARD = {
    "flat": lambda x: x**9,
    "triple": lambda x: (x - 1.0) ** 3,
    "step": lambda x: np.sign(x - 0.3),
    "saturated": lambda x: np.tanh(1e3 * (x - 1e-7)),
    "pole": lambda x: 1.0 / (x - 0.1234),
}


def by_scipy(function, low, high):
    return brentq(function, low, high, xtol=ROOT_XTOL, rtol=np.float64(ROOT_RTOL), maxiter=MAX_ROOT_STEPS)


@pytest.mark.parametrize("name", HARD)
def test_hard_roots_are_those_of_scipy_to_the_last_bit(name):
    with np.errstate(divide="ignore"):
        assert bracketed_root(HARD[name], -1.0, 2.5) == by_scipy(HARD[name], -1.0, 2.5)


def test_roots_of_polynomials_of_all_sizes_are_those_of_scipy_to_the_last_bit():
    random, compared = np.random.default_rng(1), 0
    for _ in range(600):
        degree = random.integers(1, 9)
        coefficients = random.normal(size=degree + 1) * 10.0 ** random.uniform(-6, 6, size=degree + 1)
        low, high = np.sort(random.normal(size=2) * 10.0 ** random.uniform(-5, 5))

        def value(x, coefficients=coefficients):
            return float(np.polyval(coefficients, x))

        if value(low) * value(high) < 0:
            compared += 1
            assert bracketed_root(value, low, high) == by_scipy(value, low, high)
    assert compared > 80


def test_where_there_is_no_change_of_sign_there_is_no_root():
    assert bracketed_root(lambda x: x * x + 1.0, -1.0, 2.0) is None
    assert bracketed_root(lambda x: x, 0.0, 2.0) == 0.0


def test_roots_of_a_product_are_its_factors():
    wanted = [-3.0, 0.5, 2.0, 7.0]
    np.testing.assert_allclose(real_roots(np.poly(wanted)[::-1]), wanted, rtol=1e-13)
