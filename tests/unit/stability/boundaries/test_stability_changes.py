"""Every loss and regain of stability: closed forms, windows narrower than any grid, and brute force."""

from __future__ import annotations

import warnings
from itertools import product

import numpy as np
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictionlab as fl
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from tests.helpers.cases import slow_but
from tests.helpers.linear_automata import P, linear

pytestmark = pytest.mark.blas

S = fl.SliderOnBelt
UNDAMPED = dict.fromkeys(["c1", "c2", "c4", "c5", "c6"], 0.0)


def kinds(changes):
    """What happens, in order."""
    return [(c.kind, c.direction, c.unstable) for c in changes]


@pytest.mark.parametrize("damping", [0.0, 1e-6, 0.4])
def test_hoffmanns_mode_coupling(damping):
    """Two degrees of freedom, Hoffmann et al. (2002): critical friction and its frequency."""
    k11, k22, k12, k3 = 7.0, 6.0, 0.8, 2.0
    model = linear([[k11, k12 - P * k3], [k12, k22]], damping)
    # lambda^2 + c lambda + k +- i s = 0 has a root i omega where omega^2 = k and c omega = s.
    mean = (k11 + k22) / 2
    critical = (k12**2 + (k11 - k22) ** 2 / 4 + damping**2 * mean) / (k12 * k3)
    (change,) = fl.stability_changes(model, "p", (0, 1.7))
    assert kinds([change]) == [("flutter", "loss", (0, 1))]
    assert change.value == pytest.approx(critical, rel=1e-12)
    assert change.frequency == pytest.approx(np.sqrt(mean) / (2 * np.pi), rel=1e-8)
    assert fl.critical_value(model, "p", (0, 1.7)) == change.value


@pytest.mark.slow
@settings(max_examples=30)
@given(
    place=st.floats(0.05, 0.95),
    width=st.floats(-7, -2).map(lambda e: 10.0**e),
    slope=st.floats(0.01, 0.9),
    damped=st.sampled_from([0.0, 0.1, 0.9]),
    scale=st.floats(-1, 5).map(lambda e: 10.0**e),
)
def test_no_window_of_flutter_is_too_narrow(place, width, slope, damped, scale):
    """Modes that cross, coupled so weakly that they are unstable for a 1e-7th of the range, off any grid."""
    coupling = width * slope * scale / np.sqrt(1 - damped**2)
    apart = slope * scale * (P - place)
    matrix = [[scale + apart, coupling], [-coupling, scale - apart]]
    changes = fl.stability_changes(linear(matrix, damped * coupling / np.sqrt(scale)), "p", (0, 1))
    assert kinds(changes) == [("flutter", "loss", (0, 1)), ("flutter", "regain", (1, 0))]
    # Close to the coalescence eigenvalues have half of the digits, and so has a share of the width.
    np.testing.assert_allclose(
        [c.value for c in changes], [place - width, place + width], atol=1e-12 + 1e-4 * width
    )
    for change in changes:
        assert change.frequency == pytest.approx(np.sqrt(scale) / (2 * np.pi), rel=1e-6)


def test_two_losses_close_together():
    """Negative damping sets in at 0.3 and a millionth later, in two uncoupled oscillators."""
    model = linear(sympy.diag(4, 9), sympy.diag(0.3 - P, 0.3 + 1e-6 - P))
    changes = fl.stability_changes(model, "p", (0, 1))
    assert kinds(changes) == [("flutter", "loss", (0, 1)), ("flutter", "loss", (1, 2))]
    np.testing.assert_allclose([c.value for c in changes], [0.3, 0.3 + 1e-6], rtol=1e-12)
    np.testing.assert_allclose([c.frequency for c in changes], [1 / np.pi, 1.5 / np.pi], rtol=1e-9)


def test_two_losses_at_once():
    (change,) = fl.stability_changes(
        linear(sympy.diag(4, 9), 0.3 * sympy.eye(2) - P * sympy.eye(2)), "p", (0, 1)
    )
    assert kinds([change]) == [("flutter", "loss", (0, 2))]
    assert change.value == pytest.approx(0.3, rel=1e-9)


