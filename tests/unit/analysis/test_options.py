"""Settings that analyses share: given whole, field by field, or both."""

from dataclasses import fields

import frictionlab as fl
from frictionlab.analysis.options import ExecutionKeywords, SteadyStateKeywords

MODEL = fl.MassOnBelt()
VALUES = [0.2, 0.3]


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
