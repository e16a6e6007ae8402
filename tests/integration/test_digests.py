"""Events and final states of all models have the bits that they have on every other machine."""

import json

import pytest

import frictionlab as fl
from tests.digests.__main__ import FILE
from tests.digests.runs import MODELS, cases, digest_of

KNOWN = json.loads(FILE.read_text(encoding="utf-8"))
CASES = [
    pytest.param(case, id=case.name, marks=pytest.mark.plain_python if case.brief else ()) for case in cases()
]


@pytest.mark.parametrize("case", CASES)
def test_a_run_has_the_bits_it_has_everywhere(case):
    run = case.run()
    assert {"events": len(run.events), "sha256": digest_of(run)} == KNOWN[case.name]


def test_all_models_are_there():
    there = {type(model).__name__ for model, _, _ in MODELS.values()} | {"SliderOnBelt"}
    assert {row.call.split("(")[0] for row in fl.list_models()} == there
    assert {case.values[0].name for case in CASES} == set(KNOWN)