@pytest.mark.parametrize("gap", [0.5, 1e-2, 1e-3, 1e-4])
def test_loss_and_regain(gap):
    """Damping (p - a)(p - b), negative between."""
    a = 0.412345
    b = a + gap
    changes = fl.stability_changes(linear([[4]], [[(P - a) * (P - b)]]), "p", (0, 1))
    assert kinds(changes) == [("flutter", "loss", (0, 1)), ("flutter", "regain", (1, 0))]
    np.testing.assert_allclose([c.value for c in changes], [a, b], rtol=1e-9)


# on a point of the scan, and off all of them; with damping of which modes creep, or swing
TOUCHES = [*product((0.5, 0.4123), (2, 4), (1, -1), (0.3, 5.0))]


@pytest.mark.parametrize(("place", "power", "sign", "damping"), slow_but(TOUCHES[::7], TOUCHES, several=True))
def test_a_growth_rate_that_touches_zero_changes_nothing(place, power, sign, damping):
    """The growth rate is -+(p - a)^n/2, and for the stiffness the root of it; another mode is lost at 0.8."""
    touch = sign * (P - place) ** power
    for model, kind in (
        (linear(sympy.diag(4, 9), sympy.diag(touch, 0.8 - P)), "flutter"),
        (linear(sympy.diag(touch, 0.8 - P), damping), "divergence"),
    ):
        below = 0 if sign > 0 else 1
        changes = fl.stability_changes(model, "p", (0, 1))
        assert kinds(changes) == [(kind, "loss", (below, below + 1 if kind == "flutter" or not below else 1))]
        assert changes[0].value == pytest.approx(0.8, rel=1e-9)


def test_a_stable_window_that_is_narrow_is_one_all_the_same():
    """-(p - a)^2 + w^2 is positive for 2 w."""
    model = linear([[4]], [[1e-8 - (P - 0.4123) ** 2]])
    changes = fl.stability_changes(model, "p", (0, 1))
    assert kinds(changes) == [("flutter", "regain", (1, 0)), ("flutter", "loss", (0, 1))]
    np.testing.assert_allclose([c.value for c in changes], [0.4122, 0.4124], rtol=1e-9)


def test_what_is_unstable_at_the_lower_bound_becomes_stable_at_the_critical_value():
    regain, back = linear([[4]], [[P - 0.3]]), linear([[4]], [[(P - 0.3) * (0.7 - P)]])
    assert fl.critical_value(regain, "p", (0, 1)) == pytest.approx(0.3, rel=1e-12)
    with pytest.warns(RuntimeWarning, match=r"unstable from p = 0 on, in all of the range: "):
        assert fl.critical_value(regain, "p", (0, 0.2)) is None
    with pytest.raises(ValueError, match=r"got neither, as the .* in all of the range: widen them"):
        fl.CriticalValue("p", (0, 0.2)).gradient(regain)
    assert fl.CriticalValue("p", (0, 1)).gradient(regain).value == pytest.approx(0.3, rel=1e-12)
    assert fl.critical_value(back, "p", (0, 1)) == pytest.approx(0.3, rel=1e-12)
    assert fl.critical_value(back, "p", (0.4, 1)) == pytest.approx(0.7, rel=1e-12)
    assert fl.critical_value(back, "p", (0.4, 0.6)) is None  # stable all along: nothing to warn of


@pytest.mark.parametrize("damping", slow_but([0.0, 1e-3, 30.0], [0.0, 1e-9, 1e-3, 0.2, 30.0]))
def test_divergence_and_flutter_in_one_range(damping):
    """One stiffness becomes negative at 0.6; two other modes couple, from 0.3 on without damping."""
    pair = sympy.Matrix([[5, 0.3 - P], [0.3, 5]])
    model = linear(sympy.diag(0.6 - P, pair), sympy.diag(damping, damping, damping))
    changes = fl.stability_changes(model, "p", (0, 1))
    expected = {0.3 + damping**2 * 5 / 0.3: "flutter", 0.6: "divergence"}
    values = sorted(value for value in expected if value < 1)
    assert [c.kind for c in changes] == [expected[value] for value in values]
    np.testing.assert_allclose([c.value for c in changes], values, rtol=1e-9)
    assert [c.frequency for c in changes if c.kind == "divergence"] == [0.0]
    assert fl.critical_value(model, "p", (0, 1)) == changes[0].value


