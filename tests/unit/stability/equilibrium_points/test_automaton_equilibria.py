"""Automata of one's own: equilibria inside the guards, and all that follows from them."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import frictionlab as fl
from frictionlab.stability.equilibrium_points.steady_rates import states_by_constraints
from tests.helpers.cases import slow_but
from tests.helpers.linear_automata import linear

pytestmark = pytest.mark.blas

X, Y, V, W = sympy.symbols("x y v w")
NAMES = ("c", "k", "N", "belt", "mu_k", "mu_s", "v_s")
C, K, N, BELT, MU_K, MU_S, V_S = sympy.symbols(NAMES)


def automaton(flow, events=(), states=(X, V), coordinates=1, constraints=(), **values):
    mode = fl.Mode("only", tuple(map(sympy.sympify, flow)), tuple(events), tuple(constraints))
    return fl.HybridAutomaton(states, (mode,), {sympy.Symbol(n): x for n, x in values.items()}, coordinates)


def on_a_belt(**changes):
    """A unit mass on a belt, on a spring and a damper, with friction that falls with speed (Stribeck)."""
    values = dict(zip(NAMES, [0.3, 16.0, 2.0, 0.1, 0.3, 0.8, 0.25], strict=True)) | changes
    relative = BELT - V
    friction = (MU_K + (MU_S - MU_K) * sympy.exp(-relative / V_S)) * N
    slip = fl.Mode("slip", (V, friction - C * V - K * X), (fl.Event("v_r", relative, ("stick",)),))
    limit = MU_S * N
    stick = fl.Mode(
        "stick",
        (V, sympy.S.Zero),
        (fl.Event("+", limit - K * X - C * V, ("slip",)), fl.Event("-", limit + K * X + C * V, ("slip",))),
        (relative,),
    )
    return fl.HybridAutomaton((X, V), (stick, slip), {sympy.Symbol(n): v for n, v in values.items()}, 1)


def test_a_mass_on_a_belt():
    """Stick is tried first and rests nowhere, since its constraint is v = belt: slip has the equilibrium."""
    model = on_a_belt()
    (only,) = fl.equilibria(model)
    assert only.q[0] == pytest.approx((0.3 + 0.5 * np.exp(-0.1 / 0.25)) * 2.0 / 16.0, rel=1e-14)
    assert fl.equilibrium(model).q[0] == only.q[0]
    slope = -0.5 / 0.25 * np.exp(-0.1 / 0.25)  # mu'(v)
    values = np.roots([1, 0.3 + 2.0 * slope, 16.0])
    np.testing.assert_allclose(np.sort_complex(fl.eigenvalues(model).values), np.sort_complex(values))
    assert not fl.eigenvalues(model).stable


def test_stick_slip_ends_at_the_speed_where_the_damper_balances_friction():
    """c = -N mu'(v), so v = v_s ln(N (mu_s - mu_k)/(c v_s))."""
    critical = 0.25 * np.log(2.0 * 0.5 / (0.3 * 0.25))
    (change,) = fl.stability_changes(on_a_belt(), "belt", (0.01, 3))
    assert (change.kind, change.direction, change.unstable) == ("flutter", "regain", (1, 0))
    assert change.value == pytest.approx(critical, rel=1e-12)
    assert change.frequency == pytest.approx(4 / (2 * np.pi), rel=1e-9)
    assert fl.critical_value(on_a_belt(belt=0.5), "N", (0, 20)) == pytest.approx(0.3 * 0.25 / 0.5 * np.exp(2))
    curve = fl.critical_curve(on_a_belt(), "N", (0, 50), over=("belt", [0.05, 0.2, 0.8]))
    np.testing.assert_allclose(curve.values, 0.15 * np.exp(np.array([0.05, 0.2, 0.8]) / 0.25), rtol=1e-10)


@pytest.mark.parametrize(
    ("flow", "complete"),
    [((0,), False), ((0, 0), False), ((X**2,), True), ((-sympy.sign(X) * sympy.sqrt(abs(X)),), True)],
    ids=str,
)
def test_a_line_of_equilibria_where_the_state_matrix_is_zero_or_infinite(flow, complete):
    found = fl.equilibria(automaton(flow, states=(X, Y)[: len(flow)], coordinates=0))
    assert (len(found), found.complete) == (1, complete)


