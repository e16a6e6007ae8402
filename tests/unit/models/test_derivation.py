"""The automaton that a model becomes: modes, guards, resets, and what models share."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pytest
import sympy

import frictionlab as fl
from frictionlab.components import (
    FixedLoad,
    PlasticImpact,
    RestitutionImpact,
    SlidingOnly,
    SlidingSeparation,
)
from frictionlab.models import SliderOnBelt
from frictionlab.models.mechanical.mechanics import Mechanics, Stop
from tests.helpers.cases import slow_but

TOGGLES = [names for size in range(4) for names in combinations(("cubic", "nonsmooth", "geometry"), size)]


def numbers(automaton, expressions, state):
    """The expressions as floats at a state."""
    values = dict(zip(automaton.states, state, strict=True)) | dict(automaton.parameters)
    return np.array([float(sympy.sympify(e).subs(values)) for e in expressions])


def mode_of(automaton, name):
    """The mode of that name."""
    return next(mode for mode in automaton.modes if mode.name == name)


def right_hand_side(p, state, friction):
    """Eq. (1) by hand: accelerations for a friction law F_T(F_N, v_r), or None for flight."""
    x1, y1, x2, y2, phi, dx1, dy1, dx2, dy2, dphi = state
    gap = y2 - (x1 - x2) * phi - y1
    normal = 0.0 if friction is None else p["k2"] * gap + p["k_nl"] * gap**3
    tangential = 0.0 if friction is None else friction(normal)
    first = p["c5"] * (dy2 + p["l1"] * dphi) + p["k5"] * (y2 + p["l1"] * phi)
    second = p["c6"] * (dy2 - p["l2"] * dphi) + p["k6"] * (y2 - p["l2"] * phi)
    return [
        (tangential - p["c1"] * dx1 - p["k1"] * x1 - p["k3"] * (x1 - y1) / 2) / p["M"],
        (normal - p["F"] - p["c2"] * dy1 + p["k3"] * (x1 - y1) / 2) / p["M"],
        (-tangential - p["c4"] * dx2 - p["k4"] * x2) / p["m"],
        (-normal - first - second) / p["m"],
        (normal * (x1 - x2) - p["l1"] * first + p["l2"] * second) / p["J"],
    ]


@pytest.mark.parametrize(
    "given",
    [
        {"kinetic": "x**2"},
        {"kinetic": 0, "potential": {"spring": "x**2"}},
        {"kinetic": 0, "loads": {"x": "F"}},
        {"kinetic": 0, "contacts": (Stop("x", PlasticImpact()),)},
    ],
)
def test_a_text_is_no_energy_load_or_contact(given):
    """sympy would run it as Python."""
    with pytest.raises(TypeError, match="must be expressions, got the text"):
        Mechanics(**given)


@pytest.fixture
def state():
    """Some state of the 5-degree-of-freedom model."""
    return np.random.default_rng(2020).normal(size=10) * 0.1


UNEVEN = SliderOnBelt(mu_k=1.4, M=2, m=3, J=0.3, c5=0.4, l1=0.1, l2=0.3, k6=2e4, c1=0.7)


@pytest.mark.parametrize("name", slow_but(["slip-", "separation"], ["slip+", "slip-", "separation"]))
def test_the_flow_is_equation_1(name, state):
    automaton = UNEVEN.automaton()
    friction = {"slip+": lambda n: 1.4 * n, "slip-": lambda n: -1.4 * n, "separation": None}[name]
    expected = [*state[5:], *right_hand_side(UNEVEN.parameters, state, friction)]
    np.testing.assert_allclose(numbers(automaton, mode_of(automaton, name).flow, state), expected, rtol=1e-12)


def test_stick_moves_both_bodies_alike_under_its_own_friction_force(state):
    automaton = UNEVEN.automaton()
    stick = mode_of(automaton, "stick")
    assert stick.flow[5] is stick.flow[7]
    (force,) = numbers(automaton, [stick.outputs["friction_force"]], state)
    expected = right_hand_side(UNEVEN.parameters, state, lambda n: force)
    np.testing.assert_allclose(numbers(automaton, stick.flow[5:], state), expected, rtol=1e-12)
    assert stick.constraints == (stick.outputs["relative_velocity"],)


def test_states_modes_and_coordinates():
    automaton = SliderOnBelt().automaton()
    assert [s.name for s in automaton.states] == "x1 y1 x2 y2 phi x1' y1' x2' y2' phi'".split()
    assert automaton.names == ("stick", "slip+", "slip-", "separation", "chatter")
    assert [mode.name for mode in automaton.modes if mode.limit] == ["chatter"]
    assert automaton.coordinates == 5
    parameters = {s.name: v for s, v in automaton.parameters.items()}
    assert parameters == {**SliderOnBelt().parameters, "chatter": 0.0}


def test_events_and_their_targets():
    automaton = SliderOnBelt().automaton()
    table = {mode.name: {e.name: e.targets for e in mode.events} for mode in automaton.modes}
    assert table == {
        "stick": {"cone+": ("slip+",), "cone-": ("slip-",), "gap": ("separation",)},
        "slip+": {"v_r": ("stick", "slip-"), "gap": ("separation",)},
        "slip-": {"v_r": ("stick", "slip+"), "gap": ("separation",)},
        "separation": {"gap": ("slip+", "slip-", "stick")},
        "chatter": {"leaving rate": ("slip+", "slip-", "stick"), "flight": ("separation",)},
    }


def test_event_functions():
    automaton = SliderOnBelt().automaton()
    v_r = automaton.modes[0].outputs["relative_velocity"]
    assert automaton.names[:4] == ("stick", "slip+", "slip-", "separation")
    for mode in automaton.modes[:4]:
        out, functions = mode.outputs, {e.name: e.function for e in mode.events}
        sign = {"slip+": 1, "slip-": -1}.get(mode.name)
        if sign:
            assert functions["v_r"] == sign * v_r
        if mode.name == "stick":
            limit = sympy.Symbol("mu_s", real=True) * out["normal_force"]
            assert functions["cone+"] == limit - out["friction_force"]
            assert functions["cone-"] == limit + out["friction_force"]
        assert functions["gap"] == (-1 if mode.name == "separation" else 1) * out["penetration"]


@pytest.mark.parametrize("names", TOGGLES)
def test_toggles_assemble(names):
    automaton = SliderOnBelt().without(*names).automaton()
    assert len(automaton.states) == (8 if "geometry" in names else 10)
    if "nonsmooth" in names:
        (mode,) = automaton.modes
        assert (mode.name, mode.events) == ("slip", ())
    assert {tuple(mode.outputs) for mode in automaton.modes} == {
        ("penetration", "gap", "normal_force", "friction_force", "relative_velocity")
    }
    used = set().union(*(sympy.sympify(e).free_symbols for mode in automaton.modes for e in mode.flow))
    assert used <= {*automaton.states, *automaton.parameters}


def test_the_smooth_linear_scene_is_affine():
    automaton = SliderOnBelt().without("cubic", "geometry", "nonsmooth").automaton()
    for row in automaton.modes[0].flow:
        assert all(not sympy.diff(row, a).has(*automaton.states) for a in automaton.states)


def test_sliding_only_has_the_sign_of_the_belts_speed(state):
    for speed, sign in ((2.0, 1), (-2.0, -1)):
        model = SliderOnBelt(v=speed, interface=SlidingOnly())
        out = model.automaton().modes[0].outputs
        normal, friction = numbers(model.automaton(), [out["normal_force"], out["friction_force"]], state)
        assert friction == pytest.approx(sign * 0.3 * normal)


@pytest.mark.parametrize("interface", [SlidingOnly(), SlidingSeparation()], ids=repr)
def test_what_only_slides_needs_a_belt_that_moves(interface):
    """Friction has no direction at rest, and counted as zero before."""
    with pytest.raises(ValueError, match="contact 1 of SliderOnBelt must rub a belt that moves"):
        SliderOnBelt(v=0.0, interface=interface).automaton()
    assert "stick" in SliderOnBelt(v=0.0).automaton().names


def test_models_of_one_structure_share_their_modes():
    first = SliderOnBelt(mu_k=1.4).automaton()
    second = SliderOnBelt(mu_k=2.5, F=50, k_nl=0).automaton()
    assert second.modes is first.modes
    assert second.states is first.states
    assert second.parameters[sympy.Symbol("mu_k", real=True)] == 2.5
    assert SliderOnBelt(impact=PlasticImpact("full")).automaton().modes is not first.modes
    assert SliderOnBelt().without("geometry").automaton().modes is not first.modes


def test_the_projection_keeps_momentum_and_ends_the_relative_motion(state):
    automaton = UNEVEN.automaton()
    (reset,) = (e.reset for e in mode_of(automaton, "slip+").events if e.name == "v_r")
    after = dict(zip(reset.jump, numbers(automaton, reset.jump.values(), state), strict=True))
    slider, belt = (after[automaton.states[i]] for i in (5, 7))
    assert belt == pytest.approx(slider - 1.0)
    assert 2 * slider + 3 * belt == pytest.approx(2 * state[5] + 3 * state[7])
    assert len(after) == 2


def recontact(model):
    """The event that ends flight."""
    (event,) = mode_of(model.automaton(), "separation").events
    return event


def rates_after(model, reset, state):
    """Material and full gap rate after a reset, and the gap's expression."""
    automaton = model.automaton()
    jumped = dict(zip(automaton.states, state, strict=True))
    jumped |= dict(zip(reset.jump, numbers(automaton, reset.jump.values(), state), strict=True))
    x1, _, x2, _, phi, dx1, dy1, dx2, dy2, dphi = jumped.values()
    material = dy2 - (x1 - x2) * dphi - dy1
    return material, material - (dx1 - dx2) * phi


