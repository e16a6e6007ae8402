"""Formulas against sympy and mpmath: values, Jacobians, derivatives along directions, intervals, data."""

import json
import math

import numpy as np
import pytest
import sympy as sp

from frictionlab.tape.elementary import exponentials
from frictionlab.tape.formulas import (
    ELEMENTARY,
    Formulas,
    formulas_from_data,
    formulas_of,
    integer_power,
    real_power,
)
from frictionlab.tape.intervals import Interval, interval
from frictionlab.tape.tape import TapeError
from tests.helpers.cases import slow_but

X, Y, P, Q = SYMBOLS = sp.symbols("x y p q", real=True)
EXPRESSIONS = (
    sp.sin(X * Y) + P * X**3 - sp.exp(-P * X**2) / Q,
    sp.tanh(X / Q) * sp.sqrt(1 + Y**2),
    sp.Abs(X - Y) ** P,
    sp.Max(X, Y, P * Q) - sp.Min(X, P),
    sp.Piecewise((X**2, X < Y), (P * Y, X < 2), (X, True)),
    sp.atan2(X, Y) + sp.asinh(X) + sp.acos(Y / 10) + sp.log(P),
    sp.acosh(2 + Y) + sp.atanh(X / 9) + sp.asin(X / 8) + sp.atan(X * Y),
    3 * X - 3 * X + 2 * (X + Y) - sp.Rational(1, 3),
    (X + Y) ** -2 * X / (1 + P),
    sp.cosh(X) * sp.tan(Y) + sp.sinh(P) - sp.cos(Q) ** 2,
    sp.sqrt(2) * sp.pi * X**1.5 + X**2.0,
    sp.sign(X - Y) * Y,
    1 / sp.cosh(P * X) ** 2 + sp.tanh(X) ** 2,
)
POINTS = (1.3, 0.7, 1.7, 0.3), (0.4, 0.9, 2.2, -0.6), (2.5, 1.25, 0.3, 4.0)


def exact(expression, at):
    numbers = {s: sp.Float(v, 40) for s, v in zip(SYMBOLS, at, strict=True)}
    return float(expression.subs(numbers).doit().evalf(30))


@pytest.mark.parametrize("at", POINTS, ids=str)
def test_values_are_those_of_the_expressions(at):
    made = formulas_of(SYMBOLS, EXPRESSIONS)
    expected = [exact(e, at) for e in EXPRESSIONS]
    np.testing.assert_allclose(made.numbers(*at), expected, rtol=1e-14)
    np.testing.assert_allclose(made.arrays(*at), expected, rtol=1e-14)
    np.testing.assert_allclose(made.along_run(*at), expected, rtol=1e-14)
    wide = made.arrays(*(np.full(3, v) for v in at))
    np.testing.assert_allclose([v * np.ones(3) for v in wide], np.outer(expected, np.ones(3)), rtol=1e-14)


@pytest.mark.parametrize("at", slow_but(POINTS[:1], POINTS), ids=str)
def test_the_jacobian_is_that_of_the_expressions(at):
    places, slopes = formulas_of(SYMBOLS, EXPRESSIONS).jacobian()
    found = np.zeros((len(EXPRESSIONS), len(SYMBOLS)))
    found[tuple(np.transpose(places))] = slopes.numbers(*at)
    expected = [[exact(sp.diff(e, s), at) for s in SYMBOLS] for e in EXPRESSIONS]
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-14)


def test_steps_have_no_slope():
    made = formulas_of(SYMBOLS, [X + sp.floor(3 * X) * sp.ceiling(P), sp.Heaviside(X)])
    assert made.numbers(*POINTS[0]).tolist() == [1.3 + 3.0 * 2.0, 1.0]
    places, slopes = made.jacobian()
    assert (places, slopes.numbers(*POINTS[0]).tolist()) == ([(0, 0)], [1.0])


def test_derivatives_along_complex_directions():
    smooth = [EXPRESSIONS[i] for i in (0, 5, 8, 12)]
    at, u, v, w = POINTS[0], np.array([0.3 + 1j, -0.2]), np.array([0.5, 2.0 - 1j]), np.array([1.0, 0.1j])
    third = formulas_of(SYMBOLS, smooth).along(range(2)).along(range(2)).along(range(2))
    found = third.arrays(*at, *u, *v, *w)
    for value, expression in zip(found, smooth, strict=True):
        parts = [
            exact(sp.diff(expression, *[(X, Y)[i] for i in place]), at)
            * u[place[0]]
            * v[place[1]]
            * w[place[2]]
            for place in np.ndindex(2, 2, 2)
        ]
        assert value == pytest.approx(sum(parts), rel=1e-12)


