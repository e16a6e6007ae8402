"""Settings that analyses share."""

from dataclasses import fields

import frictionlab as fl
from frictionlab.analysis.options import Execution, ExecutionKeywords, SteadyStateKeywords


def test_keywords_for_editors_are_the_fields():
    for keywords, kind in (
        (SteadyStateKeywords, fl.SteadyStateOptions),
        (ExecutionKeywords, Execution),
    ):
        assert list(keywords.__annotations__) == [field.name for field in fields(kind)]


def test_a_name_of_a_method_is_resolved_once():
    assert fl.SteadyStateOptions(method="rk4").method == fl.RK4()
