"""Lowered tapes compute what their expressions say, to any order, and a scene's tape skips what it lacks."""

import gc
from itertools import chain, combinations
from weakref import ref

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

import frictionlab as fl
from frictionlab.automaton import Event, Mode, Reset
from frictionlab.automaton.matrix_rows import MatrixProduct, matrix_rows
from frictionlab.hybrid.guard_bounds import Tape
from frictionlab.hybrid.kernels.jets import (
    first_order_bounds,
    majorant,
    mode_jets,
    mode_operations,
    slot_gradients,
)
from frictionlab.hybrid.kernels.power_onset import bound_affine_onset
from frictionlab.hybrid.variational.tangent_jets import TangentScratch, tangent_jets
from frictionlab.tape.packing import program_of
from frictionlab.tape.panels import panels_of
from frictionlab.tape.program import Numbers, Section
from frictionlab.tape.structural_zeros import sign_normal_form, structural_zeros
from frictionlab.tape.tape import TapeError

X, Y, A = sp.symbols("x y a")
VALUES = {X: sp.Rational(3, 4), Y: sp.Rational(-5, 8), A: sp.Rational(7, 3)}
ORDER = 12


bounded = st.sampled_from([sp.exp, sp.sin, sp.cos, sp.tan, sp.tanh, sp.sinh, sp.cosh, sp.atan])


def combine(children):
    pairs = st.tuples(children, children)
    return st.one_of(
        pairs.map(lambda p: p[0] + p[1]),
        pairs.map(lambda p: p[0] - p[1]),
        pairs.map(lambda p: p[0] * p[1]),
        pairs.map(lambda p: p[0] / (3 + p[1] ** 2)),
        st.tuples(children, st.integers(2, 5)).map(lambda p: p[0] ** p[1]),
        children.map(lambda c: (c**2 + 2) ** -3),
        children.map(lambda c: (c**2 + 2) ** (A / 2)),
        children.map(lambda c: sp.sqrt(1 + c**2)),
        st.tuples(bounded, children).map(lambda p: p[0](p[1] / (1 + p[1] ** 2))),
        children.map(lambda c: sp.log(2 + c**2)),
    )


leaves = st.sampled_from([X, Y, A, sp.Integer(2), sp.Rational(-1, 3), X * Y, X + A])
expressions = st.recursive(leaves, combine, max_leaves=6)


def jets_of(expression, flow, order=ORDER):
    """Taylor coefficients of an expression along a flow of (x, y), and their majorant.

    It is a section: event functions are multiplied out, which takes sympy most of the time.
    """
    given = fl.HybridAutomaton((X, Y), (fl.Mode("only", tuple(flow)),), {A: float(VALUES[A])})
    program, numbers = program_of(given, {"e": Section(expression)})
    state = np.array([float(VALUES[X]), float(VALUES[Y])])
    shape = program.slots, order + 1
    jets, bounds = np.zeros(shape), np.zeros(shape)
    mode_jets(program.code, numbers, 0, order, state, jets)
    majorant(program.code, Numbers(*map(np.abs, numbers)), 0, order, state, jets, bounds)
    slot = program.code.sections[0, 0]
    return jets[slot], bounds[slot]


@pytest.mark.plain_python
@given(expressions)
def test_values_are_sympys(expression):
    exact = float(expression.xreplace(VALUES))
    jet, bound = jets_of(expression, (Y, -X), order=0)
    assert abs(jet[0] - exact) <= 64 * np.finfo(float).eps * bound[0]


@pytest.mark.plain_python
@given(expressions)
def test_jets_along_straight_lines_are_the_taylor_series(expression):
    """With x' = 1, y' = 2 the jet is the series of f(x + s, y + 2 s)."""
    jet, bound = jets_of(expression, (sp.S.One, sp.Integer(2)))
    s = sp.Symbol("s")
    along = sp.lambdify(s, expression.xreplace({**VALUES, X: VALUES[X] + s, Y: VALUES[Y] + 2 * s}), "mpmath")
    with mpmath.workdps(60):
        exact = [float(c) for c in mpmath.taylor(lambda t: mpmath.mpf(1) * along(t), 0, ORDER)]
    assume(max(map(abs, exact)) < 1e100)
    assert (np.abs(jet - exact) <= 64 * np.finfo(float).eps * bound).all()


@given(expressions, expressions)
def test_the_majorant_bounds_the_jets(expression, rate):
    jet, bound = jets_of(expression, (rate, Y - X))
    assume(np.isfinite(bound).all())
    assert (np.abs(jet) <= bound * (1 + 1e-12)).all()


def test_jets_of_a_nonlinear_flow_to_order_forty():
    """x' = 1 + x^2 from 3/4: x = tan(s + atan(3/4))."""
    jet, _ = jets_of(X, (1 + X**2, sp.S.Zero), order=40)
    with mpmath.workdps(60):
        shift = mpmath.atan(mpmath.mpf(3) / 4)
        exact = np.array([float(c) for c in mpmath.taylor(lambda s: mpmath.tan(s + shift), 0, 40)])
    assert jet == pytest.approx(exact, rel=1e-13)


