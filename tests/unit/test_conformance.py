"""Every law and every model goes through the conformance suite, and what is wrong does not."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.automaton import HybridAutomaton
from frictionlab.components import StickSlip
from frictionlab.components.functions import exp
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.mechanics import Mechanics
from frictionlab.models.symbols import symbol
from tests.helpers.cases import slow_but

LAWS = [
    fl.CubicContact(),
    fl.LinearContact(),
    fl.HertzContact(),
    fl.PolynomialContact(a2=1e4, a3=1e5, a5=1e7),
    fl.Coulomb(),
    fl.ExponentialDecay(),
    fl.HyperbolicDecay(),
    fl.Stribeck(mu_v=0.05),
    fl.WeakeningStrengthening(),
    fl.PressureDependent(),
    fl.PlasticImpact(),
    fl.PlasticImpact("full"),
    fl.RestitutionImpact(e=0.4),
    fl.FrictionalImpact(e=0.4, mu_i=0.2),
    fl.FrictionalImpact(e=0.0, mu_i=0.8),
]
ROLES = {fl.ContactLaw: "contact", fl.FrictionLaw: "friction", fl.ImpactLaw: "impact"}


def in_slider(law):
    role = next(role for kind, role in ROLES.items() if isinstance(law, kind))
    return fl.SliderOnBelt(impact=fl.PlasticImpact("full"), mu_k=1.4).replace(**{role: law})


@pytest.mark.plain_python
@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_every_law(law):
    fl.testing.check_law(law)


# In every run of the tests a law of friction, beside the plastic impact and the cubic contact; all laws, with
# either load, in the slow ones.
AT_ONCE = {fl.Stribeck(mu_v=0.05)}


@pytest.mark.parametrize(
    ("law", "off"),
    [
        pytest.param(law, off, marks=pytest.mark.slow if off or law not in AT_ONCE else ())
        for law in LAWS
        for off in ((), ("geometry",))
    ],
    ids=repr,
)
def test_every_law_in_the_slider(law, off):
    run = fl.testing.check_model(in_slider(law).without(*off))
    assert len(run.events) > 10 or law == fl.Coulomb()  # at mu_k = 0.3 it comes to slide
    assert fl.energy_audit(run, progress=False).error < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("law", [fl.ExponentialDecay(), fl.Stribeck(mu_v=0.05), fl.WeakeningStrengthening()])
def test_every_friction_law_of_speed_in_bilateral_contact(law):
    fl.testing.check_model(in_slider(law).replace(interface=StickSlip()), t_end=0.3)


OF_EQUILIBRIA = [law for law in LAWS if isinstance(law, (fl.FrictionLaw, fl.ContactLaw))]
OFTEN = (fl.PressureDependent,)


@pytest.mark.parametrize(
    "law", slow_but([law for law in OF_EQUILIBRIA if type(law) in OFTEN], OF_EQUILIBRIA), ids=repr
)
def test_every_law_has_an_equilibrium_and_eigenvalues(law):
    """The eigenvalues are those of the flow's derivative by finite differences."""
    model = in_slider(law)
    found = fl.eigenvalues(model)
    rest = np.concatenate([fl.equilibrium(model).q, np.zeros(5)])
    assert np.isfinite(found.values).all()
    stay = fl.simulate(model, 0.01, x0=rest, progress=False)
    assert stay.final_state == pytest.approx(rest, abs=1e-13)
    assert len(stay.events) == 0


def test_a_law_of_ones_own_is_as_fast_per_step_as_a_built_in_one_of_the_same_form():
    """The same tape: so the same operations in every step, and the same numbers."""

    @dataclass(frozen=True, repr=False)
    class Own(fl.Coulomb):
        v_s: float = fl.parameter(0.5, unit="m/s", meaning="decay speed", range=(0.01, 10.0))

        def kinetic(self, normal_force, speed):
            return (self.mu_k + (self.mu_s - self.mu_k) * exp(-speed / self.v_s)) * normal_force

    fl.testing.check_law(Own())
    own, built_in = in_slider(Own(mu_k=1.4)), in_slider(fl.ExponentialDecay(mu_k=1.4))
    one, other = (fl.simulate(model, 2.0, progress=False) for model in (own, built_in))
    np.testing.assert_array_equal(one.final_state, other.final_state)
    assert one.stats["steps"] == other.stats["steps"]


