"""The solver against an integrator that shares no code with it: random cases, and those that failed once.

Many more: python -m tests.differential --count 2000 --seed 1
"""

from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from tests.differential.case import Case, read
from tests.differential.generate import KINDS, MAKERS, generate
from tests.differential.judge import judge
from tests.differential.predict import predict
from tests.differential.twin import weight
from tests.reference.friction import CURVES, law

SEED = 20
COUNT = {
    "MassOnBelt": 12,
    "DenHartog": 8,
    "ImpactOscillator": 5,
    "TwoBlocks": 6,
    "BouncingBall": 3,
    "ModeCoupling": 4,
    "SliderOnBelt": 5,
}
RANDOM = [(model, number) for model, count in COUNT.items() for number in range(count)]
LINES = (Path(__file__).parents[2] / "differential" / "kept.txt").read_text(encoding="utf-8").splitlines()
KEPT = [line for line in LINES if line and not line.startswith("#")]


def complaint(case):
    """Nothing, or what is wrong, with the line of code that shows it."""
    verdict = judge(case)
    return f"{case!r}  # {verdict.kind}: {verdict.words}" if verdict.failed else ""


@pytest.mark.parametrize(("model", "number"), RANDOM)
def test_random_cases_agree(model, number):
    assert complaint(generate(SEED, number, model)) == ""


@pytest.mark.parametrize("line", KEPT)
def test_what_failed_once_agrees(line):
    assert complaint(read(line)) == ""


# --- the harness itself


def test_every_model_and_law_has_a_maker_and_a_twin():
    assert set(COUNT) == set(MAKERS)
    assert {kind.__name__ for kind in KINDS} | {"Coulomb"} == {*CURVES, "PressureDependent"}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_the_laws_are_written_twice_alike(kind):
    curve = kind(mu_k=0.2, mu_s=0.7)
    twin = law(kind.__name__, curve)
    for u in (0.0, 1e-3, 0.2, 3.0):
        assert twin.kinetic(2.0, u) == pytest.approx(float(curve.kinetic(2.0, u)), rel=1e-14)
    assert twin.static(2.0) == pytest.approx(curve.static_limit(2.0), rel=1e-14)


@pytest.mark.parametrize("model", MAKERS)
def test_a_case_is_the_line_of_code_that_it_prints(model):
    for number in range(5):
        case = generate(3, number, model)
        assert read(repr(case)) == case == generate(3, number, model)


def test_a_wrong_run_is_found():
    """A mass of one part in 1e6 more has the events a little later: not within the bound."""
    case = Case(fl.MassOnBelt(v=0.5), (2.0, 0.0), 20.0)
    known = predict(case)
    other = predict(Case(fl.MassOnBelt(v=0.5, m=1 + 1e-6), (2.0, 0.0), 20.0))
    late = np.abs([a.t - b.t for a, b in zip(known.events, other.events, strict=False)])
    assert (late > 10 * known.time_spread[: len(late)]).any()
    assert known.horizon == case.t_end


def test_what_cannot_be_foretold_is_not_compared():
    """A slip that just stops short of stick: runs nearby do and do not stick."""
    grazing = fl.MassOnBelt(v=0.5, friction=fl.Coulomb(mu_k=0.2, mu_s=0.4))
    known = predict(
        Case(grazing, (0.7, 0.0), 40.0)
    )  # turns about 0.2 with the amplitude 0.5, the belt's speed
    assert known.horizon < 15.0


def test_slip_that_ends_at_the_static_limit_by_symmetry_is_not_compared():
    """mu_k = 0: from the limit to the limit, where rounding decides."""
    case = Case(fl.MassOnBelt(mu_k=0.0, mu_s=0.5), (0.482, 0.2), 20.0)
    assert predict(case).horizon < 5.0


def test_weights_are_the_same_in_every_process():
    assert weight("mu_k") == weight("mu_s") == 1.0
    assert weight("m") == pytest.approx(weight("m"))
    assert all(0.5 <= abs(weight(name)) <= 1.0 for name in "m c k N v F Omega".split())
