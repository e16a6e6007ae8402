"""The one equation in the penetration with laws that are no polynomials: none is missed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq

import frictionlab as fl
from frictionlab.components import ContactLaw
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from tests.helpers.cases import slow_but
from tests.helpers.laws import Locking


@dataclass(frozen=True)
class Bump(ContactLaw):
    """A spring, and a force in a narrow band of penetrations."""

    k: float = 5e3
    height: float = 80.0
    centre: float = 0.02
    width: float = 1e-5

    def force(self, penetration):
        """A line and a Gaussian bell."""
        return self.k * penetration + self.height * fl.functions.exp(
            -(((penetration - self.centre) / self.width) ** 2)
        )


@dataclass(frozen=True)
class Steep(ContactLaw):
    """An exponential law."""

    a: float = 1e-4
    b: float = 0.02

    def force(self, penetration):
        """As slip rates of rate and state friction."""
        return fl.functions.exp((penetration - self.b) / self.a)


@dataclass(frozen=True)
class Touching(ContactLaw):
    """Leaves 1e5 c ((penetration - centre)^n + moved) cosh(penetration) of the equation."""

    free: float = 0.1
    c: float = 1e-3
    n: int = 2
    moved: float = 0.0
    centre: float = 0.02

    def force(self, penetration):
        """What holds the bodies at every penetration, and the rest."""
        rest = (penetration - self.centre) ** self.n + self.moved
        return (self.free - penetration) / self.c + 1e5 * rest * fl.functions.cosh(penetration)


@dataclass(frozen=True)
class Tangent(ContactLaw):
    """A force with a pole in every period."""

    k: float = 5e3
    most: float = 0.02

    def force(self, penetration):
        """A tangent."""
        return self.k * self.most * fl.functions.tan(penetration / self.most)


@dataclass(frozen=True)
class Cliff(ContactLaw):
    """A spring, a step that no floats resolve, a narrow dip and a wide one."""

    k: float = 5e3

    def force(self, penetration):
        """Roots on the step, beside both dips."""
        step = 300 * (1 + fl.functions.tanh((penetration - 0.019) / 1e-21))
        narrow = 650 * fl.functions.exp(-(((penetration - 0.02) / 1e-6) ** 2))
        wide = 700 * fl.functions.exp(-(((penetration - 0.03) / 2e-3) ** 2))
        return self.k * penetration + step - narrow - wide


@dataclass(frozen=True)
class Pole(ContactLaw):
    """A force that is infinite at zero penetration."""

    k: float = 2e4
    a: float = 1e-2

    def force(self, penetration):
        """A spring that is shorter by a distance."""
        return self.k * penetration - self.a / penetration


@dataclass(frozen=True)
class Power(ContactLaw):
    """A spring with any power."""

    k: float = 2e4
    n: float = 1.5

    def force(self, penetration):
        """A power."""
        return self.k * penetration**self.n


def line(model):
    """L and C of L - C F_N = penetration, for a belt that does not tilt."""
    p = model.parameters
    free = model.F / p["k1"] + 2 * model.F / p["k3"]
    return free, (1 + p["mu_k"]) / p["k1"] + 2 / p["k3"] + 1 / (p["k5"] + p["k6"])


def fixed(contact, **changes):
    return fl.SliderOnBelt(contact=contact, geometry=fl.FixedLoad(), **changes)


def least(model, **arrays):
    """The least penetrations for arrays of parameters."""
    problem = equilibrium_problem(model)
    states = problem.solve(*problem.at(arrays))
    return states[3] - states[1]


@pytest.mark.parametrize("width", slow_but([1e-3, 1e-9], [1e-3, 1e-5, 1e-7, 1e-9]))
def test_a_narrow_bump_of_the_law(width):
    model = fixed(Bump(width=width))
    free, compliance = line(model)

    def rest(x):  # x is the distance from the bump's centre
        force = 5e3 * (0.02 + x) + 80 * np.exp(-((x / width) ** 2))
        return free - compliance * force - 0.02 - x

    far = 5 * width
    roots = [brentq(rest, *ends, xtol=1e-18) for ends in ((-far, 0.0), (0.0, min(far, 3e-3)), (3e-3, 0.05))]
    found = fl.equilibria(model)
    assert found.complete
    np.testing.assert_allclose([e.penetration - 0.02 for e in found], roots, rtol=1e-7, atol=1e-16)
    at = least(model, width=np.array([width, 2 * width, width]))
    np.testing.assert_allclose(at[[0, 2]], found[0].penetration, rtol=2e-8)  # of states, which round
    assert at[1] < at[0]


def test_many_widths_of_a_bump_at_once():
    """Also where it has vanished, as its height is too small: then only the far root is left."""
    widths, heights = np.geomspace(1e-9, 1e-4, 23), np.full(23, 80.0)
    heights[::2] = 20.0
    model = fixed(Bump())
    free, compliance = line(model)
    there = np.sqrt(np.log(80 / ((free - 0.02) / compliance - 100)))  # in widths, but for the line's slope
    at = least(model, width=widths, height=heights)
    np.testing.assert_allclose(at[::2], free / (1 + 5e3 * compliance), rtol=1e-12)
    np.testing.assert_allclose((0.02 - at[1::2])[3:9] / widths[1::2][3:9], there, rtol=1e-3)


def test_a_law_with_poles():
    """Times its denominator the equation is a cubic polynomial, one root on each side of each pole."""
    most = np.array([0.5, 0.05, 0.021, 1e-3])
    model = fixed(Locking(most=0.05))
    free, compliance = line(model)

    def roots(m):
        return np.roots([1 / m**2, -free / m**2, -1 - 5e3 * compliance, free])

    pressed = [min(root for root in roots(m) if root > 0) for m in most]
    np.testing.assert_allclose(least(model, most=most), pressed, rtol=1e-9)
    found = fl.equilibria(model)
    assert found.complete
    np.testing.assert_allclose(sorted(e.penetration for e in found), np.sort(roots(0.05)), rtol=1e-12)


@pytest.mark.parametrize("count", slow_but([7], [1, 7, 100]))
def test_a_root_on_a_step_is_none_and_hides_none(count):
    """The first root with F_N > 0 is on the step, where no float is static; the next is in the dip."""
    model = fixed(Cliff())
    free, compliance = line(model)

    def rest(d):
        dips = 650 * np.exp(-(((d - 0.02) / 1e-6) ** 2)) + 700 * np.exp(-(((d - 0.03) / 2e-3) ** 2))
        return (free - d) / compliance - (5e3 * d + 600 - dips)

    dip = brentq(rest, 0.019995, 0.02, xtol=1e-18)
    np.testing.assert_allclose(least(model, F=np.full(count, model.F)), dip, rtol=1e-9)


def test_a_force_that_is_infinite_without_penetration():
    model = fixed(Pole())
    free, compliance = line(model)
    roots = np.roots([-1 - compliance * 2e4, free, compliance * 1e-2])
    np.testing.assert_allclose(least(model, a=np.full(2, 1e-2)), roots.max(), rtol=1e-12)
    assert fl.equilibrium(model).penetration == pytest.approx(roots.max(), rel=1e-12)


def test_the_least_of_endless_roots():
    """Of a tangent's roots the least lies before its first pole."""
    most = np.array([0.5, 0.02, 1e-3])
    model = fixed(Tangent())
    free, compliance = line(model)
    roots = [
        brentq(lambda d, m=m: free - compliance * 5e3 * m * np.tan(d / m) - d, 0.0, 1.5707 * m, xtol=1e-18)
        for m in most
    ]
    np.testing.assert_allclose(least(model, most=most), roots, rtol=1e-9)


