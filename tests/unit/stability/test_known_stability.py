"""Losses of stability with closed forms, on automata of one's own; and equilibria of such."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl

pytestmark = pytest.mark.blas


def automaton(rates, *, n, events=(), **parameters):
    """x'' = rates(x, v, parameters) for n coordinates x1 ... xn."""
    x, v = (sp.symbols(f"{name}1:{n + 1}", real=True) for name in "xv")
    symbols = {name: sp.Symbol(name, real=True) for name in parameters}
    mode = fl.Mode("slip", (*v, *rates(x, v, **symbols)), tuple(e(x, v) for e in events))
    return fl.HybridAutomaton((*x, *v), (mode,), {symbols[k]: p for k, p in parameters.items()}, n)


def hoffmann(c=0.0, **values):
    """Mode coupling: m = 1, friction makes the stiffness matrix unsymmetric."""

    def rates(x, v, mu, k11, k12, k22, k3):
        return -k11 * x[0] - (k12 - mu * k3) * x[1] - c * v[0], -k12 * x[0] - k22 * x[1] - c * v[1]

    return automaton(rates, n=2, **({"mu": 0.1, "k11": 5.0, "k12": 1.0, "k22": 4.0, "k3": 2.0} | values))


@pytest.mark.parametrize("k22", [3.0, 4.0, 4.9])
def test_hoffmanns_mode_coupling(k22):
    # Two squared frequencies meet where (k11 - k22)^2/4 + k12 (k12 - mu k3) = 0.
    (change,) = fl.stability_changes(hoffmann(k22=k22), "mu", (0, 2))
    assert change.value == pytest.approx((1 + ((5 - k22) / 2) ** 2) / 2, rel=1e-12)
    assert change.frequency == pytest.approx(np.sqrt((5 + k22) / 2) / (2 * np.pi), rel=1e-6)
    assert (change.kind, change.direction, change.unstable) == ("flutter", "loss", (0, 1))


def test_equal_damping_only_shifts_the_growth_rates():
    locus = fl.root_locus(hoffmann(c=0.2), "mu", np.linspace(0, 2, 50))
    bare = fl.root_locus(hoffmann(), "mu", np.linspace(0, 2, 50))
    # l (l + c) takes the place of l^2; of a pair that has coalesced both are there.
    squares, expected = locus.values * (locus.values + 0.2), bare.values**2
    np.testing.assert_allclose(np.sort(squares.real, axis=1), np.sort(expected.real, axis=1), atol=1e-9)
    np.testing.assert_allclose(np.abs(squares.imag), np.abs(expected.imag), atol=1e-7)


@pytest.mark.parametrize("coupling", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("place", [0.3721, 1 / np.pi, 0.5])
def test_a_window_as_narrow_as_the_coupling_is_weak(coupling, place):
    """Frequencies cross at `place`; an antisymmetric coupling e makes them lock where |k1 - k2| < 2e."""

    def rates(x, v, p, e):
        return -(1 + p - place) * x[0] - e * x[1], -(1 - (p - place)) * x[1] + e * x[0]

    changes = fl.stability_changes(automaton(rates, n=2, p=0.1, e=coupling), "p", (0.0, 1.0))
    assert [c.direction for c in changes] == ["loss", "regain"]
    assert [c.value for c in changes] == pytest.approx([place - coupling, place + coupling], abs=1e-11)
    assert {c.kind for c in changes} == {"flutter"}


def test_two_losses_a_millionth_apart():
    def rates(x, v, p):
        return -x[0] - (0.3 - p) * v[0], -4 * x[1] - (0.300001 - p) * v[1]

    first, second = fl.stability_changes(automaton(rates, n=2, p=0.0), "p", (0, 1))
    assert (first.value, second.value) == pytest.approx((0.3, 0.300001), abs=1e-12)
    assert (first.unstable, second.unstable) == ((0, 1), (1, 2))
    assert (first.frequency, second.frequency) == pytest.approx((1 / (2 * np.pi), 2 / (2 * np.pi)))


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_divergence(damping):
    found = fl.stability_changes(
        automaton(lambda x, v, p: (-(1 - p**2) * x[0] - damping * v[0],), n=1, p=0.0), "p", (-2, 2)
    )
    assert [(c.kind, c.direction) for c in found] == [("divergence", "regain"), ("divergence", "loss")]
    assert [c.value for c in found] == pytest.approx([-1, 1], abs=1e-12)
    assert all(c.frequency == 0 for c in found)


def test_falling_friction():
    """A mass on a belt loses stability where c + N mu'(v) = 0: here N (mu_s - mu_k)/v_s exp(-v/v_s) = c."""
    c, N, mu_s, mu_k, scale = 0.1, 10.0, 0.6, 0.2, 0.5

    def rates(x, v, speed):
        slip = speed - v[0]
        return (-x[0] - c * v[0] + N * (mu_k + (mu_s - mu_k) * sp.exp(-slip / scale)),)

    model = automaton(rates, n=1, events=[lambda x, v: _slipping(v[0])], speed=3.0)
    critical = scale * np.log(N * (mu_s - mu_k) / (c * scale))
    (change,) = fl.stability_changes(model, "speed", (0.5, 4))
    assert (change.direction, change.kind) == ("regain", "flutter")  # the faster the belt, the more stable
    assert change.value == pytest.approx(critical, rel=1e-12)
    at_rest = fl.equilibrium(model)
    assert at_rest.q[0] == pytest.approx(N * (mu_k + (mu_s - mu_k) * np.exp(-3 / scale)), rel=1e-12)
    assert at_rest.residual < 1e-12


