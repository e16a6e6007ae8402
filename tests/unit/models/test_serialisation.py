"""Classes in files, by their public name or by module and name; keywords that type checkers know."""

import copy
import pickle
from dataclasses import fields

import pytest

import frictionlab as fl
from frictionlab.components.component import Component, parameters_of
from frictionlab.models.library import parameters
from frictionlab.models.library.dry_friction_oscillators import SingleMass
from frictionlab.models.mechanical.mechanical_model import PlanarSlider
from frictionlab.models.model import Model
from frictionlab.models.serialisation import class_path, loaded_class
from frictionlab.models.zoo.zoo_model import ZooModel
from tests.helpers.own_models import Chain, Fitted, Wear

NAMES = {name: getattr(fl, name) for name in fl.__all__ if name[0].isupper()} | {"fl": fl}
BASES = {SingleMass, PlanarSlider, ZooModel}  # of models; there are no objects of these alone


def derived(kind):
    """All laws and models of the library below a class that a user can make."""
    found = [other for below in kind.__subclasses__() for other in (below, *derived(below))]
    homes = "frictionlab.components.", "frictionlab.models."
    known = [one for one in found if one.__module__.startswith(homes) and one not in BASES]
    return [one for one in known if not one.__name__.startswith("_")]


def test_every_law_and_model_of_the_library_has_its_public_name():
    classes = set(derived(Component))
    assert len(classes) > 30
    for cls in classes:
        assert class_path(cls) == f"frictionlab:{cls.__name__}"
        assert getattr(fl, cls.__name__) is cls
        assert loaded_class(class_path(cls), Component) is cls


@pytest.mark.parametrize("row", fl.list_models().rows, ids=lambda row: row.call)
def test_a_model_in_a_file_names_no_module(row):
    assert "frictionlab." not in repr(eval(row.call, NAMES).to_dict())


@pytest.mark.parametrize("cls", [Chain, Fitted, Wear])
def test_a_class_of_ones_own_is_named_by_its_module(cls):
    assert class_path(cls) == f"tests.helpers.own_models:{cls.__name__}"


def test_a_class_of_ones_own_may_have_a_name_of_the_library():
    class Coulomb(fl.FrictionLaw):
        pass

    assert class_path(Coulomb).startswith(f"{__name__}:")
    assert loaded_class("frictionlab:Coulomb", fl.FrictionLaw) is fl.Coulomb


class Tabulated(fl.FrictionLaw):
    """With an attribute of its own beside the fields."""

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "table", (0.3, 0.2))


def test_attributes_of_ones_own_are_pickled():
    assert pickle.loads(pickle.dumps(Tabulated())).table == (0.3, 0.2)


def test_a_component_knows_its_structure_and_pickles_no_notes():
    model = fl.SliderOnBelt(mu_k=1.4, impact=fl.RestitutionImpact(e=0.0))
    key = model.structure_key
    assert key is model.structure_key
    assert key == model.replace(mu_k=2.0).structure_key
    assert key == fl.SliderOnBelt(impact=fl.PlasticImpact(penetration_rate="full")).structure_key
    assert key != model.replace(impact=fl.RestitutionImpact(e=0.5)).structure_key
    model.automaton()
    for same in (pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)):
        assert vars(same).keys() == {each.name for each in fields(model)}
        assert (same, same.structure_key) == (model, key)


def taken(model):
    """Names of the parameters of a model, of its roles, and of all laws that may take these."""
    laws = [law for base in model.roles.values() for law in (base, *derived(base))]
    return {*model.roles, *(name for kind in (model, *laws) for name in parameters_of(kind))}


@pytest.mark.parametrize("row", fl.list_models("classics").rows, ids=lambda row: row.call)
def test_they_are_all_and_no_others(row):
    model = getattr(fl, row.call.partition("(")[0])
    assert issubclass(model, Model)
    hints = parameters.__dict__[f"{model.__name__}Keywords"].__annotations__
    assert set(hints) == taken(model)