@pytest.mark.parametrize("name", ["z", "phase", "t"])
def test_a_further_state_with_the_name_of_a_clock(name):
    """A constraint gives it, and others give a coordinate and its velocity."""
    z = sympy.Symbol(name)
    flow = (V, W, -X - V, sympy.S.Zero, 1 - z)
    model = automaton(flow, states=(X, Y, V, W, z), coordinates=2, constraints=(Y, W, z - 1))
    given = states_by_constraints(model, model.modes[0])
    assert (sorted(given.dependent), given.remainder, given.distances) == ([1, 3, 4], (), (Y,))


def test_a_locus_of_a_mass_on_a_belt():
    speeds = np.linspace(3, 0.02, 200)
    locus = fl.root_locus(on_a_belt(), "belt", speeds)
    damping = 0.3 - 2.0 * 0.5 / 0.25 * np.exp(-speeds / 0.25)
    np.testing.assert_allclose(
        locus.values[:, 0], -damping / 2 + 1j * np.sqrt(16 - damping**2 / 4), rtol=1e-10
    )
    assert locus.coordinates == ("x",)
    np.testing.assert_allclose(locus.participation, 1)


@pytest.mark.slow
def test_the_slider_as_an_automaton():
    """Newton's method, guards and the stick mode's constraint against the polynomial of the model."""
    model = fl.SliderOnBelt(F=1000, l1=0.1, l2=0.3, mu_k=0.9)
    np.testing.assert_allclose(fl.equilibrium(model.automaton()).q, fl.equilibrium(model).q, rtol=1e-10)
    assert fl.equilibrium(model.automaton()).normal_force == pytest.approx(fl.equilibrium(model).normal_force)
    at = np.linspace(0, 2.9, 30)
    theirs, mine = fl.root_locus(model.automaton(), "mu_k", at), fl.root_locus(model, "mu_k", at)
    np.testing.assert_allclose(theirs.values, mine.values, rtol=1e-7)
    theirs, mine = (fl.stability_changes(m, "mu_k", (0, 2.9)) for m in (model.automaton(), model))
    assert [c.unstable for c in theirs] == [c.unstable for c in mine] == [(0, 1), (1, 2), (2, 1)]
    np.testing.assert_allclose([c.value for c in theirs], [c.value for c in mine], rtol=1e-10)


def test_first_order_systems():
    p = sympy.Symbol("p")
    cell = automaton([p * X - X**3], states=(X,), coordinates=0, p=-1.0)
    assert fl.eigenvalues(cell).values == pytest.approx([-1])
    (change,) = fl.stability_changes(cell, "p", (-1, 2))
    assert (change.kind, change.unstable, change.frequency) == ("divergence", (0, 1), 0.0)
    assert change.value == pytest.approx(0, abs=1e-15)
    locus = fl.root_locus(cell, "p", [-1.0, 0.5, 2.0])
    np.testing.assert_allclose(locus.values[:, 0], [-1.0, 0.5, 2.0], rtol=1e-12)
    lorenz = automaton(
        [10 * (Y - X), X * (p - W) - Y, X * Y - sympy.Rational(8, 3) * W],
        states=(X, Y, W),
        coordinates=0,
        p=10.0,
    )
    assert sorted(round(e.q[0], 9) for e in fl.equilibria(lorenz)) == [
        -round(24**0.5, 9),
        0,
        round(24**0.5, 9),
    ]
    assert fl.critical_value(lorenz, "p", (0.1, 30)) == pytest.approx(1.0, rel=1e-12)  # of the origin


@pytest.mark.slow  # that of test_hopf has the same closed form
def test_the_lorenz_attractors_hopf_point():
    """At the other equilibria: r = sigma (sigma + b + 3)/(sigma - b - 1)."""
    p = sympy.Symbol("p")
    flow = [10 * (Y - X), X * (p - W) - Y, X * Y - sympy.Rational(8, 3) * W]
    right = automaton(flow, [fl.Event("side", X - 1)], states=(X, Y, W), coordinates=0, p=10.0)
    b = 8 / 3
    (change,) = fl.stability_changes(right, "p", (2, 40))
    assert change.value == pytest.approx(10 * (10 + b + 3) / (10 - b - 1), rel=1e-12)
    assert change.frequency == pytest.approx(np.sqrt(b * (10 + change.value)) / (2 * np.pi), rel=1e-9)


