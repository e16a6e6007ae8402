"""Equilibria by bounds: narrow, steep, threefold ones; none where there is none; and what is said of it."""

from __future__ import annotations

import pickle
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import frictionlab as fl
from frictionlab.tape.intervals import Interval, select
from tests.helpers.cases import slow_but

X, Y, Z, V, W = sympy.symbols("x y z v w")
A, B, P = sympy.symbols("a b p")


def equilibria(flow, states=(X, V), coordinates=1, **values):
    mode = fl.Mode("only", tuple(map(sympy.sympify, flow)))
    numbers = {sympy.Symbol(name): value for name, value in values.items()}
    return fl.equilibria(fl.HybridAutomaton(states, (mode,), numbers, coordinates))


@pytest.mark.parametrize("a", [1e-1, 1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("p", [1e-9, 1.0, 1e6])
def test_a_steep_exponential(a, p):
    """p = exp((x - b)/a), as slip rates of rate and state friction: x = b + a ln p."""
    found = equilibria([V, P - sympy.exp((X - B) / A) - V], a=a, b=0.6, p=p)
    assert found.complete
    assert [e.q[0] for e in found] == [pytest.approx(0.6 + a * np.log(p), rel=1e-12)]


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6])
def test_a_narrow_well_far_from_the_rest(width):
    def force(x):
        return 0.3 - x - 50 / width * (x - 5) * np.exp(-(((x - 5) / width) ** 2))

    well = 50 / A * (X - 5) * sympy.exp(-(((X - 5) / A) ** 2))
    found = equilibria([V, sympy.Rational(3, 10) - X - well - V], a=width)
    depth = np.sqrt(np.log(50 / 4.7))
    near = (
        brentq(force, 5 - 0.7 * width, 5, xtol=1e-15),
        brentq(force, 5 - 2 * depth * width, 5 - 0.7 * width),
    )
    assert found.complete
    np.testing.assert_allclose(sorted(e.q[0] for e in found), [0.3, *sorted(near)], rtol=1e-9)


def test_a_threefold_equilibrium_counts_once():
    """Pitchforks at their very point, at zero, elsewhere, and of one of two coordinates."""
    for flow, states, n in (
        ([V, -V - X**3], (X, V), 1),
        ([V, P * X - X**3 - V], (X, V), 1),
        ([V, W, Y - X - X**3 - V, X - Y - W], (X, Y, V, W), 2),
        ([V, -V - 1e-12 * X**3 - X**5], (X, V), 1),
    ):
        found = equilibria(flow, states, n, p=0.0)
        assert found.complete
        np.testing.assert_allclose([e.q for e in found], [np.zeros(n)], atol=1e-12)
    shifted = equilibria([sympy.expand((X - 1) ** 3)], (X,), 0)
    np.testing.assert_allclose([e.q[0] for e in shifted], [1.0], atol=1e-4)  # rounding leaves 1e-16^(1/3)


def test_a_product_of_two_states_may_be_negative():
    known = equilibria([X * Y + 1, X**2 + Y**2 - 4], (X, Y), 0)
    assert known.complete
    expected = [(s * np.sqrt(2) + t * np.sqrt(6)) / 2 for s in (-1, 1) for t in (-1, 1)]
    assert sorted(one.state[0] for one in known) == pytest.approx(sorted(expected), rel=1e-14)


def test_where_there_is_none_it_is_known():
    for flow, states, n in (
        ([V, 2 - sympy.sin(X) - V], (X, V), 1),
        ([V, 1 - sympy.tanh(V)], (X, V), 1),
        ([V, (X - 1) ** 2 + 1e-20 - V], (X, V), 1),
        ([V, 1 + sympy.exp(X) - V], (X, V), 1),
        ([1 + sympy.Abs(X)], (X,), 0),
        ([sympy.cosh(X - Y) - Y, 1 + X**2 + Y**2], (X, Y), 0),
        ([sympy.sqrt(X) + 1], (X,), 0),
        ([X**2 * Y - X + 1, X - X**2 * Y, Z], (X, Y, Z), 0),
    ):
        found = equilibria(flow, states, n)
        assert found == ()
        assert found.complete
        assert repr(found) == "Equilibria(none exists)"


