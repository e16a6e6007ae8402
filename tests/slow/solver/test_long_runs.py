"""Ten thousand seconds, four hundred thousand events: nothing adds up."""

import math

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components import StickSlip
from tests.helpers.energy_balance import residual

END, WINDOW = 1e4, 10.0
UNDAMPED = dict.fromkeys(("c1", "c2", "c4", "c5", "c6"), 0.0)
BILATERAL = fl.SliderOnBelt(mu_k=0.1, mu_s=0.2, F=1000.0, interface=StickSlip()).without("geometry")
MODELS = {
    "A": fl.SliderOnBelt(mu_k=1.4).without("geometry"),
    "B": fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")),
    "bilateral": BILATERAL,
    "held": BILATERAL.replace(mu_k=1.4, mu_s=3.0, F=200.0, v=0.0, **UNDAMPED),  # swings, and never slips
}
HELD = np.array([1e-4, -0.034, 1e-4, -0.01, 0.01, 0.0, 0.01, 0.0])
FREQUENCIES = {"A": 11.048, "B": 11.054}  # Hz, of a motion with four events in a period


@pytest.fixture(scope="module", params=MODELS)
def whole(request):
    """The scene's name and its run; one at a time, as each keeps 100 MB."""
    start = HELD if request.param == "held" else "rest"
    return request.param, fl.simulate(MODELS[request.param], END, x0=start, progress=False)


def drift(run, begin, end):
    """Largest |v_r| in stick, deepest gap below zero in contact and above it in flight, between two times."""
    at_events = run.events.t[(run.events.t >= begin) & (run.events.t <= end)]
    t = np.union1d(np.linspace(begin, end, 20_001), at_events)
    mode, v_r, gap = run.modes_at(t), run.output("relative_velocity", t), run.output("penetration", t)
    stick, flight = mode == "stick", mode == "separation"
    assert stick.any()
    return np.abs(v_r[stick]).max(), -gap[~flight].min(initial=0.0), gap[flight].max(initial=0.0)


def test_constraints_do_not_drift(whole):
    """Found at the start and at the end: 4e-16 m/s, 2e-17 m. Held, v_r is integrated without a projection."""
    scene, run = whole
    assert run.status is fl.Status.FINISHED
    first, second = np.histogram(run.events.t, [END / 2, 3 * END / 4, END])[0]
    assert abs(first - second) <= 2  # the motion goes on as it was
    assert (first == 0) == (scene == "held")
    if scene in FREQUENCIES:
        assert len(run.events) == pytest.approx(4 * FREQUENCIES[scene] * END, rel=1e-3)
    for begin in (0.0, END - WINDOW):
        assert (np.array(drift(run, begin, begin + WINDOW)) < [4e-15, 1e-15, 1e-15]).all()


def test_energy_is_balanced_at_the_end_as_at_the_start(whole):
    """Over ten seconds; found are 1e-13 of the energy turned over, at both ends."""
    scene, run = whole
    for begin in (0.0, END - WINDOW):
        mode = str(run.modes_at(begin))
        missing, turned_over = residual(MODELS[scene], WINDOW, run(begin), mode)
        assert abs(missing) < 3e-12 * turned_over


def test_the_clock_keeps_up_with_the_steps(whole):
    """Two million steps of nearly one length would be rounded nearly alike, if they were simply added up."""
    starts, lengths = whole[1].raw.step_times.T
    half = len(lengths) // 2
    assert abs(math.fsum(lengths) - END) < 1e-11
    assert abs(math.fsum(lengths[:half]) - starts[half]) < 1e-11


def test_energy_of_a_motion_that_sticks_for_ten_thousand_seconds():
    """Neither damper nor sliding: what springs hold, and the contact gives and takes; found is 4e-11."""
    missing, turned_over = residual(MODELS["held"], END, HELD)
    assert abs(missing) < 1e-9 * turned_over