def test_equation_13_zeroes_the_material_rate_only(state):
    event = recontact(UNEVEN)
    material, full = rates_after(UNEVEN, event.reset, state)
    assert material == pytest.approx(0, abs=1e-15)
    assert abs(full) > 1e-4
    gap = UNEVEN.automaton().modes[0].outputs["penetration"]
    assert event.reset.vanishing == {gap: 1, -gap: 1}


def test_the_accumulation_zeroes_the_full_rate(state):
    event = recontact(UNEVEN)
    assert rates_after(UNEVEN, event.accumulation, state)[1] == pytest.approx(0, abs=1e-15)
    assert set(event.accumulation.vanishing.values()) == {2}


@pytest.mark.parametrize(
    ("impact", "geometry", "order"),
    [
        (PlasticImpact("material"), "off", 2),
        (PlasticImpact("full"), "off", 2),
        (PlasticImpact("full"), "on", 2),
        (RestitutionImpact(0.5), "on", 1),
        (RestitutionImpact(0.5), "off", 1),
        (RestitutionImpact(0.0), "on", 2),
    ],
)
def test_how_many_coefficients_of_the_gap_vanish_after_the_impact(impact, geometry, order):
    model = SliderOnBelt(impact=impact)
    model = model.replace(geometry=FixedLoad()) if geometry == "off" else model
    assert set(recontact(model).reset.vanishing.values()) == {order}


