"""Numbers of tapes as functions of parameters, without C's library."""

import math

import numpy as np
import pytest
import sympy as sp

from frictionlab.hybrid.elementary import exponentials
from frictionlab.hybrid.elementary.parameter_functions import KERNELS, integer_power, real_power
from frictionlab.hybrid.expression_functions import function_of_parameters

A, B = sp.symbols("a b", positive=True)


@pytest.mark.parametrize("x", [1.7, -0.3])
@pytest.mark.parametrize("n", range(-7, 12))
def test_an_integer_power_is_one_of_products(x, n):
    assert integer_power(x, n) == real_power(x, float(n)) == pytest.approx(x**n, rel=1e-15)


def test_expressions_have_the_values_of_the_elementary_functions():
    exprs = [
        sp.sqrt(A),
        1 / sp.sqrt(A),
        A**2,
        A**-3,
        A**B,
        A ** sp.Rational(3, 2),
        sp.exp(-A),
        sp.E**B,
        A / B,
    ]
    found = function_of_parameters([A, B], exprs)(2.3, 1.7)
    assert found[0] == math.sqrt(2.3)
    assert found[1] == 1 / math.sqrt(2.3)
    assert found[2] == 2.3 * 2.3
    assert found[3] == 1 / (2.3 * (2.3 * 2.3))
    assert found[4] == exponentials.power(2.3, 1.7)
    assert found[5] == exponentials.power(2.3, 1.5)
    assert found[6] == exponentials.exp(-2.3)
    assert found[7] == exponentials.exp(1.7)
    np.testing.assert_allclose(found, [float(e.subs({A: 2.3, B: 1.7})) for e in exprs], rtol=1e-15)


@pytest.mark.parametrize("function", KERNELS, ids=lambda f: f.__name__)
def test_every_function_is_taken_from_here(function):
    x = 1.25 if function.__name__ == "acosh" else 0.37
    expr = getattr(sp, function.__name__)(A)
    assert function_of_parameters([A], expr)(x) == function(x)
    assert function_of_parameters([A], [expr, A])(x) == [function(x), x]


@pytest.mark.parametrize("expr", [sp.sqrt(A - 3), sp.log(A - 1), (A - 2) ** B, 1 / (A - 1), sp.exp(1000 * A)])
def test_what_has_no_finite_real_value_raises(expr):
    with pytest.raises((ArithmeticError, ValueError)):
        function_of_parameters([A, B], expr)(1.0, 0.5)
