"""Parameters: what a component knows about its numbers, and what it refuses."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, dataclass

import numpy as np
import pytest

from frictionlab.components import ContactLaw, Coulomb, CubicContact, LinearContact, PlasticImpact, parameter
from frictionlab.components.component import parameters_of, structure_of


@dataclass(frozen=True)
class Quintic(ContactLaw):
    """A student's law: one described parameter, one plain float, one exponent that is structure."""

    k5th: float = parameter(1e6, unit="N/m^5", symbol="k_5", meaning="quintic stiffness", minimum=0.0)
    k_lin: float = 10.0
    power: int = 5

    def force(self, penetration):
        """Normal force."""
        return self.k_lin * penetration + self.k5th * penetration**self.power


def test_fields_that_are_no_floats_are_structure():
    assert structure_of(PlasticImpact) == ("penetration_rate",)
    assert list(parameters_of(Quintic)) == ["k5th", "k_lin"]
    assert structure_of(Quintic) == ("power",)


def test_a_class_without_the_decorator_is_refused():
    class Forgotten(ContactLaw):
        k: float = 1.0

    with pytest.raises(TypeError, match=r"Forgotten .* @dataclass\(frozen=True\)"):
        Forgotten()

    class Constructed(ContactLaw):
        def __init__(self):
            self.k = 1.0

    with pytest.raises(TypeError, match=r"Constructed has fields .* without an __init__, and @dataclass"):
        parameters_of(Constructed)


@pytest.mark.parametrize("value", [True, "5", 1j, None, [1.0], np.array([1.0]), np.array(True)])
def test_what_is_no_real_number_is_a_type_error(value):
    with pytest.raises(TypeError, match=r"k2 must be one real number, got .*: give a float .*5000 N/m"):
        LinearContact(k2=value)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 10**400])
def test_what_is_not_finite_is_refused(value):
    with pytest.raises(ValueError, match="k2 must be a finite number, got"):
        LinearContact(k2=value)


def test_bounds_state_name_rule_value_and_cure():
    with pytest.raises(
        ValueError, match=r"^k_nl must be at least 0, got -1\.0: raise k_nl \(its default is 10000 N/m\^3\)$"
    ):
        CubicContact(k_nl=-1)
    with pytest.raises(
        ValueError, match=r"^mu_s must be at least mu_k \(2\.5\), got 2\.0: raise mu_s or lower mu_k$"
    ):
        Coulomb(mu_k=2.5, mu_s=2.0)


def test_numbers_of_any_kind_become_floats():
    assert LinearContact(k2=np.float32(2.0)) == LinearContact(k2=2) == LinearContact(2.0)
    assert type(LinearContact(k2=np.int64(2)).k2) is float


def test_components_are_frozen_and_compare_by_value():
    assert hash(Coulomb(0.5, 1.0)) == hash(Coulomb(0.5, 1.0))
    assert LinearContact() != CubicContact()
    with pytest.raises(FrozenInstanceError):
        Coulomb().mu_k = 1.0  # type: ignore[misc]  # what is tested


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: parameter("5"), TypeError, "must be a number, got '5': give a float"),
        (lambda: parameter(True), TypeError, "must be a number, got True"),
        (lambda: parameter(5.0, range=(2, 1)), ValueError, r"two numbers in ascending order, got \(2, 1\)"),
        (lambda: parameter(5.0, range=3.0), ValueError, "two numbers in ascending order, got 3.0"),
        (lambda: parameter(5.0, range=(0, 9), log=True), ValueError, "above 0 where log=True, got"),
    ],
)
def test_a_parameter_that_cannot_be_one_is_refused_where_it_is_written(make, error, message):
    with pytest.raises(error, match=message):
        make()
