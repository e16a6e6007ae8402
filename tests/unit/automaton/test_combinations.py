"""Sums as numbers times expressions."""

import numpy as np
import sympy

from frictionlab.automaton.expressions import combinations_of, expressions_of, unsorted_product
from frictionlab.automaton.mode import Mode
from frictionlab.stability import flow
from frictionlab.stability.flow import Flow

X, Y, K, M = sympy.symbols("x y k m", real=True)
SUMS = [K * (2 * X - 0.5 * Y) / M + 3, (K + M) * Y + X, 0.1 * X**3 - 7 * K, sympy.S.Zero, sympy.cos(X) * Y]
AT = {X: 0.3, Y: -1.7, K: 11.0, M: 0.7}


def test_sums_are_made_again_of_numbers_and_expressions():
    found = combinations_of(SUMS, (X, Y))
    again = expressions_of(found.matrix, found.expressions)
    assert all(sympy.expand(one - other) == 0 for one, other in zip(SUMS, again, strict=True))
    assert set(found.expressions) == {
        K * X / M, K * Y / M, sympy.S.One, (K + M) * Y, X, X**3, K, sympy.cos(X) * Y
    }  # fmt: skip


def test_values_are_those_of_the_sums():
    combined = combinations_of(SUMS, ())
    found = combined.values(np.array([float(one.subs(AT)) for one in combined.expressions]))
    np.testing.assert_allclose(found, [float(one.subs(AT)) for one in SUMS], rtol=1e-14)


def test_a_product_less_a_factor_is_what_sympy_makes_of_it():
    for expr in (2.5 * K * X / M, 2 * (K + M) * X, -X, X * sympy.sqrt(K)):
        rest = [factor for factor in expr.args if factor != X]
        assert unsorted_product(rest) == sympy.Mul(*rest)
    assert unsorted_product([]) == 1


def test_a_flow_of_many_terms_is_that_of_few(monkeypatch):
    mode = Mode("only", (Y, *SUMS[:1]))
    states, values = np.array([[0.3, 1.0], [-1.7, 0.2]]), (11.0, np.array([0.7, 0.9]))
    few = Flow((X, Y), (K, M), mode.flow, (), 1)
    expected = few.rhs(states, values), few.jacobian(states, values)
    monkeypatch.setattr(flow, "MANY_TERMS", 0)
    many = Flow((X, Y), (K, M), mode.flow, (), 1)
    for one, other in zip(expected, (many.rhs(states, values), many.jacobian(states, values)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)
    np.testing.assert_allclose(many.jacobian(states[:, 0], (11.0, 0.7)), expected[1][0], rtol=1e-14)
