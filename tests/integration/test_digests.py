"""Events and final states of all models have the bits that they have on every other machine."""

import json

import pytest

import frictionlab as fl
from tests.digests.__main__ import FILE
from tests.digests.runs import MODELS, cases, digest_of

KNOWN = json.loads(FILE.read_text(encoding="utf-8"))
# Slider runs with a law of its own, each of which derives and compiles; the pressure and all switches stay.
LONG = "Hertz polynomial exponential Stribeck weakening frictional normal".split()


def marks_of(case):
    if case.brief:
        return pytest.mark.plain_python
    return pytest.mark.slow if case.name.startswith(tuple(LONG)) else ()


CASES = [pytest.param(case, id=case.name, marks=marks_of(case)) for case in cases()]


@pytest.mark.parametrize("case", CASES)
def test_a_run_has_the_bits_it_has_everywhere(case):
    run = case.run()
    assert {"events": len(run.events), "sha256": digest_of(run)} == KNOWN[case.name]


def test_all_models_are_there():
    there = {type(model).__name__ for model, _, _ in MODELS.values()} | {"SliderOnBelt"}
    assert {row.call.split("(")[0] for row in fl.list_models("classics")} == there
    assert {case.values[0].name for case in CASES} == set(KNOWN)
