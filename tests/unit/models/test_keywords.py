"""The keywords that type checkers know of each model are those that it takes."""

import pytest

import frictionlab as fl
from frictionlab.components.component import is_decorated, parameters_of
from frictionlab.models.library import parameters
from frictionlab.models.model import Model


def derived(kind):
    """All classes of the package below one."""
    found = [other for below in kind.__subclasses__() for other in (below, *derived(below))]
    return [one for one in found if one.__module__.startswith("frictionlab.") and is_decorated(one)]


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
