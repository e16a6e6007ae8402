"""The rules of parameters as a page has them: which there are, and what is left to Python."""

import json
import re
from dataclasses import dataclass

import pytest
from sympy import cos, sin

import frictionlab as fl
from frictionlab.pages.cases import rule_data
from frictionlab.pages.export import text_of
from frictionlab.pages.page_data import structure_data
from tests.unit.pages.test_javascript import run_in_node


def words(model):
    found = rule_data(model, tuple(model.automaton().parameters))
    return ["?".join(each["message"][::2]) for each in found["cases"]]


def test_bounds_and_the_rule_between_two_coefficients():
    found = words(fl.SliderOnBelt())
    assert "mu_s must be at least mu_k (?), got ?: raise mu_s or lower mu_k" in found
    assert "M must be greater than 0, got ?: raise M (its default is 1 kg)" in found


@dataclass(frozen=True)
class Banded(fl.FrictionLaw):
    mu_k: float = fl.parameter(0.5, symbol="mu_k")
    low: float = fl.parameter(0.1, symbol="low")
    high: float = fl.parameter(0.9, symbol="high")

    def check(self):
        if self.low < self.mu_k < self.high:
            return
        if self.mu_k == self.low or not self.mu_k - self.high:
            raise ValueError(f"mu_k must not be {self.mu_k:g}")
        raise ValueError(f"mu_k must be within {self.low} and {self.high}")

    def kinetic(self, normal_force, speed):
        return self.mu_k * normal_force

    def static_limit(self, normal_force):
        return self.mu_k * normal_force


def test_every_way_to_a_message_is_found():
    found = words(fl.MassOnBelt(friction=Banded()))
    assert found.count("mu_k must not be ?") == 4  # either comparison of two, after either of the band's
    assert found.count("mu_k must be within ? and ?") == 2


@dataclass(frozen=True)
class Counting(Banded):
    def check(self):
        if len(str(float(self.mu_k))) > 5:
            raise ValueError("mu_k must be short")


def test_what_is_no_comparison_of_formulas_is_left_to_python():
    assert not [each for each in words(fl.MassOnBelt(friction=Counting())) if "mu_k" in each]


@fl.model
class Plain(fl.MechanicalModel):
    """Its parameters have no bounds."""

    m: float = 1.0
    c: float = 0.1
    N: float = 2.0
    v: float = 0.5
    ratio: float = 3.0
    order: float = 2.0
    rate: float = 1.5
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    coordinates = ("x",)

    def mechanics(self, q, v):
        rubbing = fl.Friction(self.v - v.x, self.N, self.friction)
        loads = {"x": cos(self.ratio * q.phase) + q.x * sin(self.order * q.phase) - sin(2 * q.phase)}
        energies = self.m * v.x**2 / 2, q.x**2 / 2, self.c * v.x**2 / 2
        return fl.Mechanics(*energies, (rubbing,), loads=loads, frequency=self.rate)


def said_on_page(model, symbols, values):
    """The message of a page of the model where its parameters are set to values."""
    functions, *scripts = (text_of(f"{script}.js") for script in ("functions", "browser_engine"))
    rules, given = rule_data(model, symbols), [values.get(one.name, 0.0) for one in symbols]
    return run_in_node(
        f"""{functions}{"".join(scripts)}
        Object.assign(F, {{ sin: Math.sin, cos: Math.cos }}); // of the kernels on a page
        const rules = {{ numbers: {rules["numbers"]}, cases: {json.dumps(rules["cases"])} }};
        console.log(JSON.stringify(brokenRule({{ rules }}, {json.dumps(given)})));"""
    )


@pytest.mark.parametrize(("name", "value"), [("mu_s_inner", 0.2), ("mu_k_inner", 0.4), ("alpha", -1.0)])
def test_rules_of_laws_at_a_structure_are_said_in_the_same_words(name, value):
    """Each group of contacts has its own; those of the other one hold."""
    rubbing = {"tangential": [[1.0, 0.0]], "normal": [[0.0, 1.0]], "friction": fl.Coulomb(0.3, 0.4)}
    held = fl.SlidingContacts([[1.0, 1.0]], N=2.0, friction=fl.Coulomb(0.1, 0.2), name="outer")
    pads = [fl.SlidingContacts(**rubbing, name="inner"), held]
    structure = fl.Structure([[1, 0], [0, 1]], [[2, 0], [0, 2]], fl.RayleighDamping(0.1), contacts=pads)
    shown = fl.explore(structure, panels=["response"], t_end=0.1).model
    values = {**structure.parameters, name: value}
    try:
        structure.replace(**{name: value})
        expected = None
    except ValueError as error:
        expected = str(error)
    assert (expected is None) == (name == "mu_k_inner")
    assert said_on_page(shown, tuple(shown.parameters), values) == expected


