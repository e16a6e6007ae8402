"""Fields that are no physical numbers, of laws and models: a number of masses, a name, a table, a law."""

import copy
import inspect
import json
import pickle
from fractions import Fraction

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.models.serialisation import component_from_dict, component_to_dict
from tests.helpers.cases import slow_but
from tests.helpers.own_models import Chain, Fitted, NeedsNumber, Wear

LAWS = {
    "defaults": Fitted(),
    "other": Fitted(0.7, (0.5,), (("x", 3),), Wear.OLD, "", True, "a paper", fl.Stribeck(mu_s=1.0)),
    "law within a law": Fitted(base=Fitted(mu_w=0.1, shares=(), pairs=())),
}
MODELS = {
    "defaults": Chain(),
    "three": Chain(masses=3, ends="free", wear=Wear.OLD),
    "weights": Chain(weights=(1.0, 2.0), m=2.0),
    "a law of one's own": Chain(friction=Fitted()),
    "in another law": Chain(spare=fl.Coulomb(mu_k=0.1, mu_s=0.2), friction=Fitted(mu_w=0.6)),
    "no default": NeedsNumber(degree=3),
    "a library's model": fl.MassOnBelt(friction=Fitted()),
}
WAYS = {
    "pickle": lambda each: pickle.loads(pickle.dumps(each)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "JSON": lambda each: component_from_dict(json.loads(json.dumps(component_to_dict(each))), type(each)),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("each", [*LAWS.values(), *MODELS.values()], ids=[*LAWS, *MODELS])
def test_what_comes_back_is_the_same(each, way):
    again = WAYS[way](each)
    assert type(again) is type(each)
    assert again == each
    assert hash(again) == hash(each)
    assert repr(again) == repr(each)


def test_integers_of_numpy_are_saved_as_integers():
    law = Fitted(pairs=(("slow", np.int64(1)), ("fast", np.int32(2))))
    assert WAYS["JSON"](law) == law == Fitted()


CHECKED = [name for name in MODELS if name != "no default"]


@pytest.mark.parametrize("name", slow_but(["a law of one's own"], CHECKED))
def test_models_pass_the_conformance_suite(name):
    fl.testing.check_model(MODELS[name], t_end=5.0)


def test_structure_decides_the_equations():
    assert Chain(masses=3).automaton().names == Chain().automaton().names
    assert len(Chain(masses=3).automaton().states) == 6
    assert Chain().automaton().modes is Chain(k=3.0).automaton().modes
    assert Chain().automaton().modes is not Chain(ends="free").automaton().modes
    new, old = (Chain(wear=wear).automaton() for wear in Wear)
    assert new.modes is not old.modes


def test_they_are_keywords_and_are_replaced():
    assert set(inspect.signature(Chain).parameters) > {"masses", "ends", "wear", "weights", "spare"}
    model = Chain(masses=3, m=2.0)
    assert model.replace(k=5.0) == Chain(masses=3, m=2.0, k=5.0)
    assert model.replace(masses=2) == Chain(m=2.0)
    assert "masses" not in model.parameters
    assert repr(model) == "Chain(m=2.0, masses=3)"
    assert repr(Chain(wear=Wear.OLD)) == "Chain(wear=Wear.OLD)"
    assert "masses 3, ends 'fixed'" in model.describe().title
    assert repr(NeedsNumber(degree=3)) == "NeedsNumber(degree=3)"


def test_a_field_that_no_file_can_hold_is_named_but_the_run_is_saved(tmp_path):
    """With its automaton, so that it is read without the model."""
    model = Chain(weights=(Fraction(1, 2), Fraction(1, 4)))
    with pytest.raises(TypeError, match=r"Chain.weights holds Fraction\(1, 2\), which no file can hold"):
        model.to_dict()
    run = fl.simulate(model, 2.0, progress=False)
    assert fl.load(run.save(tmp_path / "run")).states.tobytes() == run.states.tobytes()


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("wear", {"enum": "os:system", "name": "x"}, "no Enum 'os:system' is loaded"),
        ("wear", {"enum": "tests.helpers.own_models:Wear", "name": "TORN"}, "must have 'TORN'"),
        ("spare", {"class": "os:system", "fields": {}}, "no Component 'os:system' is loaded"),
        ("spare", {"class": "tests.helpers.own_models:Fitted"}, "a mapping with 'class' and 'fields'"),
        ("weights", {"a": 1}, "no Enum None is loaded"),
        ("friction", 3, "a FrictionLaw must be a mapping"),
    ],
)
def test_data_that_cannot_be_are_refused(field, value, message):
    data = Chain().to_dict()
    data["fields"][field] = value
    with pytest.raises(ValueError, match=message):
        fl.Model.from_dict(data)


def amplitude(model):
    """The largest displacement of a short motion."""
    return float(np.abs(fl.simulate(model, 5.0, progress=False)["x1"]).max())


def test_studies_take_them(tmp_path):
    model = MODELS["a law of one's own"]
    path = tmp_path / "sweep.jsonl"
    found = fl.sweep(model, amplitude, {"v": [0.3, 0.5]}, resume=path, progress=False)
    assert found.to_array().tolist() == [amplitude(model.replace(v=v)) for v in (0.3, 0.5)]
    again = fl.sweep(model, amplitude, {"v": [0.3, 0.5]}, resume=path, progress=False)
    assert again.to_array().tolist() == found.to_array().tolist()
    ablation = fl.ablation(model, amplitude, progress=False)
    assert ablation[()] == amplitude(model)
    assert ablation["nonsmooth"] == amplitude(model.without("nonsmooth"))
    bent = fl.bifurcation(model, "v", [0.3, 0.5], window=10.0, transient=20.0, progress=False)
    assert bent.model == model
    assert fl.load_bifurcation(bent.save(tmp_path / "bent")).model == model


@pytest.mark.slow
def test_the_explorer_takes_them():
    model = MODELS["three"]
    explorer = fl.explore(model)
    explorer.controls["duration"].value = 1.0
    explorer.controls["m"].value = 2.0
    assert explorer.error is None
    assert explorer.model == model.replace(m=2.0)