def test_divergence_at_zero_is_quick():
    """A root at zero has no relative precision to wait for."""
    (change,) = fl.stability_changes(linear([[-P]], 0.1), "p", (-1, 1))
    assert kinds([change]) == [("divergence", "loss", (0, 1))]
    assert abs(change.value) < 1e-15


@pytest.mark.parametrize("scene", slow_but([{}], [{}, {"F": 1000.0, "l1": 0.1, "l2": 0.3}]))
def test_without_damping_changes_are_where_modes_coalesce(scene):
    """Discriminant of the characteristic polynomial in omega^2, by the signs of its real roots."""
    model = S(**UNDAMPED, **scene)
    changes = fl.stability_changes(model, "mu_k", (0, 3))
    assert changes
    for change in changes:
        low, high = change.value - 1e-7, change.value + 1e-7
        at = np.array([low, high])
        _, matrices = equilibrium_problem(model).linearised({"mu_k": at})
        squares = np.linalg.eigvals(-matrices[:, 5:, :5])
        pairs = (np.abs(squares.imag) > 1e-9 * np.abs(squares).max()).sum(axis=1) // 2
        assert tuple(pairs) == change.unstable
        side = squares[0 if change.direction == "regain" else 1]
        meeting = np.sqrt(side[np.abs(side.imag) > 1e-9 * np.abs(side).max()].real) / (2 * np.pi)
        assert np.abs(meeting - change.frequency).min() < 1e-5 * change.frequency


@pytest.mark.parametrize("share", slow_but([1.0, 64.0, 1 + 1e-9], [1.0, 2.0, 4.0, 64.0, 1 + 1e-10, 1 + 1e-9]))
def test_a_root_on_a_point_of_the_scan_is_exact_too(share):
    """The bounds are chosen so that the scan hits the critical value, or nearly so."""
    model = linear([[7.0, 0.8 - 2 * P], [0.8, 6.0]], 0.4)
    critical = (0.8**2 + 0.25 + 0.4**2 * 6.5) / 1.6
    for bounds in ((0, 2 * critical * share), (critical * (1 - share / 100), critical * (1 + share / 100))):
        assert fl.critical_value(model, "p", bounds) == pytest.approx(critical, rel=1e-12)


BRUTE = {
    "mu_k": (0, 3),
    "F": (1, 2000),
    "k_nl": (0, 1e8),
    "k4": (1e3, 1e5),
    "l1": (0.01, 0.5),
    "M": (0.1, 5),
    "c1": (0, 20),
}


@pytest.mark.slow
@settings(max_examples=40)
@given(
    name=st.sampled_from(sorted(BRUTE)),
    stiffness=st.lists(st.floats(3, 5).map(lambda e: 10.0**e), min_size=6, max_size=6),
    mu_k=st.floats(0, 2.5),
    k_nl=st.sampled_from([0.0, 1e4, 1e7]),
    F=st.floats(0, 3.5).map(lambda e: 10.0**e),
    v=st.sampled_from([-1.0, 1.0]),
    damping=st.sampled_from([0.0, 0.1, 5.0]),
    toggles=st.sampled_from([(), ("geometry",)]),
)
def test_brute_force(name, stiffness, mu_k, k_nl, F, v, damping, toggles):
    """The number of growing pairs on 2000 points is that which the changes tell."""
    springs = dict(zip(["k1", "k2", "k3", "k4", "k5", "k6"], stiffness, strict=True))
    dampers = dict.fromkeys(UNDAMPED, damping)
    model = S(mu_k=mu_k, mu_s=4.0, k_nl=k_nl, F=F, v=v, **springs, **dampers).without(*toggles)
    bounds = BRUTE[name] if name in model.parameters else BRUTE["mu_k"]
    name = name if name in model.parameters else "mu_k"
    changes = fl.stability_changes(model, name, bounds)
    at = np.linspace(*bounds, 2001)
    spectra = equilibrium_problem(model).spectra({name: at})
    size = np.abs(spectra).max(axis=1, keepdims=True)
    counted = ((spectra.real > 1e-9 * size).sum(axis=1) + 1) // 2
    # Not where a growth rate is about zero, or an equilibrium is missing next to a change.
    values = np.array([c.value for c in changes])
    near = np.abs(at[:, None] - values).min(axis=1, initial=np.inf) < 1e-6 * (bounds[1] - bounds[0])
    sure = ~near & ~((np.abs(spectra.real) < 1e-8 * size) & (np.abs(spectra.real) > 1e-12 * size)).any(axis=1)
    compared = 0
    for i, (start, end) in enumerate(zip([-np.inf, *values], [*values, np.inf])):
        between = (at > start) & (at < end)
        if np.isfinite(spectra[between]).all():
            told = {c.unstable[1] for c in changes[i - 1 : i]} | {c.unstable[0] for c in changes[i : i + 1]}
            assert len(told | set(counted[between & sure].tolist())) <= 1
            compared += (between & sure).any()
    assume(
        compared > 0
    )  # else growth rates are small everywhere: an example that tells nothing is not counted