def test_a_guard_excludes_an_equilibrium():
    """(x - 1)(2 - x) vanishes twice, but the mode lasts for x > 3/2 only."""
    wide = automaton([V, -C * V + (X - 1) * (2 - X)], c=0.1)
    assert [e.q[0] for e in fl.equilibria(wide)] == pytest.approx([1, 2])
    narrow = automaton([V, -C * V + (X - 1) * (2 - X)], [fl.Event("wall", X - 1.5)], c=0.1)
    assert [e.q[0] for e in fl.equilibria(narrow)] == pytest.approx([2])
    assert fl.eigenvalues(narrow).stable
    assert not fl.eigenvalues(wide).stable  # the nearer one


def test_a_guard_ends_a_locus():
    p = sympy.Symbol("p")
    model = automaton([V, p - X - C * V], [fl.Event("wall", 1 - X)], c=0.1, p=0.0)
    locus = fl.root_locus(model, "p", [0.0, 0.9, 1.1, 2.0, -5.0])
    np.testing.assert_array_equal(np.isnan(locus.values[:, 0]), [False, False, True, True, False])


def product(x, roots):
    return sympy.prod([x - sympy.Float(root) for root in roots])


FAR_APART = [
    (1e-3, 1.0, 1e3),
    (1e-6, 1.0, 1e6),
    (-1e6, 0.0, 1e-6),
    (1.0, 1.0 + 1e-6),
    (1.0, 1.0 + 1e-6, 1e6),
    tuple(10.0**k for k in range(-6, 7)),
]


@pytest.mark.parametrize("roots", FAR_APART)
def test_equilibria_far_apart_in_size_or_close_to_each_other(roots):
    first = automaton([product(X, roots)], states=(X,), coordinates=0)
    second = automaton([V, -C * V - product(X, roots)], c=0.1)
    for model in (first, second):
        found = sorted(e.q[0] for e in fl.equilibria(model))
        np.testing.assert_allclose(found, sorted(roots), rtol=1e-13)


def test_a_pair_of_equilibria_that_rounding_can_just_tell_apart():
    """Of x^2 - 2.000001 x + 1.000001 rounding leaves 1e-10 unknown: two equilibria, not a cloud of them."""
    roots = sympy.Rational(1), sympy.Rational(1000001, 1000000)
    model = automaton([sympy.expand((X - roots[0]) * (X - roots[1]))], states=(X,), coordinates=0)
    np.testing.assert_allclose(sorted(e.q[0] for e in fl.equilibria(model)), [1, 1.000001], atol=2e-9)


@pytest.mark.parametrize("skew", slow_but([0.5], [0.0, 0.5, 1.0]))
def test_equilibria_over_twelve_decades_in_several_coordinates(skew):
    """Every combination of the roots of two cubics in x + skew y and y - 2 skew x."""
    roots = (1e-6, 1.0, 1e6)
    flow = [V, W, -V - product(X + skew * Y, roots), -W - product(Y - 2 * skew * X, roots)]
    found = np.array([e.q for e in fl.equilibria(automaton(flow, states=(X, Y, V, W), coordinates=2))])
    pairs = np.array([(a, b) for a in roots for b in roots])
    expected = np.linalg.solve([[1, skew], [-2 * skew, 1]], pairs.T).T
    assert len(found) == len(expected)
    for point in expected:
        # States of 1e6 whose sum is 1e-6 are known to their own rounding.
        assert np.abs(found - point).max(axis=1).min() <= 1e-14 * np.abs(point).max()


def test_what_rounding_makes_vanish_far_out_is_no_equilibrium():
    """Of the Brusselator's one: at x = 1e-17, y = 1e32 the rates are small beside their slopes."""
    flow = [sympy.Rational(1, 2) - 2 * X + X**2 * Y, X - X**2 * Y]
    (only,) = fl.equilibria(automaton(flow, states=(X, Y), coordinates=0))
    np.testing.assert_allclose(only.q, [0.5, 2.0], rtol=1e-14)


def lorenz(rho):
    p = sympy.Symbol("rho")
    flow = [10 * (Y - X), X * (p - W) - Y, X * Y - sympy.Rational(8, 3) * W]
    return automaton(flow, states=(X, Y, W), coordinates=0, rho=rho)


@pytest.mark.slow  # one of them is in the next test, and in that of Hopf points
@pytest.mark.parametrize("rho", [0.5, 10.0, 20.0, 28.0])
@pytest.mark.parametrize("bounds", [(15, 30), (0.1, 100)])
def test_a_hopf_point_of_equilibria_that_are_not_the_nearest(rho, bounds):
    """Whether or not they exist at the model's own value, and at the lower bound."""
    point = fl.hopf(lorenz(rho), "rho", bounds)
    assert point.value == pytest.approx(470 / 19, rel=1e-12)
    side = np.sqrt(8 / 3 * (470 / 19 - 1))
    np.testing.assert_allclose(point.state, [side, side, 470 / 19 - 1], rtol=1e-11)