def _slipping(v):
    return fl.Event("v_r", sp.Symbol("speed", real=True) - v)


def test_two_modes_of_one_frequency_throughout():
    twin = automaton(lambda x, v, p: tuple(-p * x[i] - 0.1 * v[i] for i in range(2)), n=2, p=1.0)
    assert fl.stability_changes(twin, "p", (0.5, 2)) == ()
    locus = fl.root_locus(twin, "p", np.linspace(0.5, 2, 7))
    np.testing.assert_allclose(
        np.abs(locus.values) ** 2, np.linspace(0.5, 2, 7)[:, None] * [1, 1], rtol=1e-12
    )


def test_a_veering_has_no_jumps_on_any_grid():
    """Squared frequencies (p ± sqrt((p - 1)^2 ...)): two oscillators coupled by e never cross."""
    e = 1e-4

    def rates(x, v, p):
        return -p * x[0] + e * x[1], -x[1] + e * x[0]

    for count in (4, 11, 300):
        values = np.linspace(0.5, 1.6, count)
        locus = fl.root_locus(automaton(rates, n=2, p=0.5), "p", values)
        half, root = (values + 1) / 2, np.sqrt(((values - 1) / 2) ** 2 + e**2)
        np.testing.assert_allclose(np.abs(locus.values) ** 2, np.stack([half - root, half + root], axis=1))


def test_a_mode_that_becomes_overdamped_goes_on_as_its_slower_part():
    values = np.linspace(0.5, 4, 15)
    locus = fl.root_locus(automaton(lambda x, v, c: (-x[0] - c * v[0],), n=1, c=0.1), "c", values)
    expected = -values / 2 + np.sqrt((values / 2 + 0j) ** 2 - 1)
    np.testing.assert_allclose(locus.values[:, 0], expected, atol=1e-12)


def test_all_three_equilibria_of_a_double_well():
    model = automaton(lambda x, v, a: (a * x[0] - x[0] ** 3 - 0.1 * v[0],), n=1, a=4.0)
    found = fl.equilibria(model)
    assert sorted(float(e.q[0]) for e in found) == pytest.approx([-2, 0, 2], abs=1e-12)
    assert fl.equilibrium(model).q[0] == pytest.approx(0, abs=1e-12)


def test_an_equilibrium_beyond_a_guard_is_none():
    def rates(x, v, a):
        return (a - x[0] - v[0],)

    inside = automaton(rates, n=1, events=[lambda x, v: fl.Event("wall", 1 - x[0])], a=0.5)
    assert fl.equilibrium(inside).q[0] == pytest.approx(0.5)
    with pytest.raises(ValueError, match="must have a mode with an equilibrium inside its guards, got none"):
        fl.equilibrium(inside.replace(a=2.0))
    locus = fl.root_locus(inside, "a", [0.0, 0.9, 1.1])
    np.testing.assert_array_equal(np.isnan(locus.values[:, 0]), [False, False, True])


def test_a_first_order_system():
    x = sp.Symbol("x", real=True)
    p = sp.Symbol("p", real=True)
    model = fl.HybridAutomaton((x,), (fl.Mode("only", (p * x - x**3,)),), {p: -1.0})
    assert fl.eigenvalues(model).values == pytest.approx([-1])
    (change,) = fl.stability_changes(model, "p", (-1, 2))
    assert (change.value, change.kind) == (pytest.approx(0, abs=1e-12), "divergence")


def test_the_models_own_automaton_gives_the_models_values():
    model = fl.SliderOnBelt(mu_k=1.4)
    np.testing.assert_allclose(fl.equilibrium(model.automaton()).q, fl.equilibrium(model).q, rtol=1e-12)
    assert fl.critical_value(model.automaton(), "mu_k", (0, 3)) == pytest.approx(
        fl.critical_value(model, "mu_k", (0, 3)), rel=1e-12
    )