def test_an_equilibrium_that_gives_way_to_another_is_a_fold():
    """Where two equilibria with a smaller gap appear, or vanish: counted, by bisection."""
    model = S(mu_k=1.5, F=3000, k4=2e4, k5=2e3, k6=2e3, l1=0.05, l2=0.05)
    low, high = 2000.0, 3000.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if len(fl.equilibria(model.replace(F=middle))) == 1 else (low, middle)
    folds = [c for c in fl.stability_changes(model, "F", (100, 6000)) if c.kind == "fold"]
    assert kinds(folds) == [("fold", "loss", (0, 2))]
    assert folds[0].frequency == 0
    assert folds[0].value == pytest.approx(low, rel=1e-8)


@pytest.mark.parametrize("bounds", slow_but([(10, 200)], [(10, 200), (20, 400), (5, 1000), (90, 100)]))
@pytest.mark.parametrize(
    ("a1", "a2"),
    [
        (5e3, -1.5e5),
        *(pytest.param(*a, marks=pytest.mark.slow) for a in ((5e3, -1e5), (8e3, -2e5), (5e3, -1.4e5))),
    ],
)
def test_where_an_equilibrium_ends_and_none_takes_over_nothing_changes(a1, a2, bounds):
    """A contact that softens bears no more than some force; how near to it the scan looks is chance."""
    model = S(contact=fl.PolynomialContact(a1=a1, a2=a2))
    fold = fl.FoldValue("F", (10, 200))(model)
    assert not fl.equilibria(model.replace(F=1.01 * fold))
    assert fl.stability_changes(model, "F", bounds) == ()


@pytest.mark.slow
def test_reversing_the_belt_is_a_fold_too():
    """At v = 0 friction jumps from one side to the other, and there is no steady sliding."""
    (change,) = fl.stability_changes(S(mu_k=2.0), "v", (-1, 2))
    assert change.kind == "fold"
    assert abs(change.value) < 1e-8
    (change,) = fl.stability_changes(S(mu_k=2.0), "v", (-1, 1))  # which has v = 0 in the middle
    assert change.kind == "fold"
    assert abs(change.value) < 1e-8


