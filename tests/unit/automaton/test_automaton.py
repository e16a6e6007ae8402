"""Mistakes in an automaton of one's own are named where they are written."""

import math
import pickle

import numpy as np
import pytest
import sympy
import sympy as sp

import frictionlab as fl
from frictionlab.automaton.expressions import combinations_of, expressions_of, unsorted_product

X, V, K = sp.symbols("x v k")
ON = fl.Mode("on", (V, -X))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fl.Event("gap", X, "on"), r"targets of event 'gap' must be a tuple of names, .* \('on',\)"),
        (lambda: fl.Mode("on", (V, -X), fl.Event("gap", X)), "mode 'on' must be a tuple, got the Event"),
        (lambda: fl.Mode("on", (V, -X), ("gap",)), "must be of the class Event, got 'gap'"),
        (lambda: fl.HybridAutomaton((X, V), ON), "modes must be a tuple, got the Mode 'on' alone"),
        (lambda: fl.HybridAutomaton((X, V), ("on",)), "modes must be of the class Mode, got 'on'"),
        (lambda: fl.HybridAutomaton(("x", "v"), (ON,)), "states must be symbols, got 'x': make them"),
        (lambda: fl.HybridAutomaton((X, V), (ON,), {"k": 1.0}), "parameters must be symbols, got 'k'"),
    ],
)
def test_refused(make, message):
    with pytest.raises(TypeError, match=message):
        make()


@pytest.mark.parametrize(
    "automaton",
    [
        fl.HybridAutomaton((X, V), (fl.Mode("on", (V, "-x")),)),
        fl.HybridAutomaton((X, V), (fl.Mode("on", (V, -X), (fl.Event("end", "x", ("on",)),)),)),
        fl.HybridAutomaton((X, V), (fl.Mode("on", (V, -X), outputs={"u": "x"}),)),
    ],
)
def test_a_text_is_no_expression(automaton):
    """sympy would run it as Python."""
    with pytest.raises(TypeError, match=r"must be an expression, got the text '-?x': write it with"):
        fl.solve(automaton, 1.0, x0=[1.0, 0.0])


def test_its_repr_has_the_names_and_no_equations():
    assert repr(fl.HybridAutomaton((X, V), (ON,), {}, 1)) == "HybridAutomaton(states x, v; modes on)"


def test_parameters_change_only_in_a_new_automaton():
    swing = fl.HybridAutomaton((X,), (fl.Mode("on", (K * X,)),), {K: 1.0})
    for one in (swing, pickle.loads(pickle.dumps(swing))):
        with pytest.raises(TypeError):
            one.parameters[K] = 2.0  # type: ignore[index]  # what is tested
        assert [fl.solve(each, 1.0, x0=[1.0]).final_state[0] for each in (one, one.replace(k=2.0))] == (
            pytest.approx([math.e, math.e**2], rel=1e-14)
        )


def test_time_as_a_symbol_is_refused_with_a_cure_that_moves():
    """A parameter t would stand still; a state that stands for time gives (cos t - cos 2 t)/3."""
    x, v, t, clock = sp.symbols("x v t clock")
    with pytest.raises(ValueError, match=r"\['t'\].*cos\(q.phase\).*a state whose rate is 1"):
        fl.solve(
            fl.HybridAutomaton((x, v), (fl.Mode("only", (v, sp.cos(t) - 4 * x)),), {}, 1), 1.0, x0=[0, 0]
        )
    forced = fl.Mode("only", (v, sp.cos(clock) - 4 * x, sp.S.One))
    run = fl.solve(fl.HybridAutomaton((x, v, clock), (forced,), {}, 1), 5.0, x0=[0, 0, 0], progress=False)
    assert run.final_state[0] == pytest.approx((math.cos(5) - math.cos(10)) / 3, rel=1e-12)


def test_lists_are_as_good_as_tuples():
    """x'' = -x up to x = 0, then x'' = -4 x: half a period and a quarter later x is 0 again."""
    fast = fl.Mode("fast", [V, -4 * X], [fl.Event("back", -X, ["slow"])])
    slow = fl.Mode("slow", [V, -X], [fl.Event("over", X, ["fast"])])
    run = fl.solve(fl.HybridAutomaton([X, V], [slow, fast], {}, 1), 4.0, x0=[1.0, 0.0], progress=False)
    assert run.events.t == pytest.approx([math.pi / 2, math.pi])


def test_a_symbol_with_other_assumptions_is_another():
    decay = fl.HybridAutomaton((sp.Symbol("x", positive=True),), (fl.Mode("only", (-X,)),))
    with pytest.raises(
        ValueError, match="take the symbol that the automaton holds, with the same assumptions"
    ):
        fl.solve(decay, 1.0, x0=[1.0])


def test_names_that_are_there_twice_are_refused():
    """Values go by names: of two parameters k the first kept its value, whatever replaced it."""
    other, on = sp.Symbol("k", positive=True), fl.Mode("on", (V, -X * K))
    pair = fl.Mode("on", (V, -X * (K + other)))
    for states, mode, values in (((X, X), on, {K: 1.0}), ((X, V), pair, {K: 1.0, other: 2.0})):
        with pytest.raises(ValueError, match=r"must have different names, got \['(x|k)'\] twice: rename one"):
            fl.solve(fl.HybridAutomaton(states, (mode,), values, 1), 1.0, x0=[1.0, 0.0])


@pytest.mark.parametrize("name", ["mode", "power", "closed", "impulse", "friction_impulse_2"])
def test_a_state_has_a_column_of_its_own(name):
    """run["power"] was the state and run.power the output; of a state named mode a table had the modes,
    of one named impulse the impulses of impacts."""
    state = sp.Symbol(name)
    one = fl.HybridAutomaton((state,), (fl.Mode("on", (-state,), outputs={"power": state**2}),), {})
    with pytest.raises(ValueError, match=f"a state must not be named like an output .*, got '{name}'"):
        fl.solve(one, 1.0, x0=[1.0])


def test_modes_with_other_outputs_are_refused():
    off = fl.Mode("off", (V, -X), outputs={"E": X**2})
    with pytest.raises(
        ValueError, match=r"the same outputs, got \['E'\] in 'off' and \[\] in 'on': give each"
    ):
        fl.solve(fl.HybridAutomaton((X, V), (ON, off), {}, 1), 1.0, x0=[1.0, 0.0])


def test_a_parameter_named_chatter_keeps_its_value():
    """It is the solver's only where there are limit modes; cos 2 and -2 sin 2."""
    chatter = sp.Symbol("chatter")
    swing = fl.HybridAutomaton((X, V), (fl.Mode("on", (V, -X * chatter)),), {chatter: 4.0}, 1)
    run = fl.solve(swing, 1.0, x0=[1.0, 0.0], progress=False)
    assert run.final_state == pytest.approx([math.cos(2.0), -2.0 * math.sin(2.0)], rel=1e-14)


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