@pytest.mark.parametrize("a", [1e-2, 1e-3, 1e-4, 1e-5, 1e-7])
def test_a_steep_exponential(a):
    """L - C exp((d - b)/a) = d is solved by Lambert's W."""
    model = fixed(Steep(a=a))
    free, compliance = map(mpmath.mpf, line(model))
    with mpmath.workdps(50):
        exact = free - a * mpmath.lambertw(compliance / a * mpmath.exp((free - 0.02) / a))
    found = fl.equilibria(model)
    assert found.complete
    assert [e.penetration for e in found] == [pytest.approx(float(exact), rel=1e-13)]
    np.testing.assert_allclose(least(model, a=np.array([a, a])), float(exact), rtol=1e-9)


@pytest.mark.parametrize(
    ("n", "moved"),
    slow_but(
        [(2, 0.0), (2, -1e-9), (3, -1e-9)],
        [*product([2, 3], [0.0, 1e-14, -1e-14, 1e-9, -1e-9])],
        several=True,
    ),
)
def test_double_and_triple_roots(n, moved):
    free, compliance = line(fixed(Steep()))
    model = fixed(Touching(free=free, c=compliance, n=n, moved=moved))
    if n == 2:
        expected = [] if moved > 0 else [0.02 - np.sqrt(-moved), 0.02 + np.sqrt(-moved)]
    else:
        expected = [0.02 - np.cbrt(moved)]
    expected = np.unique(expected)
    found = fl.equilibria(model)
    assert found.complete
    room = 2e-6 if moved == 0 else 1e-8 * abs(moved) ** (1 / n)
    np.testing.assert_allclose([e.penetration for e in found], expected, atol=room + 1e-9)
    at = least(model, F=np.full(2, model.F))
    np.testing.assert_allclose(at, expected[0] if len(expected) else np.nan, atol=room + 1e-9)