def test_an_equilibrium_that_the_models_own_value_lacks_is_found_in_the_range():
    """x = p is inside the guard for p > 0; its growth rate is (p - c)/2, its frequency 1/(2 pi)."""
    x, v, p, c = sympy.symbols("x v p c")
    mode = fl.Mode("on", (v, p - x - (c - x) * v), (fl.Event("gap", x, ()),))
    model = fl.HybridAutomaton((x, v), (mode,), {p: -1.0, c: 1.0}, 1)
    (change,) = fl.stability_changes(model, "p", (-3.0, 5.0))
    assert (change.value, change.frequency) == pytest.approx((1.0, 0.5 / np.pi))
    found = fl.hopf(model, "p", (-3.0, 5.0)).value, fl.CriticalValue("p", (-3.0, 5.0))(model)
    assert (*found, fl.critical_value(model, "p", (-3.0, 5.0))) == pytest.approx((1.0,) * 3)
    assert fl.critical_curve(model, "p", (-3, 5), over=("c", [1.0, 2.0])).values == pytest.approx([1.0, 2.0])
    rates = fl.root_locus(model, "p", [-1.0, 1.0, 2.0]).growth_rates[:, 0]
    assert rates == pytest.approx([np.nan, 0.0, 0.5], abs=1e-12, nan_ok=True)
    plane = fl.stability_map(model, ("p", np.linspace(-1, 5, 7)), ("c", [0.5, 1.5]), progress=False)
    assert np.ptp(plane.boundary[0].points, axis=1) == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(ValueError, match="must have a mode with an equilibrium"):
        fl.critical_value(model, "p", (-3.0, -2.0))


@pytest.mark.parametrize(
    ("at", "own"), [(0, -0.8), (0.3, -0.8), (1, -0.8), (1, -0.9), (0, 0), (1 / 3, 0), (9, 0)]
)
def test_an_equilibrium_that_begins_at_a_fold_is_followed_from_beyond(at, own):
    """(x - at)^2 = p begins at p = 0, a round share of the range, or the model's own value; the growth rate
    of the upper one is (p - c)/2."""
    x, v, p, c = sympy.symbols("x v p c")
    mode = fl.Mode("on", (v, p - (x - at) ** 2 - (c - p) * v), (fl.Event("gap", x - at + 0.25, ()),))
    model = fl.HybridAutomaton((x, v), (mode,), {p: own, c: 1.5}, 1)
    found = [change.value for high in (3.0, 2.9) for change in fl.stability_changes(model, "p", (-1.0, high))]
    assert found == pytest.approx([1.5, 1.5], rel=1e-12)
    assert fl.critical_value(model, "p", (-1.0, 3.0)) == pytest.approx(1.5, rel=1e-12)
    axes = ("p", np.linspace(-1, 3, 9)), ("c", [1.0, 2.0])
    one, other = (fl.stability_map(m, *axes, progress=False) for m in (model, model.replace(p=1.0)))
    np.testing.assert_allclose(one.growth, other.growth, atol=1e-12)


def test_where_an_equilibrium_begins_nothing_changes():
    """Unstable from its first moment (F = 0) on, or stable: neither is a change."""
    assert fl.stability_changes(S(mu_k=2.5), "F", (-100, 300)) == ()
    assert fl.stability_changes(S(mu_k=0.5), "F", (-100, 300)) == ()
    (change,) = fl.stability_changes(S(mu_k=2.5), "k4", (0, 1e4))  # no springs at all at 0
    assert np.isfinite(change.value)


@pytest.mark.parametrize(
    ("model", "over"),
    [
        pytest.param(S(), ("F", np.linspace(-50, 1000, 8)), marks=pytest.mark.slow),
        pytest.param(S(F=1000, l1=0.1, l2=0.3), ("l1", [0.05, 0.1, 0.2, 0.4]), marks=pytest.mark.slow),
        pytest.param(S(), ("k3", [0.0, 1e3, 6e3]), marks=pytest.mark.slow),
        pytest.param(S(**UNDAMPED), ("k_nl", [0.0, 1e4, 1e7]), marks=pytest.mark.slow),
        (
            linear([[7.0, sympy.Symbol("k") - 2 * P], [sympy.Symbol("k"), 6.0]], 0.1, k=0.8),
            ("k", [0.2, 0.8, 3.0]),
        ),
    ],
)
def test_a_curve_is_its_points_one_by_one(model, over):
    parameter = "mu_k" if isinstance(model, S) else "p"
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        curve = fl.critical_curve(model, parameter, (0, 3), over=over)
    assert len(told) == int(np.isnan(curve.values).any())
    np.testing.assert_array_equal(curve.at, over[1])
    for at, value in zip(curve.at, curve.values, strict=True):
        if isinstance(model, S):
            single = model.replace(**{over[0]: at})
        else:
            numbers = {s: at if s.name == over[0] else v for s, v in model.parameters.items()}
            single = fl.HybridAutomaton(model.states, model.modes, numbers, model.coordinates)
        one = fl.critical_value(single, parameter, (0, 3))
        assert (one is None and np.isnan(value)) or value == pytest.approx(one, rel=1e-10)


