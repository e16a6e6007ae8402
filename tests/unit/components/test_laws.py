"""Each law states its formula, for numbers, arrays, polynomials and symbols alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import sympy
from numpy.polynomial import Polynomial
from scipy.special import lambertw

import frictionlab as fl
from frictionlab.components import (
    Coulomb,
    CubicContact,
    FixedLoad,
    FrictionalImpact,
    MovingLoad,
    PlasticImpact,
    RestitutionImpact,
)
from frictionlab.tape.functions import FUNCTIONS


def test_cubic_contact_is_equation_2():
    law = CubicContact(k2=2.0, k_nl=3.0)
    assert law.force(2.0) == 2 * 2 + 3 * 8
    np.testing.assert_allclose(law.force(np.array([-1.0, 1.0])), [-5, 5])
    np.testing.assert_allclose(law.force(Polynomial([0.0, 1.0])).coef, [0, 2, 0, 3])
    g = sympy.Symbol("g")
    assert law.force(g) == 2.0 * g + 3.0 * g**3


@pytest.mark.parametrize("function", [f for f in FUNCTIONS if f.public], ids=lambda f: f.name)
def test_laws_may_hold_every_function_of_the_tape(function):
    """Of floats, arrays and symbols alike."""
    names = {"atan": "arctan", "asinh": "arcsinh"}
    of_laws, x = getattr(fl.functions, names.get(function.name, function.name)), sympy.Symbol("x")
    assert of_laws(x) == function.expression(x)
    assert of_laws(0.3) == pytest.approx(float(function.expression(0.3)), rel=1e-15)
    np.testing.assert_array_equal(of_laws(np.array([0.3, 1.2])), [of_laws(0.3), of_laws(1.2)])


def test_a_function_that_is_not_there_is_named_with_those_that_are():
    with pytest.raises(
        AttributeError, match=r"fl.functions has no 'atan': it has exp, log, .* arctan, .* table"
    ):
        fl.functions.atan(0.5)


def test_coulomb_is_equations_3_and_8():
    law = Coulomb(mu_k=0.5, mu_s=0.75)
    assert law.kinetic(8.0, 123.0) == 4.0
    assert law.static_limit(8.0) == 6.0


def test_moving_load_gap_and_directions():
    q = (0.3, -0.2, 0.1, 0.05, 0.4)
    load = MovingLoad()
    assert load.penetration(*q) == pytest.approx(0.05 - 0.2 * 0.4 + 0.2)
    assert load.normal(*q) == pytest.approx((0, 1, 0, -1, 0.2))
    assert load.tangent(*q) == (1, 0, -1, 0, 0)


def test_fixed_load_is_the_moving_load_without_phi():
    q = (0.3, -0.2, 0.1, 0.05)
    load = FixedLoad()
    assert load.coordinates == MovingLoad().coordinates[:4]
    assert load.penetration(*q) == pytest.approx(MovingLoad().penetration(*q, 0.0))
    assert load.normal(*q) == MovingLoad().normal(*q, 0.0)[:4]
    assert load.tangent(*q) == (1, 0, -1, 0)


def test_plastic_impact_brings_its_rate_to_zero():
    material, full, compliance = 0.3, 0.5, 2.1
    assert material - compliance * PlasticImpact().impulse(material, full, compliance) == pytest.approx(0)
    assert full - compliance * PlasticImpact("full").impulse(material, full, compliance) == pytest.approx(0)


@pytest.mark.parametrize("e", [0.0, 0.25, 1.0])
def test_restitution_reverses_the_full_rate(e):
    after = 0.5 - 2.1 * RestitutionImpact(e).impulse(0.3, 0.5, 2.1)
    assert after == pytest.approx(-e * 0.5)


def test_no_restitution_is_the_plastic_impact_on_the_full_rate():
    assert RestitutionImpact(e=0.0).reduced() == PlasticImpact("full")
    assert RestitutionImpact(e=0.5).reduced() == RestitutionImpact(e=0.5)


class SoftImpact(RestitutionImpact):
    def impulse(self, material_rate, penetration_rate, compliance):
        return (1 + self.e) * penetration_rate / (2 * compliance)

    def reduced(self):
        others = {1.0: FrictionalImpact(e=1.0), 0.5: RestitutionImpact(e=0.25)}
        return others.get(self.e) or super().reduced()


def test_an_impulse_of_its_own_stays_without_restitution():
    assert SoftImpact(e=0.0).reduced() == SoftImpact(e=0.0)
    for e, other in ((1.0, "mu_i"), (0.5, "e")):
        with pytest.raises(
            ValueError, match=rf"reduced\(\) of SoftImpact must return .* with another {other}: give"
        ):
            _ = SoftImpact(e=e).structure_key


def test_impacts_refuse_what_they_do_not_know():
    with pytest.raises(
        ValueError,
        match="penetration_rate must be one of 'material', 'full', got 'fulll': did you mean 'full'",
    ):
        PlasticImpact(penetration_rate="fulll")
    with pytest.raises(ValueError, match=r"e must be at most 1, got 1\.5: lower e"):
        RestitutionImpact(e=1.5)


@dataclass(frozen=True)
class Branching(fl.ContactLaw):
    k: float = 1.0

    def force(self, penetration):
        return self.k * penetration if penetration > 0 else 0 * penetration


@dataclass(frozen=True)
class Hardening(fl.ContactLaw):
    """F_N = k d / (1 - d/c) of the penetration d: a quotient."""

    k: float = 5e3
    c: float = 0.1

    def force(self, penetration):
        return self.k * penetration / (1 - penetration / self.c)


@fl.model
class Pressed(fl.MechanicalModel):
    """A mass that a force presses on such a contact."""

    m: float = 2.0
    F: float = 300.0
    contact: fl.ContactLaw = Hardening()
    coordinates = ("y",)

    def mechanics(self, q, v):
        pad = fl.Contact(q.y, self.contact.force)
        return fl.Mechanics(self.m * v.y**2 / 2, loads={"y": self.F}, contacts=(pad,))


def test_a_quotient_has_its_equilibrium_its_frequency_and_its_deepest_point():
    """With a = F/(k c): d = F/(k + F/c), the frequency sqrt(k/m) (1 + a), and from d = 0 at rest a turn at
    d/c = 1 + W(-(1 + a) exp(-1 - a))/(1 + a), where the spring has taken all work of F."""
    model = Pressed()
    m, F, k, c = (model.parameters[name] for name in "mFkc")
    a = F / (k * c)
    assert fl.equilibrium(model).q[0] == pytest.approx(F / (k + F / c), rel=1e-12)
    assert abs(fl.eigenvalues(model).values[0].imag) == pytest.approx(np.sqrt(k / m) * (1 + a), rel=1e-12)
    run = fl.simulate(model, 0.2, sections={"turn": ("y'", -1)}, progress=False)
    deepest = c * (1 + lambertw(-(1 + a) * np.exp(-1 - a)).real / (1 + a))
    assert run.sections["turn"].state[0, 0] == pytest.approx(deepest, rel=1e-12)


@dataclass(frozen=True)
class OfNumpy(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force * np.tanh(speed)


@dataclass(frozen=True)
class OfTwoNumbers(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force * np.arctan2(speed, 0.1)


@dataclass(frozen=True)
class Mistyped(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return self.muk * normal_force


def test_a_typing_mistake_is_told_as_it_is():
    with pytest.raises(AttributeError, match="muk"):
        fl.simulate(fl.SliderOnBelt(friction=Mistyped()), 0.1)


@pytest.mark.parametrize(
    ("role", "law"), [("contact", Branching()), ("friction", OfNumpy()), ("friction", OfTwoNumbers())]
)
def test_a_law_that_cannot_take_symbols_is_named_with_the_cure(role, law):
    with pytest.raises(TypeError, match=rf"{type(law).__name__}\.\w+ must be a formula .* fl\.functions"):
        fl.simulate(fl.SliderOnBelt(**{role: law}), 0.1)
