"""Modes along a parameter: each keeps its column, whatever the values that the user asks for."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionlab as fl
from tests.helpers.assertions import assert_all
from tests.helpers.cases import slow_but
from tests.helpers.linear_automata import P, linear, rotated

pytestmark = pytest.mark.blas

S = fl.SliderOnBelt
GRIDS = (2, 3, 5, 8, 11, 33, 101, 1000)
SQUARES = [1 + P, 2 - P, sympy.Rational(3, 2) + P / 3, 1 + 2 * P]


def match(columns, expected):
    """Which expected column (N, k) each column is, throughout; -1 for none."""
    close = np.isclose(columns[:, :, None], expected[:, None, :], rtol=1e-7, atol=1e-10).all(axis=0)
    return [int(row.argmax()) if row.any() else -1 for row in close]


@pytest.mark.slow
@pytest.mark.parametrize("number", GRIDS)
@pytest.mark.parametrize("damping", [0.0, 0.01])
def test_modes_cross_without_noticing_each_other(number, damping):
    """Four uncoupled modes hidden in full matrices cross each other, two of them at p = 1/2 exactly."""
    stiffness, vectors = rotated(SQUARES, 1)
    at = np.linspace(0, 1, number)
    locus = fl.root_locus(linear(stiffness, damping), "p", at)
    squares = np.array([[float(k.subs(P, p)) for k in SQUARES] for p in at])
    modes = match(locus.values.imag, np.sqrt(squares - damping**2 / 4))
    assert sorted(modes) == [0, 1, 2, 3]
    np.testing.assert_allclose(locus.growth_rates, -damping / 2, atol=1e-10)
    shares = vectors[:, modes] ** 2  # without damping and friction, those of the kinetic energy
    np.testing.assert_allclose(locus.participation, np.tile(shares, (number, 1, 1)), atol=1e-6)
    np.testing.assert_allclose(locus.participation.sum(axis=1), 1, rtol=1e-12)
    shape = vectors[:, modes] / np.take_along_axis(
        vectors[:, modes], np.abs(vectors[:, modes]).argmax(axis=0)[None], axis=0
    )
    np.testing.assert_allclose(locus.shapes, np.tile(shape, (number, 1, 1)), atol=1e-6)
    if number > 2:  # by frequency, other modes would be in the columns at the end
        assert (np.argsort(locus.frequencies[-1]) != np.arange(4)).any()


def test_a_driven_mode_crosses_those_that_drive_it():
    """Without geometry friction drives the belt, which drives nothing: at a crossing two vectors are one."""
    model = S(mu_k=1.2, c4=0.4).without("geometry")
    for number in (2, 5, 40, 1001):
        stiffness = np.linspace(3e3, 4e4, number)
        locus = fl.root_locus(model, "k4", stiffness)
        belt = np.sqrt(stiffness - 0.2**2) * 1j - 0.2
        (alone,) = np.flatnonzero(np.isclose(locus.values, belt[:, None], rtol=1e-9).all(axis=0))
        np.testing.assert_allclose(locus.participation[:, 2, alone], 1, atol=1e-9)
        others = np.delete(locus.values, alone, axis=1)
        np.testing.assert_allclose(others, np.tile(others[:1], (number, 1)), rtol=1e-8)


@pytest.mark.parametrize("coupling", slow_but([1e-8], [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8]))
@pytest.mark.parametrize("bounds", slow_but([(0.013, 0.971)], [(0.0, 1.0), (0.013, 0.971), (1.0, 0.0)]))
def test_a_veering_is_no_crossing(coupling, bounds):
    """However weak the coupling and coarse the values: the lower frequency stays the lower one."""
    model = linear([[1 + P, coupling], [coupling, 2 - P]])
    for number in GRIDS:
        at = np.linspace(*bounds, number)
        half = np.sqrt((at - 0.5) ** 2 + coupling**2)
        expected = np.sqrt(np.stack([1.5 - half, 1.5 + half], axis=1))
        np.testing.assert_allclose(fl.root_locus(model, "p", at).values.imag, expected, rtol=1e-7)


@pytest.mark.parametrize(("damper", "veers"), [(0.01, True), (0.2, False)])
def test_different_damping_lets_weakly_coupled_modes_cross(damper, veers):
    """Coupled by e, frequencies veer if the decay rates differ by less than e/omega, and cross otherwise."""
    model = linear([[1 + P, 0.03], [0.03, 2 - P]], sympy.diag(0.005, damper))
    for number in GRIDS:
        locus = fl.root_locus(model, "p", np.linspace(0, 1, number))
        assert (locus.frequencies[-1, 0] < locus.frequencies[-1, 1]) == veers


@pytest.mark.parametrize("k_nl", slow_but([1e4], [0.0, 1e4, 1e7]))
def test_coalescence_in_figure_2(k_nl):
    model = S(F=100, k_nl=k_nl)
    fine = fl.root_locus(model, "mu_k", np.linspace(0, 3, 3001))
    for number in (4, 31, 301):
        locus = fl.root_locus(model, "mu_k", np.linspace(0, 3, number))
        np.testing.assert_allclose(locus.values, fine.values[:: 3000 // (number - 1)], rtol=1e-10)
    # Halving the steps shrinks the largest jump, by a half or, at a coalescence, by the square root of it.
    jumps = [np.abs(np.diff(fine.values[::step], axis=0)).max() for step in (4, 2, 1)]
    assert jumps[1] < 0.75 * jumps[0]
    assert jumps[2] < 0.75 * jumps[1]
    critical = fl.critical_value(model, "mu_k", (0, 3))
    assert_all(fine.unstable[fine.at < critical] == 0)
    (after,) = fine.values[[np.searchsorted(fine.at, critical + 0.05)]]
    growing = after.real.argmax()
    partner = np.argsort(np.abs(after.imag - after.imag[growing]))[1]
    assert abs(after.imag[partner] - after.imag[growing]) < 1e-3 * after.imag[growing]
    (before,) = fine.values[[np.searchsorted(fine.at, critical - 0.05)]]
    assert abs(before.imag[partner] - before.imag[growing]) > 5e-3 * before.imag[growing]


@pytest.mark.parametrize("number", GRIDS)
def test_modes_become_overdamped_one_by_one(number):
    """The first is overdamped throughout, the second from p = 100 down: neither takes the other's column."""
    at = np.linspace(110, 90, number)
    locus = fl.root_locus(linear([[2, 0], [0, P]], sympy.diag(3, 20), p=100.0), "p", at)
    second = -10 + np.sqrt((100 - at).astype(complex))
    found = locus.values[:, np.argsort(-locus.values[0].real)]
    np.testing.assert_allclose(found[:, 0], -1, rtol=1e-12)
    np.testing.assert_allclose(found[:, 1].imag, second.imag, atol=1e-6)
    # Which of the two real ones is shown may change; none of them is the first mode's.
    other = np.where(at < 100, -10 - np.sqrt(np.abs(100 - at)), -10)
    either = np.isclose(found[:, 1].real, second.real, atol=1e-6) | np.isclose(
        found[:, 1].real, other, atol=1e-6
    )
    assert either.all()