# --- what the suite refuses


@dataclass(frozen=True, repr=False)
class Wrong(fl.ContactLaw):
    stiff: float = fl.parameter(1.0, unit="N/m", meaning="stiffness", range=(0.0, 2.0))
    dark: float = fl.parameter(1.0, unit="N/m", range=(0.0, 2.0))

    def force(self, penetration):
        return self.stiff * penetration


@dataclass(frozen=True, repr=False)
class Pulling(fl.ContactLaw):
    stiff: float = fl.parameter(1.0, unit="N/m", meaning="stiffness", range=(0.0, 2.0))

    def force(self, penetration):
        return -self.stiff * penetration


@dataclass(frozen=True, repr=False)
class Different(fl.ContactLaw):
    stiff: float = fl.parameter(1.0, unit="N/m", meaning="stiffness", range=(0.0, 2.0))

    def force(self, penetration):
        return self.stiff * (penetration if isinstance(penetration, float) else penetration**3)


@dataclass(frozen=True, repr=False)
class Snapping(Pulling):
    def force(self, penetration):
        return self.stiff * penetration * (1 - 1024.0 * penetration**2)


@dataclass(frozen=True, repr=False)
class Driving(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return (self.mu_k - 0.0625 * speed) * normal_force


@dataclass(frozen=True, repr=False)
class Dipping(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return (self.mu_k * (1 - 2 * exp(-(((speed - 1.25) / 1e-4) ** 2)))) * normal_force


@dataclass(frozen=True, repr=False)
class Touching(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return self.mu_k * (1 - 2 * speed / 3 + speed**2 / 9) * normal_force


@dataclass(frozen=True, repr=False)
class Undefined(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force * float("nan")


@dataclass(frozen=True, repr=False)
class Endless(fl.Coulomb):
    def static_limit(self, normal_force):
        return normal_force * float("inf")


@dataclass(frozen=True, repr=False)
class Slippery(fl.Coulomb):
    def static_limit(self, normal_force):
        return 0.1 * self.mu_k * normal_force


@dataclass(frozen=True, repr=False)
class Singular(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force / speed


@dataclass(frozen=True, repr=False)
class WithIf(fl.Coulomb):
    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force if speed < 0.1 else 0.5 * self.mu_k * normal_force


@dataclass(frozen=True, repr=False)
class Explosive(fl.ImpactLaw):
    def impulse(self, material_rate, penetration_rate, compliance):
        return 3 * penetration_rate / compliance


@pytest.mark.plain_python
@pytest.mark.parametrize(
    ("law", "rule"),
    [
        (Wrong(), "parameter dark must have a meaning"),
        (Pulling(), "must be finite and not negative where the bodies press.* from 0 to 0.1 m"),
        (Snapping(), "where the bodies press on each other, also from 0.03125 to 0.1 m"),
        (Driving(mu_k=0.5), "must be finite and not negative, its direction.* from 8 to 100 m/s"),
        (Dipping(), r"from 1.24992 to 1.25008 m/s at a normal force of 1 N"),  # 1e-4 sqrt(ln 2) on each side
        (Driving(mu_k=0.5), r"or check_law\(law, max_speed=...\) must tell its smaller range"),
        (Undefined(), "kinetic must give a finite number at"),
        (Endless(), "static_limit must give a finite number"),
        (Different(), "must give the same for symbols"),
        (Slippery(), "must not exceed static_limit"),
        (Singular(), r"kinetic must give a finite number at \(.*0\.0.*\)"),
        (Explosive(), "from -1 times that before to 0"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_is_wrong_is_named(law, rule):
    with pytest.raises(AssertionError, match=rule):
        fl.testing.check_law(law)


@pytest.mark.plain_python
def test_what_is_no_formula_is_told_before_numbers_fail():
    with pytest.raises(TypeError, match=r"WithIf.kinetic must be a formula .* write fl.functions.piecewise"):
        fl.testing.check_law(WithIf())


@pytest.mark.plain_python
def test_a_law_is_sound_within_its_range_and_may_touch_zero():
    fl.testing.check_law(Driving(mu_k=0.5), max_speed=8.0)
    fl.testing.check_law(Snapping(stiff=1.0), max_penetration=0.03)
    fl.testing.check_law(Touching())


def test_a_model_is_no_law():
    with pytest.raises(TypeError, match="law must be a ContactLaw, FrictionLaw or ImpactLaw"):
        fl.testing.check_law(fl.SliderOnBelt())


@fl.model
class Bouncer(fl.Model):
    """A ball on a spring that lets go once it pulls with some force, as an automaton."""

    pull: float = fl.parameter(0.0, unit="N", meaning="pull", range=(0.0, 9.0))
    coordinates = ("x",)

    def release(self):
        """Above the ground."""
        return {"x": 0.5}

    def derive(self):
        """Contact and flight."""
        states = x, v = symbol("x"), symbol("x'")
        force = -100 * x
        let_go = fl.Event("F_N", force + self.pull, ("separation",))
        contact = fl.Mode("slip+", (v, force - 10), (let_go,), outputs={"normal_force": force})
        land = fl.Event("gap", x, ("slip+",))
        flight = fl.Mode("separation", (v, sp.Integer(-10)), (land,), outputs={"normal_force": sp.S.Zero})
        return fl.HybridAutomaton(states, (flight, contact), {}, 1)


def test_the_outputs_of_a_model_by_its_automaton_are_judged():
    fl.testing.check_model(Bouncer())
    with pytest.raises(AssertionError, match=r"F_N >= 0 in contact, got 'a miss of"):
        fl.testing.check_model(Bouncer(pull=5.0))


@fl.model
class Dripping(MechanicalModel):
    """A bead on a parabola on a trolley; its mass changes with time, and the flow may lack a term."""

    m: float = fl.parameter(1.0, unit="kg", symbol="m", meaning="mass", range=(0.1, 9.0), exclusive_minimum=0)
    lacking: str = ""
    coordinates = ("x", "y")

    def release(self):
        """Bead to the side, trolley in motion."""
        return {"y": 0.4, "x'": 0.3}

    def mechanics(self, q, v):
        """T of place and time."""
        bead = self.m * (1 + fl.functions.cos(q.phase) / 4)
        kinetic = 2 * v.x**2 / 2 + bead * ((v.x + v.y) ** 2 + (q.y * v.y) ** 2) / 2
        return Mechanics(kinetic, 9.81 * bead * q.y**2 / 2 + q.x**2 / 2, v.x**2 / 20, frequency=2.0)

    def derive(self):
        """The flow, less a part of the first or the second acceleration."""
        whole = super().derive()
        (mode,) = whole.modes
        flow, x, y = list(mode.flow), symbol("x'"), symbol("y'")
        flow[2] -= {"damping": x / 1000}.get(self.lacking, 0)
        flow[3] -= {"time": y * fl.functions.sin(symbol("phase")) / 100, "place": y**2 / 1e4}.get(
            self.lacking, 0
        )
        modes = (replace(mode, flow=tuple(flow)),)
        return HybridAutomaton(whole.states, modes, {}, whole.coordinates)


@pytest.mark.slow
def test_the_flow_of_the_energies_passes():
    fl.testing.check_model(Dripping(), t_end=3.0)


@pytest.mark.parametrize("lacking", slow_but(["place"], ["time", "place", "damping"]))
def test_a_flow_that_lacks_a_term_fails(lacking):
    with pytest.raises(AssertionError, match=r"Lagrange's equation of '[xy]' is not kept"):
        fl.testing.check_model(Dripping(lacking=lacking), t_end=3.0)
