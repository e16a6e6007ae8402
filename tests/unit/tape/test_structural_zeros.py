"""Functions zero together are found however they are written; powers of long sums are left as they are."""

import pytest
import sympy as sp

from frictionlab.automaton import Event, Mode, Reset
from frictionlab.tape.structural_zeros import sign_normal_form, structural_zeros

X, Y, K = sp.symbols("x y k")


@pytest.mark.parametrize(
    ("one", "other"),
    [(X - Y, Y - X), (K * (X - Y), K * Y - K * X), ((X + Y) ** 2, X**2 + 2 * X * Y + Y**2), (X / K, -X / K)],
)
def test_a_function_and_its_negative_are_zero_together(one, other):
    assert sign_normal_form(one) == sign_normal_form(other)


def test_different_functions_are_told_apart():
    assert sign_normal_form(X - Y) != sign_normal_form(X + Y)


@pytest.mark.slow
def test_long_sums_are_compared_whatever_their_order():
    terms = [(i + 1) * X ** (i + 1) for i in range(1500)]
    one, other = sp.Add(*terms), sp.Add(*(-term for term in reversed(terms)), evaluate=False)
    assert sign_normal_form(one) == sign_normal_form(other)


@pytest.mark.parametrize(("number", "zeros"), [(0, {X: 1}), (0.0, {X: 1}), (2, {})])
def test_resets_may_give_plain_numbers(number, zeros):
    event = Event("touch", X, ("m",), Reset({X: number}))
    assert structural_zeros(Mode("m", (Y, sp.S.Zero), events=(event,)), event, event.reset) == zeros


@pytest.mark.parametrize(
    "function",
    [(X + Y + 1) ** 5000, ((X + Y + 1) ** 40 + 1) ** 40, sp.exp((X + Y) ** 9999), (X + Y + K) ** -3000],
)
def test_what_would_be_too_long_is_not_multiplied_out(function):
    """Some of these have more terms than a computer holds."""
    assert sign_normal_form(function) == function
    assert sign_normal_form(-function) == sign_normal_form(function)
    event = Event("touch", function, ("m",), Reset({X: -X}))
    mode = Mode("m", (Y, sp.S.Zero), events=(event,))
    assert set(structural_zeros(mode, event, event.reset)) <= {function}