def test_equilibria_within_one_turn_of_angles_are_all():
    """A pendulum, and two on one axis that a spring of their difference couples."""
    hanging, upright = known = fl.equilibria(automaton((V, -sympy.sin(X) - V / 10)))
    assert known.complete
    assert [hanging.q[0], upright.q[0]] == [0.0, np.pi]
    pull = sympy.sin(X - Y) / 10
    coupled = automaton(
        (V, W, -sympy.sin(X) - pull, -sympy.sin(Y) + pull), states=(X, Y, V, W), coordinates=2
    )
    known = fl.equilibria(coupled)
    assert known.complete
    assert sorted(map(tuple, np.round(np.abs([one.q for one in known]) / np.pi).tolist())) == [
        (0.0, 0.0),
        (0.0, 1.0),
        (1.0, 0.0),
        (1.0, 1.0),
    ]


def test_a_hopf_point_in_a_mode_that_is_not_the_first():
    p = sympy.Symbol("p")
    left = fl.Mode("left", (V, -(X + 1) - V), (fl.Event("x", -X, ("right",)),))
    right = fl.Mode("right", (V, 2 - X + p * V - V**3), (fl.Event("x", X, ("left",)),))
    point = fl.hopf(fl.HybridAutomaton((X, V), (left, right), {p: -0.3}, 1), "p", (-1, 1))
    assert point.value == pytest.approx(0.0, abs=1e-12)
    assert point.state == pytest.approx([2.0, 0.0], abs=1e-12)


def test_the_changes_of_any_one_equilibrium():
    model = lorenz(20.0)
    origin, *others = fl.equilibria(model)
    assert fl.critical_value(model, "rho", (0.1, 30), equilibrium=origin) == pytest.approx(1, rel=1e-12)
    for other in others:
        (change,) = fl.stability_changes(model, "rho", (15, 30), equilibrium=other)
        assert change.value == pytest.approx(470 / 19, rel=1e-12)
        assert np.sign(fl.hopf(model, "rho", (15, 30), equilibrium=other).state[0]) == np.sign(other.q[0])
    with pytest.raises(ValueError, match="equilibrium must be one of the 3 of the model, got 'None here'"):
        fl.stability_changes(model, "rho", (15, 30), equilibrium="None here")
    slider = fl.SliderOnBelt()
    usual = fl.critical_value(slider, "mu_k", (0, 3), equilibrium=fl.equilibrium(slider))
    assert usual == pytest.approx(fl.critical_value(slider, "mu_k", (0, 3)), rel=1e-12)


NOWHERE = {
    "none at all": automaton([V, -C * V + 1 + X**2], c=0.1),
    "none, and the flow grows beyond floats": automaton([V, -C * V + 1 + sympy.exp(X)], c=0.1),
    "constant force": automaton([V, 1 - C * V], c=0.1),
    "outside the guard": automaton([V, -C * V - X], [fl.Event("wall", X - 1)], c=0.1),
    "against the constraint": automaton([V, sympy.S.Zero], constraints=(C - V,), c=0.1),
}


@pytest.mark.parametrize("model", NOWHERE.values(), ids=NOWHERE)
def test_no_equilibrium(model):
    assert fl.equilibria(model) == ()
    for ask in (
        fl.equilibrium,
        fl.eigenvalues,
        lambda m: fl.root_locus(m, "c", [0.1, 1]),
        lambda m: fl.critical_value(m, "c", (0, 1)),
    ):
        with pytest.raises(
            ValueError,
            match="an equilibrium inside its guards, got none in its only mode: change",
        ):
            ask(model)


ALONE = [(1, 1), (1e3, 1e9), (1e-8, 1), (1e-14, 1), (1e8, 1), (1e6, 1e20)]


@pytest.mark.parametrize(("a", "b", "other"), [(*ab, 0.0) for ab in ALONE] + [(*ab, 1e3) for ab in ALONE[:3]])
def test_all_three_branches_of_a_pitchfork(a, b, other):
    """In whatever units: sqrt(a/b) is 1e-7 to 1e4, or less than a millionth of another coordinate."""
    flow = [V, W, -C * V + a * X - b * X**3, -C * W - Y + other]
    found = sorted(e.q[0] for e in fl.equilibria(automaton(flow, states=(X, Y, V, W), coordinates=2, c=0.1)))
    root = np.sqrt(a / b)
    np.testing.assert_allclose(found, [-root, 0, root], rtol=1e-6, atol=1e-6 * root)


