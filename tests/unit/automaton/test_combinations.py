"""Sums as numbers times expressions."""

import numpy as np
import sympy

from frictionlab.automaton.expressions import combinations_of, expressions_of, unsorted_product

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
    values = np.array([float(one.subs(AT)) for one in combined.expressions])
    np.testing.assert_allclose(combined.matrix @ values, [float(one.subs(AT)) for one in SUMS], rtol=1e-14)


def test_a_product_less_a_factor_is_what_sympy_makes_of_it():
    for expr in (2.5 * K * X / M, 2 * (K + M) * X, -X, X * sympy.sqrt(K)):
        rest = [factor for factor in expr.args if factor != X]
        assert unsorted_product(rest) == sympy.Mul(*rest)
    assert unsorted_product([]) == 1