def test_jets_of_a_quotient_flow_to_order_thirty():
    """x' = 1/x from 3/4: x = sqrt(9/16 + 2 s)."""
    jet, _ = jets_of(X, (1 / X, sp.S.Zero), order=30)
    with mpmath.workdps(60):
        exact = mpmath.taylor(lambda s: mpmath.sqrt(mpmath.mpf(9) / 16 + 2 * s), 0, 30)
    assert jet == pytest.approx(np.array([float(c) for c in exact]), rel=1e-12)


@pytest.mark.plain_python
@pytest.mark.parametrize(("rows", "n"), [(37, 37), (17, 40), (3, 200), (1, 500)])
def test_rows_of_a_matrix_are_sums_in_the_sequence_of_its_columns(rows, n):
    """x' = A x: coefficient k + 1 is A x_k / (k + 1), to the last bit, with rows summed side by side.

    A product x y follows, whose operands have the slots `rows` and `rows` + 1; no term is before the matrix.
    """
    rng = np.random.default_rng(3)
    A = rng.standard_normal((rows, n)) * (rng.random((rows, n)) < 0.5)
    A[:, 7] = A[5:6] = 0.0
    states = sp.symbols(f"x:{n}", real=True)
    product = [states[rows] * states[rows + 1]] if rows < n else []
    flow = *matrix_rows(A, states), *product, *(sp.S.Zero for _ in range(n - rows - len(product)))
    program, numbers = program_of(fl.HybridAutomaton(states, (fl.Mode("only", flow),)))
    assert program.code.shared == 0 < len(numbers.terms)
    J, exact = np.zeros((program.slots, ORDER + 1)), [rng.standard_normal(n)]
    mode_jets(program.code, numbers, 0, ORDER, exact[0], J)
    for k in range(ORDER):
        rates = np.zeros(n)
        rates[:rows] = np.cumsum(A * exact[k], axis=1)[:, -1]
        if product:
            rates[rows] = exact[k][rows] * exact[0][rows + 1]
        exact.append(rates * (1.0 / (k + 1)))
    np.testing.assert_array_equal(J[:n].T, exact)


@pytest.mark.plain_python
def test_a_zero_of_a_matrix_leaves_out_what_is_infinite():
    """1/x at x = 0: jets, their bounds and slopes are finite in the rows without it, though not in others."""
    n, rng = 17, np.random.default_rng(3)
    A, x = rng.standard_normal((n, n)), rng.standard_normal(n)
    A[::2, 0] = x[0] = 0.0
    states = sp.symbols(f"x:{n}", real=True)
    flow = tuple(matrix_rows(A, (1 / states[0], *states[1:])))
    program, numbers = program_of(fl.HybridAutomaton(states, (fl.Mode("only", flow),)))
    code, sizes, slots = program.code, Numbers(*map(np.abs, numbers)), program.code.flow[0]
    J, bounds, T = (np.zeros((program.slots, width)) for width in (1, 1, n))
    reach = np.ones((program.slots, 2))
    with np.errstate(all="ignore"):
        mode_jets(code, numbers, 0, 0, x, J)
        majorant(code, sizes, 0, 0, x, J, bounds)
        sharper = bounds.copy()
        first_order_bounds(code, sizes, 0, J, sharper)
        reach[np.isinf(J[:, 0])] = np.inf
        onset = [bound_affine_onset(code, sizes, slot - n, 0, 1.0, J, reach)[0] for slot in slots]
        slot_gradients(code, numbers, 0, x, J, T)
        scratch = TangentScratch(J, np.zeros((program.slots, 1, n)))
        scratch.T[np.arange(n), 0, np.arange(n)] = 1.0
        tangent_jets(code, numbers, mode_operations(code, 0), 0, code.flow[0], scratch)
        terms = Tape(code, numbers, 0).magnitudes(x[None], slots.tolist())[0]
    rest = np.abs(A[:, 1:])
    found = [J[slots, 0], *(each[slots, 0] for each in (bounds, sharper)), onset, terms]
    exact = [A[:, 1:] @ x[1:], *[rest @ np.abs(x[1:])] * 2, rest.sum(axis=1), rest @ np.abs(x[1:])]
    np.testing.assert_allclose(np.array(found)[:, ::2], np.array(exact)[:, ::2], rtol=1e-13)
    assert not np.isfinite(np.array(found)[:, 1::2]).any()
    for slopes in (T, scratch.T[:, 0]):
        np.testing.assert_array_equal(slopes[slots[::2]], A[::2])


def test_panels_are_forgotten_with_their_matrix():
    product = MatrixProduct(np.ones((2, 2)), (X, Y))
    assert panels_of(product) is panels_of(product.with_own((A,)))
    known = ref(product)
    del product
    gc.collect()
    assert known() is None


@pytest.mark.plain_python
def test_equal_subexpressions_cost_once():
    mode = fl.Mode("only", ((1 + X * Y) ** 3, X * Y), (fl.Event("e", (1 + X * Y) ** 2),))
    program, _ = program_of(fl.HybridAutomaton((X, Y), (mode,)))
    counts = program.tapes[0].counts()
    assert (counts["product"], counts["square"], counts["quotient"]) == (2, 1, 0)