@pytest.mark.parametrize("order", slow_but([2, 5], [1, 2, 3, 5]))
@pytest.mark.parametrize("scale", slow_but([1e-3, 1e6], [1.0, 1e-3, 1e6]))
def test_a_pole_is_no_equilibrium(order, scale):
    """3 + 1/(x/s - 1)^n: one zero beside the pole for odd n, none for even n; of 1/(x/s - 1)^n alone none."""
    pole = (X / A - 1) ** -order
    found = equilibria([3 + pole], (X,), 0, a=scale)
    beside = [scale * (1 - 3 ** (-1 / order))] if order % 2 else []
    np.testing.assert_allclose([e.state[0] for e in found], beside, rtol=1e-12)
    alone = equilibria([pole], (X,), 0, a=scale)
    assert alone == ()
    assert found.complete
    assert alone.complete


def test_a_zero_beside_a_pole_is_not_taken_for_it():
    """(x - 1)/(x - p): the zero is listed, or it is said that there may be one."""
    for distance in (1e-3, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14):
        found = equilibria([(X - 1) / (X - 1 - A)], (X,), 0, a=distance)
        there = [e.state[0] for e in found]
        assert there == [pytest.approx(1.0, rel=1e-12)] or (there == [] and not found.complete)
    assert equilibria([(X - 1) / (X - 1 - A)], (X,), 0, a=1e-3).complete
    # Between two poles that are 30 floats apart.
    shifted = sympy.atan(X) - sympy.Float(1.2, 20)
    assert not equilibria([1 / shifted + 2 / (shifted - A)], (X,), 0, a=16 * 2.0**-53).complete
    # A jump from -2 to infinity is neither.
    (only,) = equilibria([sympy.exp(1 / (X - 1.3)) - 2], (X,), 0)
    assert only.state[0] == pytest.approx(1.3 + 1 / np.log(2), rel=1e-12)
    removed = equilibria([(X - 1) * (X - 1 - A) / (X - 1 - A)], (X,), 0, a=1e-3)
    assert [e.state[0] for e in removed] == [1.0]


def test_what_is_not_known_is_said():
    many = sympy.symbols("x:5")
    rates = tuple(
        x**2 - y + 1 for x, y in zip(many, (*many[1:], many[0]), strict=True)
    )  # their sum is positive
    free = fl.HybridAutomaton(many, (fl.Mode("only", rates),), {}, 0)
    found = fl.equilibria(free)
    assert not found.complete
    assert "others are not excluded: in its only mode 5 states enter nonlinearly" in repr(found)
    with pytest.raises(ValueError, match="none was found in its only mode by a search that cannot"):
        fl.equilibrium(free)
    endless = equilibria([V, sympy.Rational(1, 2) - sympy.sin(3 * X / 2) - V])  # X is no angle
    assert not endless.complete
    first = [endless[i].q[0] for i in range(4)]
    np.testing.assert_allclose(first, np.pi * np.array([1 / 9, 5 / 9, -7 / 9, -11 / 9]), rtol=1e-12)
    assert pickle.loads(pickle.dumps(endless)).why == endless.why
    assert fl.equilibria(fl.SliderOnBelt()).complete
    assert fl.equilibria(fl.SliderOnBelt(contact=fl.HertzContact())).complete


def test_a_sine_of_many_turns_gives_no_zeros_by_rounding():
    """4 - 2 sin x = 0 beside a spring to y has no solution; sin x = 1/2 is known to the last digits of x."""
    pull = 10 * (Y - X / 3)

    def found(torque):
        flow = (V, W, torque - 2 * sympy.sin(X) + pull / 3 - V, -pull - W)
        return equilibria(flow, (X, Y, V, W), 2)

    assert found(4) == ()
    known = found(1)
    many = [e.q[0] for e in known]
    assert len(many) > 100
    assert " more, others are not excluded: in" in repr(known)
    assert len(repr(known)) < 1000
    assert max(abs(np.sin(x) - 0.5) / np.spacing(abs(x)) for x in many) < 4


