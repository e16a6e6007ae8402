"""All real equilibria: against the paper's numbers and against brute force."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from frictionlab.components import ContactLaw, HertzContact
from frictionlab.models import SliderOnBelt
from frictionlab.stability import equilibria, equilibrium
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_points.sliding import (
    sliding_equations,
    statics_at,
)
from tests.helpers.laws import Locking, Saturating

pytestmark = pytest.mark.blas

# Claims C1 to C3; x1 at mu_k = 1.4 is positive (erratum E1).
PAPER = {
    0.3: [-0.0042, -0.0304, -0.0036, -0.0061, -0.0001],
    1.4: [0.0053, -0.0263, -0.0147, -0.0053, 0.0026],
    2.5: [0.0124, -0.0233, -0.0232, -0.0046, 0.0041],
}


def static_residual(model, penetration):
    """gap(q(gap)) - gap by hand for the Coulomb models with springs as in Eq. (18); vectorised over gaps."""
    p = model.parameters
    normal = p["k2"] * penetration + p.get("k_nl", 0.0) * penetration**3
    friction = np.sign(p["v"]) * p["mu_k"] * normal
    x1 = (friction + normal - p["F"]) / p["k1"]
    y1 = x1 + 2 * (normal - p["F"]) / p["k3"]
    x2 = -friction / p["k4"]
    if "phi" not in model.coordinates:
        return -normal / (p["k5"] + p["k6"]) - y1 - penetration
    a, b, c = (
        p["k5"] + p["k6"],
        p["k5"] * p["l1"] - p["k6"] * p["l2"],
        p["k5"] * p["l1"] ** 2 + p["k6"] * p["l2"] ** 2,
    )
    force, moment = -normal, normal * (x1 - x2)
    determinant = a * c - b * b
    y2, phi = (c * force - b * moment) / determinant, (a * moment - b * force) / determinant
    return y2 - (x1 - x2) * phi - y1 - penetration


@pytest.mark.parametrize("mu_k", PAPER)
def test_the_papers_equilibria(mu_k):
    (only,) = equilibria(SliderOnBelt(mu_k=mu_k))
    np.testing.assert_allclose(only.q, PAPER[mu_k], atol=5e-5)
    assert only.residual < 1e-13
    assert only.normal_force == pytest.approx(5e3 * only.penetration + 1e4 * only.penetration**3)
    assert only.friction_force == pytest.approx(mu_k * only.normal_force)


@pytest.mark.parametrize("F", [2.2250738585e-313, 5e-324, 1e-300])
def test_a_preload_among_the_smallest_numbers(F):
    (found,) = equilibria(SliderOnBelt(mu_k=0.0, k_nl=0.0, F=F, k1=1e3, k3=1e3, k4=1e3, k5=1e3))
    assert found.residual < 1e-9
    assert 0 <= found.normal_force <= F


def test_erratum_e1():
    assert equilibrium(SliderOnBelt(mu_k=1.4)).q[0] == pytest.approx(0.005253, abs=5e-7)


@given(
    mu_k=st.floats(0, 3),
    k_nl=st.one_of(st.just(0.0), st.floats(0, 10).map(lambda e: 10.0**e)),
    F=st.floats(-2000, 5000),
    v=st.sampled_from([-1.0, 0.0, 1.0]),
    stiffness=st.lists(st.floats(1e3, 1e5), min_size=4, max_size=4),
    l1=st.floats(0.05, 0.4),
    toggles=st.sampled_from([(), ("geometry",), ("nonsmooth",)]),
)
def test_no_root_is_missed_and_none_invented(mu_k, k_nl, F, v, stiffness, l1, toggles):
    assume(v != 0 or "nonsmooth" not in toggles)  # refused: sliding at rest gives friction no direction
    k1, k3, k4, k5 = stiffness
    model = SliderOnBelt(mu_k=mu_k, k_nl=k_nl, F=F, v=v, k1=k1, k3=k3, k4=k4, k5=k5, l1=l1).without(*toggles)
    found = equilibria(model)
    penetrations = np.array([e.penetration for e in found])
    assert all(e.residual < 1e-9 for e in found)
    assert list(penetrations) == sorted(penetrations)
    # Brute force: each change of sign of the equation typed above encloses an odd number of the roots.
    grid = np.concatenate([-np.geomspace(1e3, 1e-9, 5000), np.geomspace(1e-9, 1e3, 5000)])
    values = np.sign(static_residual(model, grid))
    changes = np.flatnonzero(values[1:] * values[:-1] < 0)
    for i in changes:
        inside = (penetrations >= grid[i] - 1e-9 * abs(grid[i])) & (
            penetrations <= grid[i + 1] + 1e-9 * abs(grid[i + 1])
        )
        assert inside.sum() % 2 == 1


def test_several_equilibria_are_all_found():
    model = SliderOnBelt(mu_k=1.5, F=3000, k4=2e4, k5=2e3, k6=2e3, l1=0.05, l2=0.05)
    found = equilibria(model)
    grid = np.linspace(-5, 5, 400001)
    values = np.sign(static_residual(model, grid))
    assert len(found) == np.count_nonzero(values[1:] != values[:-1]) == 3
    assert all(e.residual < 1e-13 and e.normal_force > 0 for e in found)
    assert equilibrium(model).penetration == min(e.penetration for e in found if e.normal_force > 0)


def test_singular_cases_say_what_is_missing():
    with pytest.raises(ValueError, match="the springs do not hold x2"):
        equilibria(SliderOnBelt(k4=0))
    with pytest.raises(ValueError, match="the springs do not hold phi"):
        equilibria(SliderOnBelt(l1=0, l2=0))
    with pytest.raises(ValueError, match="the springs do not hold x1, y1"):
        equilibria(SliderOnBelt(k1=0))


def test_the_contact_may_hold_the_slider_alone():
    (hung,) = equilibria(SliderOnBelt(k3=0))
    assert hung.normal_force == pytest.approx(200)
    (nearly,) = equilibria(SliderOnBelt(k3=1e-4))
    np.testing.assert_allclose(hung.q, nearly.q, rtol=1e-5)


def test_no_preload_no_sliding_equilibrium():
    (rest,) = equilibria(SliderOnBelt(F=0))
    np.testing.assert_array_equal(rest.q, 0)
    with pytest.raises(
        ValueError, match="must be an equilibrium with F_N > 0, got normal forces: 0 N: raise the preload"
    ):
        equilibrium(SliderOnBelt(F=0))


@pytest.mark.parametrize("k_nl", [0.0, 1e-300, 1e-20, 1e7, 1e10])
def test_any_cubic_stiffness(k_nl):
    point = equilibrium(SliderOnBelt(k_nl=k_nl, mu_k=2.5))
    assert point.residual < 1e-12


def test_a_belt_at_rest_has_no_friction_in_equation_3():
    assert equilibrium(SliderOnBelt(v=0)).friction_force == 0


def test_a_law_that_is_no_polynomial():
    point = equilibrium(SliderOnBelt(contact=Saturating()))
    assert point.residual < 1e-12
    assert 0 < point.normal_force < 300


SCENES = [
    ({}, 1),
    ({"mu_k": 1.4, "F": 2e4}, 1),
    ({"F": 5e3, "k2": 1900.0, "k_nl": 8300.0, "k1": 380.0, "k3": 37e3, "mu_k": 2.0}, 3),
    ({"F": 11e3, "k2": 470.0, "k_nl": 390.0, "k1": 1300.0, "k3": 1400.0, "mu_k": 1.7}, 3),
]


@pytest.mark.parametrize(("changes", "count"), SCENES)
def test_all_roots_of_the_polynomial_are_those_of_mpmath(changes, count):
    model = SliderOnBelt(**changes)
    penetrations = [point.penetration for point in equilibria(model)]
    equations = sliding_equations(model)
    assert equations is not None
    values = equations.values(model)
    excess = statics_at(equations, values).polynomial(values)[:, 0]
    with mpmath.workdps(40):
        roots = mpmath.polyroots([*map(mpmath.mpf, excess[::-1])], maxsteps=500, extraprec=200)
        real = sorted(float(z.real) for z in roots if abs(z.imag) < 1e-20 * abs(z))
    np.testing.assert_allclose(penetrations, real, rtol=1e-12)
    assert len(real) == count


def test_a_law_may_be_undefined_for_a_negative_gap():
    point = equilibrium(SliderOnBelt(contact=HertzContact(k_h=1e5)))
    assert point.residual < 1e-12
    assert point.normal_force == pytest.approx(1e5 * point.penetration**1.5)


@dataclass(frozen=True)
class Quadratic(ContactLaw):
    """A law with an even power: F_N > 0 at a gap of -0.7 m too, where there is no contact."""

    k_a: float = 5e3
    k_b: float = 1e4

    def force(self, penetration):
        """Linear and square."""
        return self.k_a * penetration + self.k_b * penetration**2


def test_pressed_means_compressed():
    model = SliderOnBelt(contact=Quadratic())
    outside, inside = equilibria(model)
    assert outside.penetration < -0.5
    assert outside.normal_force > 0
    assert equilibrium(model).penetration == inside.penetration > 0
    view = equilibrium_problem(model)
    x = view.solve(*view.at({"mu_k": [0.3, 0.3]}))
    np.testing.assert_allclose(x[:5], np.stack([inside.q, inside.q], axis=1), rtol=1e-9)


def test_a_pole_is_no_root():
    """On a belt that tilts; test_a_law_with_poles has the roots on one that does not."""
    model = SliderOnBelt(contact=Locking())
    found = equilibria(model)
    assert found.complete
    assert all(point.residual < 1e-9 and abs(abs(point.penetration) - 0.1) > 1e-6 for point in found)
    assert 0 < equilibrium(model).penetration < 0.1