@fl.model
class Filtered(fl.MechanicalModel):
    """An oscillator, whose pair is -d +- sqrt(d^2 - 1), beside a filter of -2 +- sqrt(1 - p)."""

    p: float = 0.5
    d: float = 0.1
    coordinates = ("x",)
    states = ("a", "b")

    def mechanics(self, q, v, s):
        rates = {"a": -s.a + self.p * s.b, "b": -s.a - 3 * s.b}
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, loads={"x": -2 * self.d * v.x}, rates=rates)


@pytest.mark.parametrize("d", [0.1, 20.0])
def test_each_further_state_has_a_mode(d):
    """Two columns where they do not oscillate, and one where they do."""
    at = np.linspace(0.5, 2.0, 7)
    locus = fl.root_locus(Filtered(d=d), "p", at)
    root = np.sqrt((1.0 - at).astype(complex))
    either = np.array([-2.0 + root, np.where(root.imag, np.nan, -2.0 - root)])
    own = np.full(7, -d + np.sqrt(complex(d**2 - 1.0)))
    expected = np.array([own, *either]).T
    assert locus.values.shape == expected.shape
    for row, known in zip(locus.values, expected, strict=True):
        np.testing.assert_allclose(np.sort_complex(row), np.sort_complex(known), rtol=1e-7)


def test_a_damper_in_the_slider_that_overdamps_it():
    locus, fine = (fl.root_locus(S(mu_k=1.0), "c1", np.geomspace(0.1, 1e4, n)) for n in (401, 6401))
    assert (locus.values[-1].imag == 0).sum() == 1
    np.testing.assert_allclose(locus.values, fine.values[::16], rtol=1e-7)
    # Like a square root where the pair splits: a sixteenth of the step, a quarter of the jump.
    assert np.abs(np.diff(fine.values, axis=0)).max() < 0.4 * np.abs(np.diff(locus.values, axis=0)).max()