@settings(max_examples=12)
@given(
    st.lists(st.floats(-6, 6), min_size=1, max_size=4),
    st.lists(st.booleans(), min_size=4, max_size=4),
    st.floats(-1, 1, allow_subnormal=False),  # products with a subnormal number have no digits
)
def test_all_roots_of_two_coupled_polynomials(decades, signs, skew):
    """Roots in twelve decades, each once; products condensed onto one coordinate by a spring."""
    roots = sorted({round(10**d, 9) * (1 if s else -1) for d, s in zip(decades, signs, strict=False)})
    if any(abs(a / b - 1) < 1e-3 for a in roots for b in roots if a != b):
        return
    rate = sympy.prod([X - sympy.Float(root) for root in roots])
    found = equilibria([V, W, Y - P * X - V, -W - rate + (Y - P * X) * B], (X, Y, V, W), 2, p=skew, b=3.0)
    assert found.complete
    np.testing.assert_allclose(sorted(e.q[0] for e in found), roots, rtol=1e-9)
    np.testing.assert_allclose(
        [e.q[1] for e in found], [skew * e.q[0] for e in found], rtol=1e-9, atol=1e-300
    )


FUNCTIONS = [
    lambda x: x**3 - 2.0 * x + 1.0,
    lambda x: np.exp(-x) - 3.0 / x,
    lambda x: np.sin(3.0 * x) + np.cos(x * x),
    lambda x: np.tanh(x) / (1.0 + x**2),
    lambda x: np.sqrt(x) * np.log(x),
    lambda x: x**-2 + x**1.5,
    lambda x: np.tan(x) - np.arctan(x),
    lambda x: abs(x) - np.sign(x) + np.heaviside(x, 0.5),
    lambda x: np.maximum(x, 1.0) * np.minimum(x**3, 2.0),
    lambda x: np.arcsin(x) + np.arccosh(x + 1.0) - np.arctanh(x),
    lambda x: np.arccos(x / 3.0) * x**-3,
    lambda x: x ** np.array([0.7]) - x ** np.array([-2.0]),
    lambda x: np.float64(3.0) ** x - np.array([0.5]) ** x,
    lambda x: 2.0**x - np.float64(3.0) * np.cosh(x) + np.arcsinh(x),
    lambda x: np.floor(x) * np.ceil(0.7 * x),
    lambda x: np.arctan2(x - 1.0, 2.0 - x) + np.arctan2(x, x - 3.0),
    lambda x: select(np.less(x, 1.0), x * x - 3.0, select(np.less_equal(x, 4.0), np.sqrt(x - 2.0), 1.0 / x)),
    lambda x: select(np.logical_and(np.less(-2.0, x), np.logical_not(np.less(3.0, x))), np.exp(x), -x),
    lambda x: select(np.logical_or(np.equal(x, np.floor(x)), np.less(x, 0.0)), x, np.sin(x)) * x,
    lambda x: np.exp(x / 9.0) ** np.tanh(x) - x**x,
]


@pytest.mark.filterwarnings("ignore")
@given(st.integers(0, len(FUNCTIONS) - 1), st.floats(-30, 30), st.floats(-9, 2))
def test_bounds_hold_all_values(which, middle, decade):
    function, half = FUNCTIONS[which], 10.0**decade
    bounds = function(Interval(np.array([middle - half]), np.array([middle + half])))
    values = function(np.clip(np.linspace(middle - half, middle + half, 101), middle - half, middle + half))
    values = values[np.isfinite(values)]
    assert (values >= bounds.low).all()
    assert (values <= bounds.high).all()


CORNERS_AND_JUMPS = {
    "half at the jump": (sympy.Heaviside(X) - sympy.Rational(1, 2) - X / 4, [-2.0, 0.0, 2.0]),
    "past zero": (sympy.Piecewise((-1, X < 0), (1, True)) - X / 2, [-2.0, 2.0]),
    "pieces": (sympy.Piecewise((-X - 2, X < 0), (1 - X, True)), [-2.0, 1.0]),
    "floor": (sympy.floor(X) + sympy.Rational(1, 2) - 2 * X, [-0.25, 0.25]),
    "ceiling": (sympy.ceiling(X) - X**2, [0.0, 1.0, np.sqrt(2)]),
    "sign": (sympy.sign(X) - X**3, [-1.0, 0.0, 1.0]),
    "zero at one point": (sympy.Piecewise((-1, X < 2), (0, sympy.Eq(X, 2)), (1, True)), [2.0]),
    "two conditions": (sympy.Piecewise((2, (X > 0) & (X < 1)), (-1, True)) - X, [-1.0]),
    "corner": (sympy.Piecewise((3 * X - 1, sympy.Rational(1, 3) > X), (6 * X - 2, True)), [1 / 3]),
    "greatest": (sympy.Max(X, 1) - 2, [2.0]),
    "least": (sympy.Min(X, 3 * X) - 1, [1.0]),
    "absolute": (sympy.Abs(X - 1) - sympy.Rational(1, 2), [0.5, 1.5]),
    "play": (sympy.Max(-5 * X - 5, 0) - sympy.Max(3 * X - 3, 0) + sympy.Rational(1, 10) - X / 7, [0.7]),
    "angle": (sympy.atan2(X - 1, X + 2) - sympy.Rational(1, 2), [(1 + 2 * np.tan(0.5)) / (1 - np.tan(0.5))]),
}