def test_dependences_and_places_leave_out_what_does_not_matter():
    made = formulas_of(SYMBOLS, [X + Y - X, P * X**2, sp.Integer(3)])
    places, slopes = made.jacobian([0, 1])
    assert places == [(0, 1), (1, 0)]
    assert slopes.dependences == [frozenset(), frozenset({0, 2})]
    assert made.dependences == [frozenset({1}), frozenset({0, 2}), frozenset()]


def test_data_give_the_same_bits():
    made = formulas_of(SYMBOLS, EXPRESSIONS)
    again = formulas_from_data(json.loads(json.dumps(made.to_data())))
    for at in POINTS:
        assert (made.numbers(*at) == again.numbers(*at)).all()
    few = Formulas(made.tape, made.outputs[4:6])
    assert len(few.to_data()["ops"]) < len(made.tape.ops)
    again = formulas_from_data(few.to_data())
    assert (again.numbers(*POINTS[1]) == few.numbers(*POINTS[1])).all()


@pytest.mark.parametrize("count", [1, 3, len(EXPRESSIONS)])
def test_the_bits_of_a_number_do_not_depend_on_the_others(count):
    alone = [formulas_of(SYMBOLS, [e]).numbers(*POINTS[0])[0] for e in EXPRESSIONS[:count]]
    assert formulas_of(SYMBOLS, EXPRESSIONS[::-1]).numbers(*POINTS[0])[::-1][:count].tolist() == alone


@pytest.mark.filterwarnings("ignore")
def test_intervals_enclose_the_values():
    low, high = np.array([0.1, 0.5, 0.2]), np.array([0.4, 0.6, 3.0])
    made = formulas_of(SYMBOLS, [X**2 - X, sp.exp(-X) * Y / (1 + X), sp.tanh(3 * X) ** 3, *EXPRESSIONS])
    slopes = made.jacobian([0, 1])[1]
    for each in (made, slopes):
        bounds = [interval(b) for b in each.arrays(Interval(low, high), Interval(-high, low), 1.7, 0.3)]
        for across, along in np.ndindex(9, 9):
            x = np.minimum(low + across / 8 * (high - low), high)
            y = np.minimum(-high + along / 8 * (low + high), low)
            for value, bound in zip(each.arrays(x, y, 1.7, 0.3), bounds, strict=True):
                assert (np.isnan(value) | ((bound.low <= value) & (value <= bound.high))).all()


@pytest.mark.parametrize("x", [1.7, -0.3])
@pytest.mark.parametrize("n", range(-7, 12))
def test_an_integer_power_is_one_of_products(x, n):
    assert integer_power(x, n) == real_power(x, float(n)) == pytest.approx(x**n, rel=1e-15)


def test_numbers_are_computed_by_the_elementary_functions():
    made = formulas_of([X, P], [sp.sqrt(X), 1 / sp.sqrt(X), X**-3, X**P, X**1.5, sp.exp(-X), sp.E**P])
    assert made.numbers(2.3, 1.7).tolist() == [
        math.sqrt(2.3),
        1 / math.sqrt(2.3),
        1 / (2.3 * (2.3 * 2.3)),
        exponentials.power(2.3, 1.7),
        exponentials.power(2.3, 1.5),
        exponentials.exp(-2.3),
        exponentials.exp(1.7),
    ]


@pytest.mark.parametrize("function", ELEMENTARY.values(), ids=lambda f: f.__name__)
def test_every_function_is_the_elementary_one(function):
    if function.__name__ == "sech2":
        return
    x = 1.25 if function.__name__ == "acosh" else 0.37
    expression = getattr(sp, function.__name__)(X)
    assert formulas_of([X], [expression, X]).numbers(x).tolist() == [function(x), x]


@pytest.mark.parametrize("e", [sp.sqrt(X - 3), sp.log(X - 1), (X - 2) ** P, 1 / (X - 1), sp.exp(1000 * X)])
def test_what_has_no_real_value_is_not_finite(e):
    assert not np.isfinite(formulas_of([X, P], [e]).numbers(1.0, 0.5))


def test_the_branch_not_taken_needs_no_value():
    made = formulas_of([X], [sp.Piecewise((sp.log(X), X > 0), (0, True))])
    assert made.numbers(-1.0).tolist() == [0.0]


def test_a_base_that_rounding_has_made_negative_counts_as_zero_along_a_run():
    made = formulas_of([X, P], [X**1.5, X**P])
    assert [float(v) for v in made.along_run(-1e-18, 1.5)] == [0.0, 0.0]
    with np.errstate(invalid="ignore"):
        assert np.isnan(made.arrays(np.array([-1e-18]), np.array([1.5]))).all()


def test_an_unknown_function_is_named():
    with pytest.raises(TapeError, match="no operation for besselj"):
        formulas_of([X], [sp.besselj(0, X)])
    with pytest.raises(TapeError, match="formulas are of x, y, got p"):
        formulas_of([X, Y], [X + P])
    with pytest.raises(TypeError, match="2 values are needed, got 1"):
        formulas_of([X, Y], [X]).numbers(1.0)
