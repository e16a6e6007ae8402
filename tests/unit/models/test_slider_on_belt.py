"""The model as a value: keywords, copies, toggles, descriptions, data."""

from __future__ import annotations

import dataclasses
import inspect
from dataclasses import dataclass
from itertools import combinations

import pytest

from frictionlab.components import (
    ContactLaw,
    Coulomb,
    CubicContact,
    FixedLoad,
    LinearContact,
    PlasticImpact,
    SlidingOnly,
    StickSlip,
)
from frictionlab.models import SliderOnBelt

TABLE_1 = {"M": 1, "m": 1, "J": 0.1, "v": 1, "k1": 1e4, "k2": 5e3, "k3": 6e3, "k4": 1e4, "k5": 1e4, "k6": 1e4}
TABLE_1 |= {"l1": 0.2, "l2": 0.2} | dict.fromkeys(["c1", "c2", "c4", "c5", "c6"], 0.1)
BASE = TABLE_1 | {"mu_s": 3, "k_nl": 1e4, "F": 200, "mu_k": 0.3}


def test_defaults_are_table_1():
    assert dict(SliderOnBelt().parameters) == BASE


def test_every_parameter_is_a_keyword_wherever_it_lives():
    model = SliderOnBelt(mu_k=1.4, F=100, k_nl=1e7)
    assert (model.friction.mu_k, model.F, model.contact.k_nl) == (1.4, 100.0, 1e7)
    assert model.mu_k == 1.4
    assert set(inspect.signature(SliderOnBelt).parameters) == {*BASE, *SliderOnBelt.roles}
    assert {"mu_k", "F"} <= set(dir(model))


def test_parameters_are_read_only():
    with pytest.raises(TypeError):
        SliderOnBelt().parameters["F"] = 1.0  # type: ignore[index]  # what is tested
    with pytest.raises(dataclasses.FrozenInstanceError, match=r"'F': .* model = model.replace\(F=\.\.\.\)"):
        SliderOnBelt().F = 1.0  # type: ignore[misc]  # what is tested
    unknown = "SliderOnBelt has no parameter 'mu_kk': did you mean 'mu_k'.*never changes"
    with pytest.raises(dataclasses.FrozenInstanceError, match=unknown):
        SliderOnBelt().mu_kk = 1.0  # type: ignore[attr-defined]  # what is tested


def test_models_compare_and_hash_by_value():
    assert SliderOnBelt(F=200) == SliderOnBelt(F=200.0)
    assert hash(SliderOnBelt(mu_k=1)) == hash(SliderOnBelt(friction=Coulomb(mu_k=1)))
    assert SliderOnBelt(mu_k=1) != SliderOnBelt()
    assert SliderOnBelt() != SliderOnBelt(geometry=FixedLoad())


def test_replace_makes_a_new_model():
    model = SliderOnBelt(mu_k=1.4)
    other = model.replace(mu_k=2.5, contact=LinearContact(k2=6e3))
    assert (model.mu_k, other.mu_k, other.k2) == (1.4, 2.5, 6e3)
    assert "k_nl" not in other.parameters
    assert other.replace(mu_k=1.4, contact=CubicContact()) == model
    assert dataclasses.replace(model, mu_k=2.5).mu_k == 2.5


def test_a_new_component_brings_its_values_and_keywords_overwrite_them():
    assert SliderOnBelt(k2=1e3).replace(contact=LinearContact()).k2 == 5e3
    assert SliderOnBelt().replace(friction=Coulomb(mu_k=1.0, mu_s=2.0), mu_k=1.5).friction == Coulomb(
        1.5, 2.0
    )


def test_toggles_swap_components_in_any_combination():
    model = SliderOnBelt(k2=7e3)
    swapped = {"cubic": ("contact", LinearContact(7e3)), "nonsmooth": ("interface", SlidingOnly())}
    swapped["geometry"] = ("geometry", FixedLoad())
    for size in range(4):
        for names in combinations(swapped, size):
            assert model.without(*names) == model.replace(**dict(swapped[name] for name in names))
    assert model.without("cubic").without("cubic") == model.without("cubic")
    assert model.without("geometry").coordinates == ("x1", "y1", "x2", "y2")


