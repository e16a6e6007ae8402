"""Effects, interactions and Shapley values of ablations, against functions whose effects are known."""

import numpy as np
import pytest

import frictionlab as fl

QUIET = {"progress": False}
SLIDER = fl.SliderOnBelt()
SWITCHES = "cubic", "nonsmooth", "geometry"


def has(model):
    """Which of its three nonlinearities a SliderOnBelt has, as numbers."""
    left = SLIDER.nonlinearities
    return [float(not left[name].missing(model)) for name in SWITCHES]


def additive(model):
    a, b, c = has(model)
    return 10.0 + 2.0 * a - 3.0 * b + 0.5 * c


def product_of_all(model):
    return float(np.prod(has(model)))


def pair(model):
    a, _, c = has(model)
    return a + 4.0 * a * c


def test_an_additive_function_has_no_interactions():
    effects = fl.ablation(SLIDER, additive, **QUIET).effects()
    assert effects["cubic"] == effects.shapley[0] == pytest.approx(2.0)
    assert effects["nonsmooth"] == effects.shapley[1] == pytest.approx(-3.0)
    assert effects["geometry"] == effects.shapley[2] == pytest.approx(0.5)
    assert np.allclose(effects.values[effects.orders > 1], 0.0, atol=1e-14)
    # of independent switches each has its variance a^2/4
    assert effects.shares[:, 0] == pytest.approx(np.array([4.0, 9.0, 0.25]) / 13.25)
    assert effects.strongest == "nonsmooth"


def test_a_product_is_interaction():
    effects = fl.ablation(SLIDER, product_of_all, **QUIET).effects()
    assert effects["cubic x nonsmooth x geometry"] == pytest.approx(1.0)
    assert effects["cubic x geometry"] == pytest.approx(0.5)  # the third is on in half of the scenes
    assert effects["cubic"] == pytest.approx(0.25)
    assert effects.shapley[:, 0] == pytest.approx([1 / 3] * 3)
    assert effects.shares[:, 0] == pytest.approx([1 / 3] * 3)


def test_an_interaction_is_divided_equally():
    effects = fl.ablation(SLIDER, pair, **QUIET).effects()
    assert effects["cubic x geometry"] == pytest.approx(4.0)
    assert effects["cubic"] == pytest.approx(3.0)
    assert effects.shapley[:, 0] == pytest.approx([3.0, 0.0, 2.0])
    # with switches at -1/2 and 1/2 it is 3 a + 2 c + 4 a c: variances 9/4, 1 and 1
    assert effects.shares[:, 0] == pytest.approx(np.array([9 / 4 + 1 / 2, 0.0, 1 + 1 / 2]) / (9 / 4 + 2))
    assert effects.shares.sum() == pytest.approx(1.0)


@pytest.mark.slow
def test_shapley_values_add_up_to_the_whole_change():
    loaded = fl.SliderOnBelt(F=800.0, k_nl=1e7)
    found = fl.ablation(loaded, lambda m: fl.critical_value(m, "mu_k", (0, 4)), **QUIET)
    whole = found[()] - found[SWITCHES]
    assert found.effects().shapley.sum() == pytest.approx(whole)
    assert found.effects()["nonsmooth"] == 0.0


def test_errors_are_those_of_the_mean_over_initial_states():
    states = [{"x1": value} for value in (0.0, 0.01, 0.03, 0.08)]

    def from_state(model, start):
        return has(model)[0] * (1.0 + start["x1"])

    effects = fl.ablation(SLIDER, from_state, x0=states, **QUIET).effects()
    sizes = np.array([1.0, 1.01, 1.03, 1.08])
    assert effects.shapley[0] == pytest.approx(sizes.mean())
    assert effects.shapley_errors[0] == pytest.approx(sizes.std(ddof=1) / 2)
    assert effects.errors[0] == pytest.approx(sizes.std(ddof=1) / 2)
    assert effects.used.tolist() == [4]
    assert np.isnan(fl.ablation(SLIDER, additive, **QUIET).effects().errors).all()


def test_initial_states_at_which_a_scene_has_no_number_are_left_out():
    def sometimes(model, start):
        lost = start["x1"] > 0 and not has(model)[0]
        return None if lost else has(model)[0]

    effects = fl.ablation(SLIDER, sometimes, x0=[{"x1": 0.0}, {"x1": 1.0}], **QUIET).effects()
    assert (effects.used.tolist(), effects["cubic"].tolist()) == ([1], [1.0])
    never = fl.ablation(SLIDER, lambda m: None if has(m)[0] else 1.0, **QUIET).effects()
    assert np.isnan(never.values).all()
    assert never.strongest is None


def test_alternatives_of_a_law_and_a_parameter():
    laws = {"contact": [fl.LinearContact(), fl.CubicContact(), fl.HertzContact()], "F": [100.0, 200.0]}
    found = fl.ablation(SLIDER, lambda m: fl.equilibrium(m).normal_force, laws, **QUIET)
    assert len(found.results) == 6
    hertz = fl.equilibrium(SLIDER.replace(contact=fl.HertzContact(), F=100.0)).normal_force
    assert found[{"contact": "HertzContact"}] == hertz
    effects = found.effects()
    at = np.array(list(found.results)).reshape(3, 2)
    assert effects["contact HertzContact"] == pytest.approx((at[2] - at[0]).mean())
    assert effects["contact HertzContact x F"] == pytest.approx((at[2] - at[0])[1] - (at[2] - at[0])[0])
    assert effects.shapley.sum() == pytest.approx(at[2, 1] - at[0, 0])


def test_changes_of_several_parameters_are_one_switch():
    levels = {"damped": {}, "undamped": {"c1": 0.0, "c2": 0.0}}
    found = fl.ablation(SLIDER, lambda m: m.c1 + m.c2, {"damping": levels, "geometry": None}, **QUIET)
    assert found[{"damping": "undamped"}] == found[{"damping": "undamped", "geometry": "without"}] == 0.0
    assert found["geometry"] == SLIDER.c1 + SLIDER.c2


def test_several_studies_over_a_parameter_are_one_table():
    studies = {"onset": lambda m: m.F, "kind": lambda m: "chaos" if has(m)[2] else "rest"}
    found = fl.ablation(SLIDER, studies, ["geometry", "cubic"], over={"F": [100.0, 200.0]}, **QUIET)
    assert found.quantities == ("onset", "kind = chaos", "kind = rest")
    effects = found.effects("kind = chaos")
    assert effects["geometry"].tolist() == [1.0, 1.0]
    assert effects.strongest == "geometry"
    table = found.to_dataframe()
    assert table.shape == (8, 3)
    assert table.loc[("with", "without", 200.0), "onset"] == 200.0
    assert len(effects.to_dataframe()) == 6
    with pytest.raises(ValueError, match="quantity must be one of 'onset'"):
        found.effects("onsett")