def test_restitution_reverses_the_gap_rate(state):
    model = UNEVEN.replace(impact=RestitutionImpact(0.4))
    x1, _, x2, _, phi, dx1, dy1, dx2, dy2, dphi = state
    before = dy2 - (x1 - x2) * dphi - dy1 - (dx1 - dx2) * phi
    assert rates_after(model, recontact(model).reset, state)[1] == pytest.approx(-0.4 * before)


@fl.model
class TwoArms(fl.MechanicalModel):
    """A double pendulum by its angles from the vertical."""

    m1: float = 1.2
    m2: float = 0.7
    l1: float = 0.9
    l2: float = 0.6
    g: float = 9.81
    coordinates = ("a", "b")

    def mechanics(self, q, v):
        cos, sin = fl.functions.cos, fl.functions.sin
        x = self.l1 * cos(q.a) * v.a + self.l2 * cos(q.b) * v.b
        y = self.l1 * sin(q.a) * v.a + self.l2 * sin(q.b) * v.b
        height = -(self.m1 + self.m2) * self.l1 * cos(q.a) - self.m2 * self.l2 * cos(q.b)
        return Mechanics(
            kinetic=self.m1 * (self.l1 * v.a) ** 2 / 2 + self.m2 * (x**2 + y**2) / 2,
            potential=self.g * height,
        )


