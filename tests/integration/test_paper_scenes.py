"""The paper's motion from rest at mu_k = 1.4, against an independent high-precision integrator and scipy.

Scene A is without geometry, B with geometry and the full gap rate in the impact law, D with Eq. (13).
"""

import json
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from tests.reference.slider_mpmath import first_events

REFERENCE = Path(__file__).parents[1] / "reference" / "first_events.json"
SCENES = json.loads(REFERENCE.read_text(encoding="utf-8"))["scenes"]
FULL = fl.PlasticImpact("full")
MODELS = {
    "A": fl.SliderOnBelt(mu_k=1.4).without("geometry"),
    "B": fl.SliderOnBelt(mu_k=1.4, impact=FULL),
    "D": fl.SliderOnBelt(mu_k=1.4),
}
COUNTS = {"A": 885, "B": 886}


def run_of(scene, t_end=20.0, **options):
    run = fl.simulate(MODELS[scene], t_end, progress=False, **options)
    assert run.status is fl.Status.FINISHED
    return run


def assert_same_events(run, expected):
    n = len(expected)
    times, source, target = zip(*expected, strict=True)
    assert run.events.source[:n].tolist() == list(source)
    assert run.events.target[:n].tolist() == list(target)
    assert run.events.t[:n] == pytest.approx(np.array([float(t) for t in times]), abs=1e-11, rel=0)


@pytest.mark.parametrize("scene", ["A", "B", "D"])
def test_first_twenty_events_are_those_of_the_reference(scene):
    assert len(SCENES[scene]["events"]) == 20
    assert_same_events(run_of(scene, 1.0), SCENES[scene]["events"])


def test_first_events_of_the_issue():
    assert run_of("A", 0.1).events.t[:4] == pytest.approx([0.015516, 0.0597, 0.0700, 0.0879], abs=1e-4)


@pytest.mark.parametrize("scene", ["A", "B"])
def test_state_at_a_fifth_of_a_second_is_that_of_the_reference(scene):
    exact = np.array([float(x) for x in SCENES[scene]["state_at_0.2"]])
    assert run_of(scene, 0.2).final_state == pytest.approx(exact, abs=1e-12)
    assert run_of(scene, 1.0)(0.2) == pytest.approx(exact, abs=1e-12)


def test_the_reference_is_derived_again():
    """With other parameters than the stored ones; stick, slip and flight all occur."""
    expected = first_events(6, mu_k="1.7", geometry=True, impact="full", F=300)
    assert {mode for _, _, mode in expected} >= {"stick", "slip+", "separation"}
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.7, F=300, impact=FULL), 1.0)
    assert_same_events(run, expected)


def test_the_stored_reference_is_what_its_program_gives():
    again = first_events(6, mu_k="1.4", geometry=False, impact="full")
    stored = SCENES["A"]["events"][:6]
    assert [tuple(event[1:]) for event in stored] == [event[1:] for event in again]
    assert [float(event[0]) for event in stored] == pytest.approx([float(t) for t, _, _ in again], rel=1e-15)


@pytest.mark.parametrize("tol", [10.0**-n for n in range(8, 16)])
@pytest.mark.parametrize("scene", ["A", "B"])
def test_the_number_of_events_is_the_same_at_every_tolerance(scene, tol):
    assert len(run_of(scene, method=fl.Taylor(tol=tol)).events) == COUNTS[scene]


@pytest.mark.parametrize("method", [fl.Taylor(tol=1e-12), fl.Taylor(order=16), fl.Taylor(order=24)], ids=str)
@pytest.mark.parametrize("scene", ["A", "B"])
def test_the_final_state_is_the_same_by_tolerance_and_order(scene, method):
    run, usual = run_of(scene, method=method), run_of(scene)
    assert len(run.events) == COUNTS[scene]
    assert run.final_state == pytest.approx(usual.final_state, abs=1e-9)


def test_without_geometry_the_impact_laws_agree_to_the_last_bit():
    material = fl.simulate(MODELS["A"], 20.0)
    full = fl.simulate(MODELS["A"].replace(impact=FULL), 20.0)
    assert len(material.events) == COUNTS["A"]
    assert material.events.t.tolist() == full.events.t.tolist()
    assert material.events.guard.tolist() == full.events.guard.tolist()
    assert material.final_state.tolist() == full.final_state.tolist()


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["A", "B"])
def test_dop853_ends_in_the_same_state(scene):
    run = run_of(scene, method=fl.Scipy("DOP853", rtol=1e-12, atol=1e-15))
    assert len(run.events) == COUNTS[scene]
    assert run.final_state == pytest.approx(run_of(scene).final_state, abs=1e-7)


@pytest.mark.parametrize("scene", ["A", "B"])
def test_the_motion_settles_on_a_cycle_at_eleven_hertz(scene):
    events = run_of(scene).events
    onsets = events.t[(events.target == "stick") & (events.t > 15)]
    periods = np.diff(onsets)
    assert 1 / periods == pytest.approx(11.05, abs=0.02)
    assert np.ptp(periods) < 2e-5


def test_the_cycle_of_scene_b_is_periodic_to_rounding_in_the_end():
    events = run_of("B", 200.0).events
    periods = np.diff(events.t[(events.target == "stick") & (events.t > 190)])
    assert 1 / periods == pytest.approx(11.05371, abs=1e-5)
    assert np.ptp(periods) < 1e-8


@pytest.mark.slow
def test_the_chatter_of_the_printed_impact_law_is_passed():
    run = run_of("D", 200.0)
    assert run.t[-1] == 200.0
    assert run.stats["accumulations"] > 0
    assert run.stats["accumulations"] == run.events.closed.sum()
    assert (np.diff(run.events.t) >= 0).all()
    # Erratum E5: three stick onsets a period, at 3.56 Hz
    onsets = run.events.t[(run.events.target == "stick") & (run.events.t > 150)]
    periods = onsets[3:] - onsets[:-3]
    assert 1 / periods == pytest.approx(3.56, abs=0.01)
    assert np.ptp(periods) < 1e-5
    assert np.ptp(np.diff(onsets)) > 0.01