@pytest.mark.parametrize(
    ("keywords", "error", "message"),
    [
        ({"mu_kk": 1.0}, TypeError, "SliderOnBelt has no parameter 'mu_kk': did you mean 'mu_k'"),
        ({"f": 1.0}, TypeError, "did you mean 'F'"),
        ({"e": 0.5}, TypeError, "belongs to RestitutionImpact, and impact is PlasticImpact"),
        ({"M": 0.0}, ValueError, r"M must be greater than 0, got 0\.0: raise M"),
        ({"J": -1.0}, ValueError, "J must be greater than 0"),
        ({"k2": -1.0}, ValueError, "k2 must be at least 0"),
        ({"mu_k": -0.1}, ValueError, "mu_k must be at least 0"),
        (
            {"mu_k": 3.5},
            ValueError,
            r"mu_s must be at least mu_k \(3\.5\), got 3\.0: raise mu_s or lower mu_k",
        ),
        ({"F": float("nan")}, ValueError, "F must be a finite number, got nan"),
        ({"F": "200"}, TypeError, r"F must be one real number, got '200' \(str\)"),
        ({"contact": CubicContact}, TypeError, r"got the class CubicContact: write CubicContact\(\)"),
        ({"contact": Coulomb()}, TypeError, r"contact must be a ContactLaw, got Coulomb"),
        ({"contact": None}, TypeError, "contact must be a ContactLaw, got None"),
    ],
)
def test_what_is_wrong_is_said(keywords, error, message):
    with pytest.raises(error, match=message):
        SliderOnBelt(**keywords)
    with pytest.raises(error, match=message):
        SliderOnBelt().replace(**keywords)


def test_names_must_be_unique():
    @dataclass(frozen=True)
    class Clash(ContactLaw):
        k1: float = 1.0

    @dataclass(frozen=True)
    class State(ContactLaw):
        x1: float = 1.0

    with pytest.raises(ValueError, match="parameter 'k1' of Clash must differ"):
        SliderOnBelt(contact=Clash())
    with pytest.raises(ValueError, match="named like the coordinate 'x1'"):
        SliderOnBelt(contact=State())


def test_repr_shows_what_differs_and_makes_the_model_again():
    assert repr(SliderOnBelt()) == "SliderOnBelt()"
    assert repr(SliderOnBelt(mu_k=1.4, F=200)) == "SliderOnBelt(mu_k=1.4)"
    full = PlasticImpact(penetration_rate="full")
    for model in (
        SliderOnBelt(F=1, impact=full),
        SliderOnBelt(interface=StickSlip(), k_nl=0).without("geometry"),
    ):
        names = {"SliderOnBelt": SliderOnBelt, "FixedLoad": FixedLoad, "StickSlip": StickSlip}
        assert eval(repr(model), names | {"PlasticImpact": PlasticImpact}) == model


def test_reading_a_model_makes_nothing_but_components():
    data = SliderOnBelt().to_dict()
    data["fields"]["contact"] = {"class": "subprocess:Popen", "fields": {"args": "true"}}
    with pytest.raises(ValueError, match="no ContactLaw 'subprocess:Popen' is loaded: import subprocess"):
        SliderOnBelt.from_dict(data)
    data["fields"]["contact"] = {"class": "frictionlab:Coulomb", "fields": {}}
    with pytest.raises(ValueError, match="no ContactLaw"):
        SliderOnBelt.from_dict(data)


def test_malformed_data_is_refused():
    with pytest.raises(ValueError, match="must be a mapping with 'class' and 'fields'"):
        SliderOnBelt.from_dict({"class": 3})
    data = SliderOnBelt().to_dict()
    data["fields"]["mu"] = 1.0
    with pytest.raises(ValueError, match=r"SliderOnBelt cannot be made from .* no parameter 'mu'"):
        SliderOnBelt.from_dict(data)