def test_masses_that_turn_are_inverted_as_numbers_are():
    """Accelerations of a double pendulum by its textbook equations, solved by numpy."""
    p, (a, b, va, vb) = TwoArms(), (0.7, -1.1, 2.0, -3.0)
    automaton = p.automaton()
    c, s = p.m2 * p.l1 * p.l2 * np.cos(a - b), p.m2 * p.l1 * p.l2 * np.sin(a - b)
    mass = [[(p.m1 + p.m2) * p.l1**2, c], [c, p.m2 * p.l2**2]]
    loads = [
        -s * vb**2 - (p.m1 + p.m2) * p.g * p.l1 * np.sin(a),
        s * va**2 - p.m2 * p.g * p.l2 * np.sin(b),
    ]
    state = [a, b, va, vb, *[0.0] * (len(automaton.states) - 4)]
    accelerations = numbers(automaton, automaton.modes[0].flow[2:4], state)
    np.testing.assert_allclose(accelerations, np.linalg.solve(mass, loads), rtol=1e-13)


@fl.model
class PinOnTrack(fl.MechanicalModel):
    """A pin on a disc whose friction coefficient varies round the track."""

    k: float = 2.0
    c: float = 0.3
    mu: float = 0.4
    a: float = 0.3
    Omega: float = 0.8
    coordinates = ("x",)

    def mechanics(self, q, v):
        mu = self.mu * (1 + self.a * fl.functions.cos(q.phase))
        rubbing = fl.Friction(3.0 - v.x, 1.5, fl.Coulomb(mu_k=mu, mu_s=2 * mu))
        dampers = self.c * v.x**2 / 2
        return fl.Mechanics(
            v.x**2 / 2, self.k * q.x**2 / 2, dampers, contacts=(rubbing,), frequency=self.Omega
        )


def test_a_coefficient_of_friction_may_be_an_expression_in_mechanics_and_nowhere_else():
    model = PinOnTrack()
    orbit = fl.periodic_orbit(model, fl.simulate(model, 100.0, progress=False))
    exact = model.a * model.mu * 1.5 / math.hypot(model.k - model.Omega**2, model.c * model.Omega)
    x = orbit.trajectory(np.linspace(0.0, orbit.period, 4001))[:, 0]
    assert np.ptp(x) / 2 == pytest.approx(exact, rel=1e-6)
    fl.testing.check_model(model)
    b = sympy.Symbol("b")
    for make in (fl.MassOnBelt, fl.Coulomb, lambda mu_k: fl.BeamOnBelt(friction=fl.Coulomb(mu_k, 0.1))):
        with pytest.raises(TypeError, match="mu_k must be one real number, got b"):
            make(mu_k=b)


@dataclass(frozen=True)
class Delegating(fl.FrictionLaw):
    """Coulomb's law, by one that it makes of its own parameters."""

    mu_k: float = 0.3
    mu_s: float = 0.4

    def kinetic(self, normal_force, speed):
        return fl.Coulomb(self.mu_k, self.mu_s).kinetic(normal_force, speed)

    def static_limit(self, normal_force):
        return dataclasses.replace(fl.Coulomb(), mu_s=self.mu_s).static_limit(normal_force)


def test_a_law_may_return_the_formula_of_another():
    laws = Delegating(), fl.Coulomb(0.3, 0.4)
    runs = [fl.simulate(fl.MassOnBelt(friction=law), 20.0, progress=False) for law in laws]
    assert runs[0].states.tobytes() == runs[1].states.tobytes()
    fl.testing.check_law(Delegating())
    laws = (lambda mu, q, f: Delegating(mu, 2 * mu)), (lambda mu, q, f: fl.Coulomb(mu, 2 * mu))
    runs = [fl.simulate(MadeLaw(law=law), 5.0, progress=False) for law in laws]
    assert runs[0].states.tobytes() == runs[1].states.tobytes()


