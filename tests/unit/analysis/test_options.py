"""Settings that analyses share: given whole, field by field, or both."""

from dataclasses import fields
from functools import partial

import pytest

import frictionlab as fl
from frictionlab.analysis.options import ExecutionKeywords, SteadyStateKeywords

MODEL = fl.MassOnBelt()
VALUES = [0.2, 0.3]
STUDIES = {
    "bifurcation": partial(fl.bifurcation, MODEL, "mu_k", VALUES),
    "basins": partial(fl.basins, MODEL, ("x", VALUES), ("x'", VALUES)),
    "basin_stability": partial(fl.basin_stability, MODEL, {"x": (0.0, 0.3)}, 4),
    "sweep": partial(fl.sweep, MODEL, lambda m: m.mu_k, {"mu_k": VALUES}),
    "ablation": partial(fl.ablation, MODEL, lambda m: 1.0),
}


def test_fields_given_directly_are_those_of_the_options():
    options, execution = fl.SteadyStateOptions(transient=2.0, window=9.0), fl.Execution(progress=False)
    whole = fl.bifurcation(MODEL, "mu_k", VALUES, options=options, execution=execution, window=2.0, workers=1)
    fields_only = fl.bifurcation(MODEL, "mu_k", VALUES, transient=2.0, window=2.0, progress=False)
    assert whole.results == fields_only.results
    assert whole.specification == fields_only.specification


def test_keywords_for_editors_are_the_fields():
    for keywords, kind in (
        (SteadyStateKeywords, fl.SteadyStateOptions),
        (ExecutionKeywords, fl.Execution),
    ):
        assert list(keywords.__annotations__) == [field.name for field in fields(kind)]


def test_a_name_of_a_method_is_resolved_once():
    assert fl.SteadyStateOptions(method="rk4").method == fl.RK4()


@pytest.mark.parametrize("name", STUDIES)
def test_what_is_no_setting_is_refused(name):
    with pytest.raises(TypeError, match=f"{name} takes no 'worker': did you mean 'workers'"):
        STUDIES[name](worker=2)
    with pytest.raises(
        TypeError, match=r"execution must be of the class Execution, got 2: write fl\.Execution"
    ):
        STUDIES[name](execution=2)


def test_settings_without_a_use_are_refused():
    with pytest.raises(TypeError, match="bifurcation takes no 'rtol'"):
        STUDIES["bifurcation"](rtol=0.1)
    with pytest.raises(TypeError, match="basins takes no 't_max'"):
        STUDIES["basins"](t_max=1.0)
    with pytest.raises(ValueError, match=r"t_max must be None, got 1\.0: give a longer transient"):
        STUDIES["basins"](options=fl.SteadyStateOptions(t_max=1.0))


@pytest.mark.parametrize("field", ["transient", "window", "t_max", "tolerance", "rtol"])
def test_options_are_checked_when_they_are_made(field):
    with pytest.raises(ValueError, match=f"{field} must be a finite number"):
        fl.SteadyStateOptions(**{field: -1.0})