def test_an_array_of_exponents():
    model = fixed(Power())
    free, compliance = line(model)
    exponents = np.array([0.5, 1.0, 1.3, 2.0, 2.7, 3.0])
    expected = [
        brentq(lambda d, n=n: free - compliance * 2e4 * d**n - d, 1e-9, free, xtol=1e-16) for n in exponents
    ]
    np.testing.assert_allclose(least(model, n=exponents), expected, rtol=1e-12)


@pytest.mark.parametrize("direction", ["vertical", pytest.param("normal", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "contact",
    slow_but(
        [fl.HertzContact()],
        [fl.HertzContact(), Bump(width=1e-4), Steep(), fl.CubicContact()],
    ),
)
def test_a_belt_that_tilts(direction, contact):
    """All changes of sign of the equation on a fine grid, its coordinates solved as linear equations."""
    model = fl.SliderOnBelt(contact=contact, geometry=fl.MovingLoad(direction))
    p = model.parameters

    def rest(d):
        normal = float(contact.force(np.float64(d)))
        drag = p["mu_k"] * normal
        a, b = p["k5"] + p["k6"], p["k5"] * p["l1"] - p["k6"] * p["l2"]
        stiffness = np.zeros((5, 5))
        stiffness[:2, :2] = [[p["k1"] + p["k3"] / 2, -p["k3"] / 2], [-p["k3"] / 2, p["k3"] / 2]]
        stiffness[2, 2] = p["k4"]
        stiffness[3:, 3:] = [[a, b], [b, p["k5"] * p["l1"] ** 2 + p["k6"] * p["l2"] ** 2]]
        lever = np.zeros((5, 5))
        lever[4, 0], lever[4, 2] = normal, -normal
        if direction == "normal":
            lever[0, 4], lever[2, 4] = normal, -normal
        x1, y1, x2, y2, phi = np.linalg.solve(stiffness - lever, [drag, normal - p["F"], -drag, -normal, 0.0])
        return y2 - (x1 - x2) * phi - y1 - d

    found = fl.equilibria(model)
    assert found.complete
    grid = np.unique(np.concatenate([np.linspace(1e-6, 0.1, 4001), np.linspace(0.0198, 0.0202, 801)]))
    if isinstance(contact, Steep):
        grid = grid[grid < 0.03]
    signs = np.sign([rest(d) for d in grid])
    changes = np.flatnonzero(signs[1:] != signs[:-1])
    inside = [e.penetration for e in found if 1e-6 < e.penetration < grid[-1]]
    assert len(inside) == len(changes)
    for d, i in zip(inside, changes, strict=True):
        assert d == pytest.approx(brentq(rest, grid[i], grid[i + 1], xtol=1e-16), rel=1e-9)


def test_a_root_that_double_precision_cannot_solve_is_left_out_with_a_reason():
    """A small quartic term gives far roots, at which one digit of the penetration is a thousand preloads."""
    model = fl.SliderOnBelt(F=30.0, contact=fl.PolynomialContact(a1=5e3, a2=-1.5e5, a4=1e-3))
    found = fl.equilibria(model)
    assert all(e.residual < 1e-3 for e in found)
    near = fl.equilibria(model.replace(a4=0.0))
    assert [e.penetration for e in found] == pytest.approx([e.penetration for e in near], rel=1e-6)
    assert near.complete
    assert "last digit" in found.why