@fl.model
class Pressed(fl.MechanicalModel):
    """A mass on a contact whose force a function gives."""

    mu: float = 3.0
    force: object = None
    coordinates = ("x",)

    def mechanics(self, q, v):
        contact = fl.Contact(q.x, lambda d: self.force(self.mu, d), damper=lambda d: self.force(0.1, 1.0))
        return fl.Mechanics(v.x**2 / 2, contacts=(contact,), loads={"x": 1.0})


def test_a_force_may_be_that_of_a_law_made_of_parameters():
    forces = (lambda k, d: fl.LinearContact(k2=k).force(d)), (lambda k, d: k * d)
    runs = [fl.simulate(Pressed(force=one), 5.0, progress=False) for one in forces]
    assert runs[0].states.tobytes() == runs[1].states.tobytes()


@fl.model
class MadeLaw(fl.MechanicalModel):
    """A mass on a belt, and above a stop, with a law that a function makes of mu, q and functions."""

    mu: float = 0.5
    law: object = None
    coordinates = ("x",)

    def mechanics(self, q, v):
        law = self.law(self.mu, q, fl.functions)
        if isinstance(law, fl.ImpactLaw):
            contact = fl.Stop(q.x, law)
        elif isinstance(law, fl.FrictionLaw):
            contact = fl.Friction(3.0 - v.x, 1.5, law)
        else:
            contact = fl.Contact(q.x, law.force)
        return fl.Mechanics(v.x**2 / 2, contacts=(contact,), frequency=1.0)


@pytest.mark.parametrize(
    ("law", "x", "message"),
    [
        (lambda mu, q, f: fl.Coulomb(mu - 1, mu), 1.0, "mu_k must be at least 0, got -0.5"),
        (lambda mu, q, f: fl.Coulomb(2 * mu, mu), 1.0, "mu_s must be at least mu_k"),
        (lambda mu, q, f: fl.ExponentialDecay(0.5, 0.1, v_s=mu), 1.0, "mu_s must be at least mu_k"),
        (lambda mu, q, f: fl.Coulomb(mu * (1 + 3 * f.sin(q.phase)), 2), 1.0, "mu_k must be .* phase = 3.53"),
        (lambda mu, q, f: fl.ExponentialDecay(0.5, 0.1, v_s=q.x**2), 1.0, "mu_s must be at least mu_k"),
        (lambda mu, q, f: fl.Coulomb(q.x, 3), -1.0, r"mu_k must be at least 0, got -1.* mu_k = x, .* x = -1"),
        (lambda mu, q, f: fl.Coulomb(sympy.Symbol("b"), 3), 1.0, "mu_k of the Coulomb .* depend on b"),
        (lambda mu, q, f: fl.RestitutionImpact(3 * mu), 1.0, "e must be at most 1, got 1.5"),
        (lambda mu, q, f: fl.LinearContact(-mu), 1.0, "k2 must be at least 0, got -0.5"),
    ],
)
def test_rules_of_laws_hold_for_expressions_too(law, x, message):
    model = MadeLaw(law=law)
    with pytest.raises(ValueError, match=message):
        fl.simulate(model, 1.0, x0={"x": x}, progress=False)


@pytest.mark.parametrize(
    "zero",
    [
        lambda mu, q, f: mu - 3 * q.x,  # 0.3 - 3 * 0.1 = -5.6e-17
        lambda mu, q, f: mu * (1 - f.cos(q.phase) ** 2 - f.sin(q.phase) ** 2),
    ],
)
def test_rounding_of_a_coefficient_that_is_zero_breaks_no_rule(zero):
    model = MadeLaw(mu=0.3, law=lambda *given: fl.Coulomb(zero(*given), 0.5))
    assert fl.simulate(model, 1e-3, x0={"x": 0.1}, progress=False).status.ok


def test_a_coefficient_of_friction_may_change_in_time():
    model = MadeLaw(law=lambda mu, q, f: fl.Coulomb(fl.ramp(q.t, mu, 2 * mu, 4.0), 2 * mu))
    run = fl.simulate(model, 1.0, progress=False)
    assert run["x'"][-1] == pytest.approx(1.5 * model.mu * (1 + 1 / 8), rel=1e-12)