@pytest.mark.parametrize("law", CORNERS_AND_JUMPS)
def test_corners_and_jumps(law):
    """Derivatives do not tell of jumps; by these alone the flow would be linear."""
    rate, exact = CORNERS_AND_JUMPS[law]
    found = equilibria([rate], (X,), 0)
    assert found.complete
    assert sorted(float(e.q[0]) for e in found) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(
    ("rate", "exact", "jump"),
    [
        (sympy.sign(X - 3) + 2 - X, [1.0], "near 3"),
        (sympy.floor(X) - X / 2, [0.0], "near 2"),
        (sympy.Piecewise((X - 3, X < 3), (X, True)), [], "near 3"),
        (sympy.atan2(X, -1), [], "near 0"),
    ],
)
def test_a_rate_that_comes_to_zero_beside_a_jump(rate, exact, jump):
    """Floats do not tell whether it gets there."""
    found = equilibria([rate], (X,), 0)
    assert sorted(float(e.q[0]) for e in found) == pytest.approx(exact, rel=1e-12)
    assert found.why.startswith("in its only mode rates may come to zero beside a jump")
    assert found.why.endswith(jump)


@given(
    st.lists(st.integers(-12, 12), min_size=1, max_size=3, unique=True),
    st.lists(st.tuples(st.integers(-3, 3), st.integers(-8, 8)), min_size=4, max_size=4),
)
def test_zeros_of_pieces_are_those_of_each_piece(borders, lines):
    """Straight lines between jumps: each has its zero, which counts if it lies on its own piece."""
    borders = [Fraction(border, 4) for border in sorted(borders)]
    ends = [-np.inf, *borders, np.inf]
    lines = [(slope, Fraction(2 * constant + 1, 8)) for slope, constant in lines[: len(borders) + 1]]
    zeros = {i: -constant / slope for i, (slope, constant) in enumerate(lines) if slope}
    beside = any(zero == ends[i + 1] for i, zero in zeros.items())  # the border belongs to the next piece
    exact = sorted(zero for i, zero in zeros.items() if ends[i] <= zero < ends[i + 1])
    conditions = [sympy.Rational(border) > X for border in borders]
    values = [slope * X + sympy.Rational(constant) for slope, constant in lines]
    found = equilibria([sympy.Piecewise(*zip(values, [*conditions, True], strict=True))], (X,), 0)
    assert found.complete or beside
    assert sorted(float(e.q[0]) for e in found) == pytest.approx([float(zero) for zero in exact], rel=1e-9)


@pytest.mark.parametrize("force", [0.5, 1.5, 4.0])
def test_two_bodies_with_play(force):
    """Stops with gaps of 1 and 2 at two bodies on springs: each regime is linear, and one holds."""
    load = sympy.Float(force)
    found = equilibria(
        [V, W, load + Y - 2 * X - 9 * sympy.Max(X - 1, 0) - V, X - 2 * Y - 4 * sympy.Max(X - Y - 0.5, 0) - W],
        (X, Y, V, W),
        2,
    )
    regimes = []
    for stop, link in np.ndindex(2, 2):
        matrix = np.array([[2.0 + 9 * stop, -1.0], [-1.0 + 4 * link, 2.0 - 4 * link]])
        x, y = np.linalg.solve(matrix, [force + 9 * stop, 2.0 * link])
        if (x >= 1) == stop and (x - y >= 0.5) == link:
            regimes.append((x, y))
    assert found.complete
    np.testing.assert_allclose([e.q for e in found], regimes, rtol=1e-12)


def test_steps_of_velocities_leave_the_search_complete():
    """Drag v |v| as v^2 sgn v, at rest: the roots of x^3 - 10 x + 10."""
    found = equilibria([V, 1 - X + X**3 / 10 - V**2 * sympy.sign(V)])
    assert found.complete
    assert sorted(e.q[0] for e in found) == pytest.approx(np.sort(np.roots([1, 0, -10, 10]).real), rel=1e-12)