@pytest.mark.plain_python
def test_a_force_of_powers_of_a_sum_is_one_term_where_it_acts():
    d = 1 + X * Y
    force = A * d + 2 * d**3
    mode = fl.Mode("only", (force - X, (Y - A * d - 2 * d**3) / A))
    program, _ = program_of(fl.HybridAutomaton((X, Y), (mode,), {A: 2.0}))
    counts = program.tapes[0].counts()
    assert (counts["product"], counts["square"]) == (2, 1)
    assert len(program.tapes[0].terms) == 6  # one in d, one in A + 2 d^2, two in each rate


@pytest.mark.plain_python
@pytest.mark.parametrize("function", [sp.gamma(X), sp.Abs(X - A), A**X, sp.Max(X, 0)], ids=str)
def test_a_function_without_operation_is_named(function):
    with pytest.raises(TapeError, match="no operation for") as error:
        jets_of(1 + 2 * function, (Y, -X))
    assert str(function) in str(error.value)


@pytest.mark.plain_python
def test_a_function_of_parameters_alone_is_a_number():
    assert jets_of(X * sp.sin(A), (Y, -X))[0][0] == pytest.approx(0.75 * np.sin(7 / 3), rel=1e-15)


# --- the eight on/off combinations of the slider on the belt

TOGGLES = ("cubic", "nonsmooth", "geometry")
COMBINATIONS = list(chain.from_iterable(combinations(TOGGLES, n) for n in range(4)))
OPERATIONS = ("affine", "product", "square", "quotient")


def cost(off):
    return program_of(fl.SliderOnBelt().without(*off).automaton())[0].cost()


@pytest.mark.parametrize("off", COMBINATIONS, ids=lambda off: "-".join(off) or "full")
def test_a_scene_does_not_pay_for_what_it_lacks(off):
    costs = cost(off)
    assert {c["states"] for c in costs.values()} == {8 if "geometry" in off else 10}
    # In chatter there is W_N^T M^-1 W_N, which depends on where the slider is.
    assert all(c["quotient"] == 0 for name, c in costs.items() if name != "chatter")
    if "nonsmooth" in off:
        assert list(costs) == ["slip"]
        assert costs["slip"]["guards"] == 0
    else:
        guards = {name: c["guards"] for name, c in costs.items()}
        expected = {"stick": 3, "slip+": 2, "slip-": 2, "separation": 1}
        assert guards == expected | ({} if "geometry" in off else {"chatter": 2})
    if {"cubic", "geometry"} <= set(off):
        assert all(c["product"] == c["square"] == 0 for c in costs.values())


@pytest.mark.parametrize(
    ("off", "toggle"), [(off, toggle) for off in COMBINATIONS for toggle in TOGGLES if toggle not in off]
)
def test_each_switch_reduces_or_keeps_every_count(off, toggle):
    before, after = cost(off), cost((*off, toggle))
    if toggle == "nonsmooth":
        # the one mode left is sliding in the direction of the belt
        before = {"slip": before["slip+"]}
    assert after
    for mode, counts in after.items():
        assert all(counts[kind] <= before[mode][kind] for kind in (*OPERATIONS, "guards", "states"))


def test_the_linear_smooth_scene_is_one_affine_combination_per_acceleration():
    counts = cost(TOGGLES)["slip"]
    assert counts["product"] == counts["square"] == counts["quotient"] == 0
    assert counts["affine"] <= 5  # four accelerations and the gap


def test_only_numbers_differ_between_parameters():
    one, two = (fl.SliderOnBelt(mu_k=mu).automaton() for mu in (0.3, 1.4))
    assert program_of(one)[0] is program_of(two)[0]


@pytest.mark.parametrize("exponent", [3, 2, 1, -2])
def test_an_integer_exponent_may_be_written_as_a_float(exponent):
    """x^2.0 is x^2 for a negative x too, in flows, outputs, sections and quadratures."""

    def run(written):
        outputs = {"w": X**written}
        flow = Y, -X - 0.1 * (X - 3) ** written
        automaton = fl.HybridAutomaton((X, Y), (fl.Mode("on", flow, outputs=outputs),), coordinates=1)
        return fl.solve(
            automaton,
            4.0,
            x0=[1.0, 0.0],
            sections={"half": (X - 0.5) ** abs(written)},
            quadratures={"a": Y**written if exponent > 0 else (X - 3) ** written, "b": f"(x - 3)**{written}"},
            progress=False,
        )

    found, expected = run(float(exponent)), run(exponent)
    assert expected.states[:, 1].min() < 0
    assert found.final_state.tolist() == expected.final_state.tolist()
    assert found.w.tolist() == expected.w.tolist()
    assert found.quadratures == expected.quadratures
    assert found.sections["half"].t.tolist() == expected.sections["half"].t.tolist()


def test_a_power_zero_written_as_a_float_is_one():
    automaton = fl.HybridAutomaton((X,), (fl.Mode("on", (X**0.0,)),))
    assert fl.solve(automaton, 2.0, x0=[-1.0], progress=False).final_state == pytest.approx([1.0])


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
