"""The rules of parameters as a page has them: which there are, and what is left to Python."""

from dataclasses import dataclass

import frictionlab as fl
from frictionlab.pages.javascript import rule_data


def words(model):
    found = rule_data(model, tuple(model.automaton().parameters))
    return ["?".join(each["message"][::2]) for each in found["words"]]


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
