"""Menus of laws: what a model takes, and what happens to values, parameters and pictures."""

import pytest

import frictionlab as fl
from frictionlab.pages.page_data import PAGE_LAWS, page_laws
from frictionlab.pages.scene import LAWS, law_menus

FRICTION = tuple(LAWS[fl.FrictionLaw])
MODELS = [fl.MassOnBelt(c=0.1), fl.SliderOnBelt(mu_k=1.4), fl.TwoBlocks(), fl.FroudePendulum()]


def test_parameters_follow_the_law_and_shared_values_stay():
    explorer = fl.explore(fl.MassOnBelt(c=0.1, mu_k=0.4), panels=["eigenvalues"])
    law = explorer.controls["friction"]
    assert law.label == "Coulomb"
    assert "v_s" not in explorer.widget.picture["parameters"]
    law.label = "Stribeck"
    assert explorer.model == fl.MassOnBelt(c=0.1, friction=fl.Stribeck(mu_k=0.4, mu_s=explorer.model.mu_s))
    assert "v_s" in explorer.widget.picture["parameters"]
    assert explorer.changed() == {"friction": "Stribeck"}
    explorer.reset()
    assert explorer.model == fl.MassOnBelt(c=0.1, mu_k=0.4)


def test_a_law_of_several_contacts_has_a_curve_without_a_speed_of_sliding():
    explorer = fl.explore(fl.TwoBlocks(), panels=["friction"])
    assert explorer.widget.error == ""
    assert explorer.result.eigenvalues is not None
    assert explorer.widget.picture["friction"]["at"] is None


def test_a_law_of_ones_own_is_in_the_menu():
    model = fl.SliderOnBelt(contact=fl.LinearContact(), impact=fl.PlasticImpact("full"))
    menus = law_menus(model)
    assert list(menus["contact"]) == ["cubic", "Hertz", "polynomial", "LinearContact"]
    assert menus["impact"]["plastic, full gap rate"] == model.impact


def test_pages_have_the_laws_that_are_asked_for():
    model = fl.MassOnBelt()
    assert tuple(page_laws(model, None)) == PAGE_LAWS
    assert list(page_laws(model, ["LuGre"])) == ["Coulomb", "LuGre"]
    assert page_laws(model, ["Coulomb"]) == page_laws(fl.BouncingBall(), None) == {}
    with pytest.raises(ValueError, match=r"laws has no law of friction 'Strebick': did you mean 'Stribeck'"):
        page_laws(model, ["Strebick"])


@pytest.mark.slow  # each law of each model is derived
# The belt of one of them runs at the speed of a point of the curve.
@pytest.mark.filterwarnings("ignore:the equilibrium is on the border:RuntimeWarning")
@pytest.mark.filterwarnings("ignore:do not trust this run:RuntimeWarning")  # the picture says it, too
@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
@pytest.mark.parametrize("name", FRICTION)
def test_every_law_moves_every_model_or_says_why_not(model, name):
    explorer = fl.explore(model, panels=["response"])
    if name in explorer.controls["friction"].options:
        explorer.controls["friction"].label = name
        assert explorer.error is None or isinstance(explorer.error, ValueError)
        assert explorer.widget.picture["status"]  # in words, also where bristles are too stiff for the run