def test_a_curve_says_why_it_has_gaps():
    """x'' = -(c - p) x' + 10 - c - x^2: flutter at p = c, about x = sqrt(10 - c), which ends at c = 10."""
    x, v, c = sympy.symbols("x v c")
    mode = fl.Mode("only", (v, -(c - P) * v + 10 - c - x**2))
    model = fl.HybridAutomaton((x, v), (mode,), {P: 0.0, c: 1.0}, 1)
    with pytest.warns(RuntimeWarning) as told:
        curve = fl.critical_curve(model, "p", (0, 3), over=("c", [-1.0, 1.0, 2.5, 4.0, 5.0, 20.0]))
    assert curve.values == pytest.approx([np.nan, 1.0, 2.5, np.nan, np.nan, np.nan], rel=1e-9, nan_ok=True)
    assert [str(warning.message) for warning in told] == [
        "no critical p in 0 to 3 at 4 of 6 values of c: 1 without an equilibrium at p = 0, 1 unstable from "
        "p = 0 on, 2 stable up to 3, or as far as the equilibrium exists; they are NaN"
    ]


MANY = 5_000  # eigenvalue problems

SAME = sympy.Matrix([[5 + P]])
HARD = [
    linear([[1 + P, 0.05], [-0.05, 2 - P]]),
    linear(sympy.diag(*[sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]])] * 2)),  # every mode twice
    linear(sympy.diag(sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]]), SAME, SAME)),  # twins elsewhere
    linear(sympy.diag(sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]]), SAME, SAME), 1e-6),
    # a mode of 1e-5 1/s beside one of 1e7 1/s
    linear(sympy.diag(sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]]), 1e14, 1e-10), 1e-9),
]


@pytest.fixture
def problems(monkeypatch):
    """How many eigenvalue problems each call of numpy has solved."""
    solve, counted = np.linalg.eigvals, []

    def eigvals(matrices):
        counted.append(int(np.prod(np.shape(matrices)[:-2])))
        return solve(matrices)

    monkeypatch.setattr(np.linalg, "eigvals", eigvals)
    return counted


@pytest.mark.parametrize("model", slow_but(HARD[::3], HARD))
def test_degenerate_and_stiff_systems_are_quick(model, problems):
    """Flutter between 0.45 and 0.55, whatever else there is."""
    changes = fl.stability_changes(model, "p", (0, 1))
    assert [(c.kind, c.direction) for c in changes] == [("flutter", "loss"), ("flutter", "regain")]
    np.testing.assert_allclose([c.value for c in changes], [0.45, 0.55], atol=1e-4)
    assert sum(problems) < MANY


EXTREME = [
    UNDAMPED,
    dict.fromkeys(UNDAMPED, 1e-12),
    {"c1": 1e6},
    {"k4": 1e12, "k5": 1e12, "k6": 1e12},
    {"k1": 1e15},
    {"k_nl": 1e20},
    {"M": 1e-6, "m": 1e-6, "J": 1e-7},
    {"M": 1e6, "m": 1e6, "J": 1e5},
    {"F": 1e-9},
    {"F": 1e9},
    {"l1": 1e-9, "l2": 1e-9},
]


@pytest.mark.parametrize("values", slow_but([EXTREME[i] for i in (5,)], EXTREME))
def test_extreme_scenes_are_quick(values, problems):
    model = S(**values)
    changes = fl.stability_changes(model, "mu_k", (0, 4))
    locus = fl.root_locus(model, "mu_k", np.linspace(0, 4, 500))
    assert np.isfinite([c.value for c in changes]).all()
    for c in changes:
        i = np.searchsorted(locus.at, c.value)
        assert locus.unstable[i - 1] in c.unstable
    assert sum(problems) < MANY