def test_a_branch_is_followed_to_its_fold_and_no_further():
    """p = x^2: from p = 1 down to 0, not beyond, whatever Newton's method hits upon there."""
    p = sympy.Symbol("p")
    model = automaton([p - X**2], [fl.Event("side", X + 0.0)], states=(X,), coordinates=0, p=1.0)
    at = np.linspace(4, -4, 81)
    locus = fl.root_locus(model, "p", at)
    np.testing.assert_array_equal(np.isnan(locus.values[:, 0]), at < 1e-9)
    np.testing.assert_allclose(locus.values[at > 1e-9, 0], -2 * np.sqrt(at[at > 1e-9]), rtol=1e-9)
    assert fl.stability_changes(model, "p", (-4, 4)) == ()
    near = 10.0 ** -np.arange(1, 15)
    np.testing.assert_allclose(fl.root_locus(model, "p", near).values[:, 0], -2 * np.sqrt(near), rtol=1e-9)


@pytest.mark.parametrize("own", [0.05, 0.1, 0.5])
def test_an_equilibrium_is_followed_past_others_that_newtons_method_would_reach(own):
    """p = 1 - cos(x - 1) has x = 1 - arccos(1 - p), and others a step of Newton's method away."""
    p = sympy.Symbol("p")
    model = automaton([p - 1 + sympy.cos(X - 1)], states=(X,), coordinates=0, p=own)
    at = np.linspace(0.01, 1.99, 100)
    locus = np.array([fl.root_locus(model, "p", [value]).values[0, 0] for value in at])
    np.testing.assert_allclose(locus, np.sin(np.arccos(1 - at)), rtol=1e-9)


def test_a_zero_row_and_a_rigid_body():
    """Nothing holds the second coordinate: two zero eigenvalues, and no equilibrium of its own."""
    model = linear([[4, 0], [0, 0]])
    np.testing.assert_allclose(np.abs(fl.eigenvalues(model).values), [0, 0, 2, 2], atol=1e-12)
    locus = fl.root_locus(linear([[4 + sympy.Symbol("p"), 0], [0, 0]]), "p", [0.0, 5.0])
    np.testing.assert_allclose(np.sort(locus.values.imag, axis=1), [[0, 2], [0, 3]], atol=1e-9)


@pytest.mark.parametrize("k", [400.0, 1e3, 1e4, 1e6])
def test_two_coupled_steep_exponentials(k):
    """1 - x = exp(k (y - 1)), 2 - y = exp(k (x - 1/2)), by iteration: both change little where they meet."""
    flow = (1 - X - sympy.exp(k * (V - 1)), 2 - V - sympy.exp(k * (X - 0.5)))
    x = y = 0.5
    for _ in range(20):
        x, y = 0.5 + np.log(2 - y) / k, 1 + np.log(1 - x) / k
    found = fl.equilibria(automaton(flow, states=(X, V), coordinates=0))
    assert [one.state.tolist() for one in found] == [pytest.approx([x, y], rel=1e-13)]


def test_where_a_law_underflows_one_state_stands_for_all_that_rest():
    """exp(-x^2) is 0 in double precision beyond 27.3 on either side; exp(-x) passes 1e-300 at 690.8."""
    flat, crossing, none = (
        fl.equilibria(automaton([rate], states=(X,), coordinates=0))
        for rate in (sympy.exp(-(X**2)), sympy.exp(-X) - 1e-300, sympy.exp(-X) + 1e-300)
    )
    assert sorted(np.sign(one.state[0]) for one in flat) == [-1, 1]
    assert all(abs(one.state[0]) > 27.3 for one in flat)
    assert not flat.complete
    assert [one.state[0] for one in crossing] == [pytest.approx(300 * np.log(10), rel=1e-14)]
    assert crossing.complete
    assert (len(none), none.complete) == (0, True)


def test_symbols_of_states_need_not_be_declared_real():
    """x'' = 1 - |x| - x' rests at 1 and -1."""
    found = fl.equilibria(automaton((V, 1 - abs(X) - V)))
    assert sorted(one.state[0] for one in found) == [-1.0, 1.0]


def test_where_none_exists_it_is_said_that_stick_is_left_out():
    assert repr(fl.equilibria(fl.MassOnBelt(v=0.0))) == "Equilibria(none exists without stick)"
    with pytest.raises(ValueError, match=r"none in .*stick has none that is a single point"):
        fl.equilibrium(fl.MassOnBelt(v=0.0))


