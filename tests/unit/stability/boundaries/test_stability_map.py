"""Stability maps: closed forms of the boundary, and the eigenvalues of single models."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import frictionlab as fl

P, Q = sympy.symbols("p q", real=True)


def oscillators(*damping_and_stiffness):
    """Uncoupled oscillators x'' + c x' + k x = 0 whose c and k depend on the parameters p and q."""
    n = len(damping_and_stiffness)
    x, v = (sympy.symbols(f"{name}1:{n + 1}", real=True) for name in "xv")
    rates = tuple(-c * v[i] - k * x[i] for i, (c, k) in enumerate(damping_and_stiffness))
    mode = fl.Mode("only", (*v, *rates))
    return fl.HybridAutomaton((*x, *v), (mode,), {P: 0.1, Q: 0.1}, n)


def grid(low, high, count=12):
    return np.linspace(low, high, count)


def plane(automaton, reach=2.0):
    return fl.stability_map(automaton, x=("p", grid(-reach, reach)), y=("q", grid(-reach, reach, 11)))


def test_a_circle_is_one_closed_curve_to_rounding():
    found = plane(oscillators((P**2 + Q**2 - 1, 4.0)))
    (curve,) = found.boundary
    np.testing.assert_allclose(np.hypot(*curve.points.T), 1.0, atol=1e-13)
    np.testing.assert_array_equal(curve.points[0], curve.points[-1])
    assert curve.unstable == (0, 1)
    np.testing.assert_allclose(curve.frequencies, 2 / (2 * np.pi), rtol=1e-12)
    inside = np.hypot(*np.meshgrid(found.x_values, found.y_values)) < 1
    np.testing.assert_array_equal(found.unstable, inside)
    # Every direction from the centre meets it.
    angles = np.sort(np.arctan2(curve.points[:, 1], curve.points[:, 0]))
    assert np.diff(angles).max() < 0.05


@pytest.mark.slow
def test_two_discs_that_overlap():
    discs = [((P - s) ** 2 + Q**2 - 1, k) for s, k in ((-0.5, 4.0), (0.5, 9.0))]
    found = plane(oscillators(*discs))
    assert found.unstable.max() == 2
    assert {curve.unstable for curve in found.boundary} == {(0, 1), (1, 2)}
    for curve in found.boundary:
        p, q = curve.points.T
        radii = np.sort([np.hypot(p + 0.5, q), np.hypot(p - 0.5, q)], axis=0)
        # The union ends where the nearer centre is at distance 1, the lens where the farther one is.
        np.testing.assert_allclose(radii[0 if curve.unstable == (0, 1) else 1], 1.0, atol=1e-12)


@pytest.mark.slow
def test_divergence_on_a_straight_line_from_edge_to_edge():
    found = plane(oscillators((0.3, 1 + P - 2 * Q)))
    (curve,) = found.boundary
    p, q = curve.points.T
    np.testing.assert_allclose(1 + p - 2 * q, 0, atol=1e-12)
    np.testing.assert_array_equal(curve.frequencies, 0)
    ends = curve.points[[0, -1]]
    np.testing.assert_allclose(np.abs(ends).max(axis=1), 2.0, rtol=1e-14)


@pytest.mark.slow
def test_a_curve_along_the_edge_of_the_map_is_one_curve():
    found = plane(oscillators((Q + 2 - 1e-4 * (P + 2.5), 4.0)))
    (curve,) = found.boundary
    np.testing.assert_allclose(curve.points[:, 1], -2 + 1e-4 * (curve.points[:, 0] + 2.5), atol=1e-12)
    assert np.ptp(curve.points[:, 0]) == pytest.approx(4.0)


@pytest.mark.slow
def test_a_sliver_thinner_than_the_step_is_rounded():
    found = plane(oscillators((Q**2 + 1e-5 * (P**2 - 1) * 16, 4.0)), reach=2.0)
    (curve,) = found.boundary
    p, q = curve.points.T
    np.testing.assert_allclose(q**2, 16e-5 * (1 - p**2), atol=1e-13)
    assert p.max() == pytest.approx(1, abs=0.02)
    assert p.min() == pytest.approx(-1, abs=0.02)


def test_nothing_changes_nothing_is_drawn():
    assert plane(oscillators((1.0, 4.0))).boundary == ()


SCENES = [
    (fl.SliderOnBelt(k_nl=1e7), ("F", np.linspace(20, 1000, 12)), 3.0),
    (fl.SliderOnBelt(F=1000), ("l1", np.linspace(0.05, 0.4, 15)), 3.0),
    (fl.SliderOnBelt(), ("k_nl", np.geomspace(1e2, 1e9, 12)), 3.0),
]


@pytest.mark.slow
@pytest.mark.parametrize(("model", "x", "top"), SCENES)
def test_the_slider_against_single_eigenvalues(model, x, top):
    found = fl.stability_map(model, x=x, y=("mu_k", np.linspace(0, top, 13)))
    for j in range(0, 13, 4):
        for i in range(0, len(x[1]), 3):
            single = model.replace(**{x[0]: x[1][i], "mu_k": found.y_values[j]})
            values = fl.eigenvalues(single).values
            assert found.unstable[j, i] == np.sum((values.real > 0) & (values.imag > 0))
            assert found.growth[j, i] == pytest.approx(values.real.max(), abs=1e-9)
    assert found.boundary
    for curve in found.boundary:
        for (across, up), frequency in list(zip(curve.points, curve.frequencies))[::20]:
            values = fl.eigenvalues(model.replace(**{x[0]: across, "mu_k": up})).values
            critical = values[np.argmin(np.abs(values.real))]
            assert abs(critical.real) < 1e-8
            assert abs(critical.imag) / (2 * np.pi) == pytest.approx(frequency, rel=1e-6)


@pytest.mark.slow
def test_the_lowest_boundary_passes_through_the_critical_values():
    model = fl.SliderOnBelt()
    forces = np.linspace(50, 1000, 8)
    found = fl.stability_map(model, x=("F", forces), y=("mu_k", np.linspace(0, 3, 9)))
    (lowest,) = (c for c in found.boundary if c.unstable == (0, 1))
    critical = fl.critical_curve(model, "mu_k", (0, 3), over=("F", forces)).values
    order = np.argsort(lowest.points[:, 0])
    np.testing.assert_allclose(np.interp(forces, *lowest.points[order].T), critical, atol=2e-4)


@pytest.mark.slow
def test_where_there_is_no_equilibrium():
    found = fl.stability_map(fl.SliderOnBelt(), x=("F", [-100.0, 100.0]), y=("mu_k", [0.3, 2.5]))
    np.testing.assert_array_equal(found.unstable, [[-1, 0], [-1, 1]])
    assert np.isnan(found.growth[:, 0]).all()


@pytest.mark.slow
def test_the_island_of_the_stiff_contact_is_one_closed_curve():
    """Table 1 with k_nl = 1e7: flutter near mu_k 0.2 for preloads about 170 N, far below the first loss."""
    model = fl.SliderOnBelt(k_nl=1e7)
    found = fl.stability_map(model, x=("F", np.linspace(140, 200, 25)), y=("mu_k", np.linspace(0.1, 0.3, 21)))
    (island,) = found.boundary
    np.testing.assert_array_equal(island.points[0], island.points[-1])
    assert island.unstable == (0, 1)
    changes = fl.stability_changes(model.replace(F=175.0), "mu_k", (0.1, 0.3))
    assert [c.direction for c in changes] == ["loss", "regain"]
    for change in changes:
        nearest = np.abs(island.points - (175.0, change.value)) / (60, 0.2)
        assert np.hypot(*nearest.T).min() < 0.01