@pytest.mark.slow
def test_without_damping_growth_is_exactly_zero_until_modes_meet():
    model = S(c1=0, c2=0, c4=0, c5=0, c6=0)
    critical = fl.critical_value(model, "mu_k", (0, 3))
    at = np.linspace(3, 0, 61)
    locus = fl.root_locus(model, "mu_k", at)
    assert_all(locus.growth_rates[at < critical] == 0)
    assert (locus.unstable == (at > critical)).all()
    forward = fl.root_locus(model, "mu_k", at[::-1]).values[::-1]
    np.testing.assert_allclose(np.sort_complex(forward), np.sort_complex(locus.values), rtol=1e-10)


@pytest.mark.slow
@settings(max_examples=25)
@given(
    n=st.integers(2, 4),
    seed=st.integers(0, 10**6),
    damping=st.sampled_from([0.0, 1e-3, 0.1, 1.0]),
    coupling=st.floats(-6, 0).map(lambda e: 10.0**e),
    number=st.integers(2, 9),
)
def test_columns_do_not_depend_on_the_values(n, seed, damping, coupling, number):
    """Random symmetric stiffness, random dampers."""
    random = np.random.default_rng(seed)
    start, slope = random.normal(size=(2, n, n)) * coupling
    start, slope = start @ start.T + np.diag(random.uniform(0.5, 3, n)), slope + slope.T
    slope += np.diag(random.uniform(0, 2, n))
    dampers = damping * random.uniform(0.1, 1, n)
    model = linear(sympy.Matrix(start) + P * sympy.Matrix(slope), np.diag(dampers))
    coarse = fl.root_locus(model, "p", np.linspace(0, 1, number))
    fine = fl.root_locus(model, "p", np.linspace(0, 1, 50 * (number - 1) + 1))
    np.testing.assert_allclose(coarse.values, fine.values[::50], rtol=1e-6, atol=1e-9)
    for spectrum, at in zip(coarse.values, coarse.at, strict=True):
        matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-start - at * slope, -np.diag(dampers)]])
        gaps = np.abs(np.linalg.eigvals(matrix)[:, None] - spectrum[None, :])
        assert gaps.min(axis=0).max() < 1e-6


def test_tracking_goes_on_where_there_is_an_equilibrium_again():
    locus = fl.root_locus(S(), "F", [300.0, 200.0, 100.0, -100.0, 0.0, 100.0, 200.0, 300.0])
    missing = np.isnan(locus.values).all(axis=1)
    np.testing.assert_array_equal(missing, np.isnan(locus.values).any(axis=1))
    np.testing.assert_array_equal(missing, [0, 0, 0, 1, 1, 0, 0, 0])
    assert np.isnan(locus.participation[missing]).all()
    assert np.isnan(locus.shapes[missing]).all()
    assert (locus.unstable[missing] == 0).all()
    np.testing.assert_allclose(locus.values[:3], locus.values[:4:-1], rtol=1e-12)


@pytest.mark.parametrize("damping", [0.0, 0.01])
def test_identical_modes_do_no_harm(damping):
    """Two equal pairs of modes throughout, each of which couples: vectors there are arbitrary."""
    pair = sympy.Matrix([[1 + P, 0.05], [0.05, 2 - P]])
    model = linear(sympy.diag(pair, pair), damping)
    half = np.sqrt((np.linspace(0, 1, 2001) - 0.5) ** 2 + 0.05**2)
    expected = np.sqrt(np.stack([1.5 - half, 1.5 - half, 1.5 + half, 1.5 + half], axis=1) - damping**2 / 4)
    locus = fl.root_locus(model, "p", np.linspace(0, 1, 2001))
    np.testing.assert_allclose(locus.values.imag, expected, rtol=1e-7)


def test_one_value_and_the_same_value_twice():
    twice = fl.root_locus(S(), "mu_k", [1.4, 1.4])
    np.testing.assert_array_equal(twice.values[0], twice.values[1])
    np.testing.assert_array_equal(fl.root_locus(S(), "mu_k", 1.4).values[0], twice.values[0])
    assert (np.diff(twice.frequencies[0]) > 0).all()
