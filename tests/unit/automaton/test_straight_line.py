"""Functions of sympy as data: the same bits, and nothing else than arithmetic."""

import json
import math

import numpy as np
import pytest
import sympy as sp

from frictionlab.automaton.straight_line import MATH, StraightLine, straight_line_data
from frictionlab.hybrid.elementary.parameter_functions import OF_ARRAYS, OF_OUTPUTS, OF_PARAMETERS
from frictionlab.hybrid.expression_functions import array_function, function_of_parameters, numpy_function

pytestmark = pytest.mark.plain_python
A, B, RATE = sp.Symbol("a", real=True), sp.Symbol("b", real=True), sp.Symbol("x1'", real=True)
EXPRESSIONS = [
    sp.Rational(1, 3) * A - 2 * B,
    sp.sqrt(A) / (A + B) ** 3,
    A**1.5 + sp.exp(-B) * sp.tanh(RATE),
    -A * sp.sin(B + sp.pi) + 7,
    sp.sign(RATE) * sp.Abs(A - B),
]
VALUES = 0.7, 2.3, -1.1


def read_again(function, functions):
    """By way of JSON."""
    return StraightLine(json.loads(json.dumps(straight_line_data(function, functions))), functions)


@pytest.mark.parametrize("values", [VALUES, (3.0, 1e-9, 0.0), (1e90, 4.0, 5.0)], ids=str)
def test_numbers_have_the_same_bits(values):
    function = function_of_parameters([A, B, RATE], EXPRESSIONS)
    assert read_again(function, OF_PARAMETERS)(*values) == function(*values)


@pytest.mark.parametrize(("make", "names"), [(numpy_function, OF_ARRAYS), (array_function, OF_OUTPUTS)])
def test_arrays_have_the_same_bits(make, names):
    function = make([A, B, RATE], [EXPRESSIONS[:2], EXPRESSIONS[2:]])
    arrays = np.random.default_rng(0).uniform(0.1, 3.0, (3, 50))
    found, expected = read_again(function, names)(*arrays), function(*arrays)
    assert [len(row) for row in found] == [2, 3]
    assert all((a == b).all() for row, other in zip(found, expected) for a, b in zip(row, other))


def test_one_expression_gives_one_value():
    assert read_again(numpy_function([A], 2 * A), OF_ARRAYS)(1.5) == 3.0
    assert read_again(numpy_function([A], sp.Integer(4)), OF_ARRAYS)(1.5) == 4


def test_what_raises_raises_still():
    function = read_again(function_of_parameters([A, B], [1 / A, sp.log(B)]), OF_PARAMETERS)
    with pytest.raises(ArithmeticError):
        function(0.0, 1.0)
    with pytest.raises((ArithmeticError, ValueError)):
        function(1.0, -1.0)
    with pytest.raises(TypeError, match="2 arguments are needed, got 1"):
        function(1.0)


def test_branches_and_unknown_calls_are_no_straight_lines():
    clipped = sp.Piecewise((A, A > 0), (0, True))
    assert straight_line_data(sp.lambdify([A], clipped, "math"), MATH) is None
    assert straight_line_data(sp.lambdify([A], sp.gamma(A), "math"), {"sqrt": math.sqrt}) is None
    assert straight_line_data(lambda a: a, MATH) is None
    assert straight_line_data(sp.lambdify([A], sp.Max(A, 1), "numpy"), OF_ARRAYS) is None
