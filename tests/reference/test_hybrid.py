"""The reference itself: closed forms, and the tables that were computed with 40 digits."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.helpers.cases import slow_but
from tests.reference.friction import law
from tests.reference.hybrid import Undecided, integrate
from tests.reference.oscillators import BouncingBall, DenHartog, ImpactOscillator, MassOnBelt, TwoBlocks
from tests.reference.slider import Slider
from tests.reference.slider_equations import BASE

COULOMB = {"mu_k": 0.5, "mu_s": 1.0}


def rubbing(kind, name: Any = "Coulomb", **numbers):
    p = SimpleNamespace(**numbers)
    return kind(p, law(name, p))


def belt(name: str = "Coulomb", **changes):
    numbers = {"m": 1.0, "c": 0.0, "k": 1.0, "N": 1.0, "v": 0.2, **COULOMB, **changes}
    return rubbing(MassOnBelt, name, **numbers)


def test_the_period_of_stick_slip():
    """2 a/v in stick, (2 pi - 2 atan(a w/v))/w in slip."""
    motion = integrate(belt(), [0.0, 0.0], [40.0])
    onsets = [event.t for event in motion.events if event.target == "stick"]
    a = 0.5 / 0.2
    assert np.diff(onsets[1:]) == pytest.approx(2 * a + 2 * np.pi - 2 * np.arctan(a), abs=1e-11)


def test_free_oscillation_keeps_its_energy():
    """N = 0, so that every v_r = 0 is crossed without stick."""
    motion = integrate(belt(N=0.0), [1.0, 0.0], np.linspace(0, 50, 21))
    x, v = np.array(motion.states).T
    assert x**2 + v**2 == pytest.approx(1.0, abs=1e-11)


@pytest.mark.slow
def test_den_hartogs_amplitude():
    r, f = 0.8, 0.3
    driven = {"m": 1.0, "c": 0.0, "k": 1.0, "N": f, "F": 1.0, "Omega": r, "mu_k": 1.0, "mu_s": 1.0}
    motion = integrate(rubbing(DenHartog, **driven), [2.6, 0.0], np.linspace(390, 400, 1001))
    x = np.array(motion.states)[:, 0]
    amplitude = np.sqrt((1 / (1 - r**2)) ** 2 - (f * np.sin(np.pi / r) / (r * (1 + np.cos(np.pi / r)))) ** 2)
    assert x.max() == pytest.approx(amplitude, abs=1e-4)  # the samples' distance, 0.01 s, squared


@pytest.mark.parametrize("e", [0.1, 0.5, 0.9])
def test_a_ball_comes_to_rest_when_all_bounces_are_over(e):
    ball = BouncingBall(SimpleNamespace(m=1.0, g=9.81, h=1.0, e=e))
    end = np.sqrt(2 / 9.81) * (1 + e) / (1 - e)
    motion = integrate(ball, [1.0, 0.0], [1.1 * end])
    assert motion.events[-1].target == "contact"
    assert motion.events[-1].t == pytest.approx(end, rel=1e-12)


def test_one_impact_in_each_period_of_the_force():
    """The closed form of ImpactOscillator's docstring: started there, the motion closes."""
    p = SimpleNamespace(m=1.0, c=0.0, k=1.0, d=0.0, F=1.0, Omega=2.5, e=0.8)
    A, T = p.F / (p.k - p.m * p.Omega**2), 2 * np.pi / p.Omega
    # A cos q = V cot, A Omega sin q = -V loss: so V from cos^2 + sin^2 = 1
    cot = (1 + p.e) / (2 * p.e) / np.tan(T / 2)
    loss = (1 - p.e) / (2 * p.e)
    V = abs(A) / np.hypot(cot, loss / p.Omega)
    phase = np.arctan2(-V * loss / (A * p.Omega), V * cot / A)
    oscillator = ImpactOscillator(p)
    oscillator.force = lambda t, z: (p.F * np.cos(p.Omega * t + phase) - p.k * z[0]) / p.m
    motion = integrate(oscillator, [0.0, -V], [0.999 * T])
    after = integrate(oscillator, [0.0, -V], [1.001 * T])
    assert [len(motion.events), len(after.events)] == [0, 1]
    assert after.events[0].t == pytest.approx(T, abs=1e-11)
    assert after.events[0].speed == pytest.approx(V / p.e, abs=1e-11)


def test_blocks_that_are_alike_move_as_one():
    alike = {"m1": 1.0, "m2": 1.0, "c": 0.0, "k1": 1.0, "k2": 1.0, "k12": 1.2, "N1": 1.0, "N2": 1.0}
    blocks = rubbing(TwoBlocks, v=0.2, **alike, **COULOMB)
    one, two = integrate(belt(), [0.1, 0.0], [20.0]), integrate(blocks, [0.1, 0.1, 0.0, 0.0], [20.0])
    assert two.states[0] == pytest.approx(np.repeat(one.states[0], 2), abs=1e-11)


def test_the_slider_of_the_table_with_25_digits():
    """events_B.csv: the moving load, full gap rate."""
    p = SimpleNamespace(**{name: float(value) for name, value in BASE.items()})
    p.geometry, p.unilateral, p.e = True, True, 0.0
    motion = integrate(Slider(p, law("Coulomb", p)), np.zeros(10), [1.0])
    rows = (Path(__file__).parent / "events_B.csv").read_text().splitlines()[1:]
    *events, end = (row.split(",") for row in rows)
    assert [(e.source, e.target) for e in motion.events] == [(row[1], row[2]) for row in events]
    assert [e.t for e in motion.events] == pytest.approx([float(row[0]) for row in events], abs=1e-11)
    assert motion.states[-1] == pytest.approx([float(x) for x in end[3:13]], abs=1e-9)


@pytest.mark.parametrize("width", slow_but([1e-3], [0.2, 1e-3]))
def test_no_layer_is_jumped_over(width):
    """Steps in it that are a fifth as long change nothing."""
    system = belt("Stribeck", v=0.5, c=0.02, mu_k=0.3, mu_s=1.0, v_s=width, mu_v=0.02)
    found = integrate(system, [4.0, 0.0], [40.0])
    system.layers = ((0.0, width / 5),)
    finer = integrate(system, [4.0, 0.0], [40.0])
    assert len(found.events) > 5
    assert [e[1:3] for e in found.events] == [e[1:3] for e in finer.events]
    assert [e.t for e in found.events] == pytest.approx([e.t for e in finer.events], abs=1e-10)


def test_what_cannot_be_told_is_said():
    """A decay of 1e9/s is beyond an explicit method."""
    with pytest.raises(Undecided):
        integrate(belt("Smooth", v_s=1e-9), [0.1, 0.0], [100.0], cap=200)
