"""Laws that have no real value at the values of their parameters are named with them, whoever asks first."""

import math
from dataclasses import dataclass

import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.tape.undefined_parts import undefined_part


@dataclass(frozen=True)
class Root(fl.FrictionLaw):
    mu_k: float = fl.parameter(0.3)
    a: float = fl.parameter(-1.0)

    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force * fl.functions.sqrt(self.a)

    def static_limit(self, normal_force):
        return self.mu_k * normal_force


@dataclass(frozen=True)
class Logarithm(Root):
    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force

    def static_limit(self, normal_force):
        return self.mu_k * normal_force * (1 + fl.functions.log(self.a))


@dataclass(frozen=True)
class Quotient(Root):
    a: float = fl.parameter(0.0)

    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force / (1 + speed / self.a)


@dataclass(frozen=True)
class Power(fl.ContactLaw):
    k: float = fl.parameter(1e5)
    p: float = fl.parameter(-1.5)

    def force(self, penetration):
        return self.k * penetration * self.p**0.5


@dataclass(frozen=True)
class Steep(Root):
    """Without a derivative at the belt's speed of 1 m/s."""

    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force * fl.functions.sqrt(speed - 1.0)


MODELS = [
    (fl.MassOnBelt(friction=Root()), r"Root.kinetic of this MassOnBelt has sqrt\(a\), .* at a = -1: "),
    (
        fl.SliderOnBelt(friction=Logarithm()),
        r"Logarithm.static_limit of this SliderOnBelt has log\(a\), .* -1",
    ),
    (
        fl.MassOnBelt(friction=Quotient()),
        r"Quotient.kinetic of this MassOnBelt has 1/a, .* real value at a = 0",
    ),
    (
        fl.SliderOnBelt(contact=Power()),
        r"Power.force of this SliderOnBelt has p\*\*0.5, .* at p = -1.5: give",
    ),
]
USES = {
    "simulate": lambda m: fl.simulate(m, 0.1),
    "ensemble": lambda m: fl.ensemble([m], 0.1),
    "steady_state": lambda m: fl.steady_state(m, transient=1.0, window=1.0),
    "equilibrium": fl.equilibrium,
    "eigenvalues": fl.eigenvalues,
    "bifurcation": lambda m: fl.bifurcation(m, "v", [1.0, 2.0], transient=1.0, window=1.0),
}


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize(("model", "message"), MODELS, ids=lambda each: type(each).__name__)
def test_a_law_without_a_value_is_named(model, message, use):
    with pytest.raises(ValueError, match=message):
        USES[use](model)


def test_an_equilibrium_without_a_derivative_is_told():
    model = fl.SliderOnBelt(friction=Steep(), v=1.0)
    with pytest.raises(ValueError, match=r"state matrix of SliderOnBelt\(.*Steep\(.* must be finite"):
        fl.eigenvalues(model)


def test_an_automaton_tells_the_number_and_its_parameters():
    x, k, m = sp.symbols("x k m")
    automaton = fl.HybridAutomaton((x,), (fl.Mode("on", (-sp.sqrt(k / m) * x,)),), {k: -4.0, m: 2.0})
    with pytest.raises(
        ValueError, match=r"the equations have sqrt\(k/m\), which has no real value at k = -4, m"
    ):
        fl.solve(automaton, 1.0, x0=[1.0])
    assert fl.solve(automaton.replace(k=8.0), 1.0, x0=[1.0]).status.ok


def test_parts_with_states_are_left_out():
    x, a = sp.symbols("x a")
    assert undefined_part(sp.sqrt(x - a) + a**2, {a: -1.0}) == ""
    assert undefined_part(sp.log(1 / a) / x, {a: 0.0}).startswith("1/a, which")
    assert undefined_part(sp.exp(a), {a: 1e4}).startswith("exp(a), which has no real value at a = 10000")


@fl.model
class Checked(fl.MechanicalModel):
    """Its parameter has the name that a note of a check could have."""

    checked: float = -1.0
    coordinates = ("x",)

    def mechanics(self, q, v):
        return fl.Mechanics(self.checked * v.x**2 / 2, q.x**2 / 2)


def test_a_parameter_of_any_name_does_not_hide_a_mass_below_zero():
    for _ in range(2):
        with pytest.raises(ValueError, match="mass"):
            Checked().automaton()
    assert fl.simulate(Checked(checked=4.0), 2.0, x0=[1.0, 0.0]).final_state[0] == pytest.approx(
        math.cos(1.0), abs=1e-14
    )