@pytest.mark.parametrize(
    ("name", "value", "rule"),
    [
        ("m", 0.0, "the mass of 'x' is 0 at m = 0"),
        ("m", -1.0, "the mass of 'x' is -1 at m = -1"),
        ("c", -1.0, "the damper of 'x' is -1"),
        ("N", -1.0, "must be at least 0, got -1"),
        ("ratio", 2.5, "must have its period, 2 pi"),
        ("order", 2.01, "must have its period, 2 pi"),
        ("ratio", 0.3 / 0.1, ""),  # 2.9999999999999996
        ("order", -1.0, ""),
        ("rate", -1.5, "must be at least 0, got -1.5 at rate = -1.5"),
        ("rate", 0.0, ""),
        ("c", 0.0, ""),
        ("N", 0.0, ""),
    ],
)
def test_masses_loads_dampers_and_normal_forces_are_refused_in_the_same_words(name, value, rule):
    model = Plain(**{name: value})
    said = said_on_page(Plain(), tuple(Plain().automaton().parameters), model.parameters)
    if not rule:
        fl.simulate(model, 0.1)
        assert said is None
        return
    with pytest.raises(ValueError, match=re.escape(rule)) as error:
        fl.simulate(model, 0.1)
    assert said == str(error.value)
    explorer = fl.explore(Plain(), panels=["response"], t_end=1.0)
    explorer.controls[name].value = value
    assert str(explorer.error) == said
    assert abs(explorer.widget.limits[name] - (getattr(Plain(), name) if "period" in rule else 0.0)) < 1e-6


@fl.model
class TwoDampers(fl.MechanicalModel):
    """Dampers of two masses that are coupled."""

    c1: float = 0.5
    c2: float = 0.5
    c12: float = 0.0
    relative: float = 0.0
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        own = self.c1 * v.x**2 + self.c2 * v.y**2 + self.relative * (v.x - v.y) ** 2
        return fl.Mechanics((v.x**2 + v.y**2) / 2, (q.x**2 + q.y**2) / 2, own / 2 + self.c12 * v.x * v.y)


@fl.model
class Driven(fl.MechanicalModel):
    coordinates = ("x",)

    def mechanics(self, q, v):
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, -0.25 * v.x**2)


@pytest.mark.parametrize(
    ("model", "rule"),
    [
        (TwoDampers(c12=-0.6), "that of 'x' and 'y' together is"),
        (TwoDampers(c1=-0.05, c2=0.0, relative=0.1), "that of 'x' and 'y' together is"),
        (TwoDampers(c1=0.0, c12=0.1), "that of 'x' and 'y' together is"),
        (Driven(), "the damper of 'x' is -0.5"),
        (TwoDampers(c12=-0.5), ""),
        (TwoDampers(c1=0.0, c2=0.0, relative=0.1), ""),
        (TwoDampers(c1=0.0, c2=0.0), ""),
    ],
)
def test_no_motion_has_negative_dissipation(model, rule):
    """The least eigenvalue of [[c1 + r, c12 - r], [c12 - r, c2 + r]] is at least zero."""
    if not rule:
        model.automaton()
        return
    with pytest.raises(ValueError, match=f"must not be negative for any motion, and {rule}.* as a load"):
        model.automaton()


def test_the_python_of_a_page_has_the_law_of_ones_own_and_the_values_that_are_set():
    model, names = fl.MassOnBelt(friction=Banded()), {}
    text = structure_data(model)["python"].replace("\0duration\0", "2.0").replace("\0start\0", "'near'")
    values = model.parameters | {"mu_k": 0.7, "m": 2.0}
    exec(re.sub("\0(.*?)\0", lambda place: repr(values[place[1]]), text), names)
    assert names["model"] == model.replace(mu_k=0.7, m=2.0)
    assert (names["run"].raw.t, names["run"].status.ok) == (2.0, True)