@pytest.mark.parametrize("T", [1.0, 1e-9, 1e12])
def test_damped_states_rest_in_any_unit_of_time(T):
    """x'' = f - k x - c x' - h s, s' = (x - s)/tau: in some units k is 1e-11 of c."""
    flow = ("v", "f - k*x - c*v - h*w", "(x - w)/tau")
    values = {"f": 2.4 / T**2, "k": 1.0 / T**2, "c": 0.1 / T, "h": 0.2 / T**2, "tau": 0.5 * T}
    model = automaton(flow, states=(X, V, W), **values)
    assert fl.equilibrium(model).state.tolist() == pytest.approx([2.0, 0.0, 2.0], rel=1e-14)
    growth = fl.sensitivity(model, fl.GrowthRate())
    by_name = dict(zip(growth.parameters, growth.normalised, strict=True))
    rates = np.roots([0.5, 1.05, 0.6, 1.2])  # of (s^2 + 0.1 s + 1)(s/2 + 1) + 0.2, over c of its derivative
    s = rates[rates.real.argmax()]
    by_c = -s * (0.5 * s + 1) / (1.5 * s**2 + 2.1 * s + 0.6)
    assert by_name["c"] == pytest.approx(0.1 * by_c.real / s.real, rel=1e-9)


def test_a_velocity_at_rest_is_zero_and_no_rounding():
    """x'' = g w^2 - x - a x', w' = T - w^3 - w - b x': of velocities rounding errors were left."""
    flow, rng = ("v", "g*w**2 - x - a*v", "T - w**3 - w - b*v"), np.random.default_rng(0)
    for a, b, g, T in rng.uniform([0.5, -40, 0.1, 0.1], [60, 40, 3, 9], (40, 4)):
        model = automaton(flow, states=(X, V, W), a=a, b=b, g=g, T=T)
        (w,) = [w.real for w in np.roots([1, 0, 1, -T]) if abs(w.imag) < 1e-9]
        assert fl.equilibrium(model).state.tolist() == pytest.approx([g * w**2, 0.0, w], rel=1e-12, abs=0.0)
        place = fl.sensitivity(model, fl.EquilibriumCoordinate("x"))
        assert place.derivatives[place.parameters.index("g")] == pytest.approx(w**2, rel=1e-9)


cos, sin = fl.functions.cos, fl.functions.sin


@fl.model
class ShakenMass(fl.MechanicalModel):
    """A mass of 2 kg on a table that vibrates; a belt rubs on it, and a load grows."""

    F: float = 0.0
    A: float = 0.0
    rate: float = 0.0
    Omega: float = 3.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        table = fl.Stop(
            q.y - self.A * sin(q.phase),
            fl.PlasticImpact(),
            friction=self.friction,
            relative_velocity=1.0 - v.x,
        )
        loads = {"x": self.F * cos(q.phase) * q.x**2 + self.rate * q.t}
        energy = 20.0 * q.y + 5.0 * q.x**2 / 2
        frequency = self.Omega
        return fl.Mechanics(
            v.x**2 + v.y**2, energy, v.x**2 / 2, loads=loads, contacts=(table,), frequency=frequency
        )


@pytest.mark.parametrize("changes", [{}, {"Omega": 0.0}, {"A": 0.1, "Omega": 0.0}], ids=str)
def test_a_phase_that_moves_nothing_or_stands_leaves_the_equilibrium(changes):
    model = ShakenMass(**changes)
    (only,) = fl.equilibria(model)
    assert (*only.q, only.normal_force) == pytest.approx((0.3 * 20.0 / 5.0, 0.0, 20.0), abs=1e-14)
    expected = np.roots([2.0, 1.0, 5.0])
    np.testing.assert_allclose(fl.eigenvalues(model).values, expected[[1, 0]], rtol=1e-14)


@pytest.mark.parametrize("name", ["F", "A", "rate"])
def test_what_depends_on_a_phase_or_a_time_has_no_equilibrium(name):
    values = [getattr(ShakenMass(), name), 2.0]
    known = np.isfinite(fl.root_locus(ShakenMass(), name, values).values).all(axis=1)
    assert known.tolist() == [True, False]
    with pytest.raises(ValueError, match=r"phase never rests|depend on the time"):
        fl.equilibrium(ShakenMass(**{name: 2.0}))
