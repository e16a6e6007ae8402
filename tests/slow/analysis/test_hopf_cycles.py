"""Cycles that a Hopf point predicts, against those of the smooth flow."""

from __future__ import annotations

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.stability.boundaries.hopf import hopf
from tests.helpers.lorenz import lorenz

STRONG = {"F": 800, "k_nl": 1e7, "k4": 5e6, "k5": 5e6, "k6": 5e6}  # the scene of the paper's Figs. 16 and 17


def run(model, parameter, value, x0, t_end, **options):
    """The solver, at another value of a parameter."""
    if not isinstance(model, fl.HybridAutomaton):
        model = model.replace(**{parameter: value})
        return fl.simulate(model, t_end, x0=x0, progress=False, **options)
    values = {s: value if s.name == parameter else v for s, v in model.parameters.items()}
    moved = fl.HybridAutomaton(model.states, model.modes, values, model.coordinates)
    return fl.solve(moved, t_end, x0=x0, progress=False, **options)


def predicted(point, value):
    """A state on the predicted cycle, where the first coordinate has its maximum."""
    vector = point.vector * np.exp(-1j * np.angle(point.vector[0]))
    return point.state + point.amplitude(value)[0] / vector[0].real * vector.real


def cycle(point, value):
    """The periodic orbit near the predicted one: a state and the period, by Newton's method."""
    guess = predicted(point, value)
    z = np.append(guess, 1 / point.cycle_frequency(value))
    scale = np.abs(point.vector) * np.abs(guess - point.state).max()
    steps = 1e-4 * np.append(np.maximum(scale, 1e-3 * scale.max()), z[-1])
    pinned = np.abs((point.vector / point.vector[0]).imag).argmax()  # passes its mean at the start

    def miss(z):
        return run(point.model, point.parameter, value, z[:-1], z[-1]).final_state - z[:-1]

    move = np.ones(1)
    for _ in range(8):
        if np.abs(move).max() < 1e-2:
            return z[:-1], z[-1]
        columns = [(miss(z + step) - miss(z - step)) / 2 for step in np.diag(steps)]
        matrix = np.vstack([np.array(columns).T, np.eye(len(z))[pinned]])
        move = np.linalg.solve(matrix, np.append(-miss(z), 0.0))
        z = z + move * steps
    raise AssertionError(f"no periodic orbit at {value}")


def errors(point, value):
    """Relative errors of the predicted amplitudes, as one vector, and of the frequency."""
    state, period = cycle(point, value)
    samples = run(point.model, point.parameter, value, state, period, t_eval=np.arange(64) * period / 64)
    found = np.abs(np.fft.rfft(samples.states[:, : len(point.coordinates)], axis=0)[1]) / 32
    expected = point.amplitude(value)
    off = np.linalg.norm(found - expected) / np.linalg.norm(expected)
    return off, 1 / period / point.cycle_frequency(value) - 1


def smooth(*names, **parameters):
    return fl.SliderOnBelt(**parameters).without("nonsmooth", *names)


CYCLES = [
    (lorenz(), "r", (22, 30), -4e-3),
    (smooth(), "mu_k", (0, 4), -6.4e-5),  # nearer, rounding is a share of the error: the condition is 3e15
    (smooth(k_nl=1e7), "mu_k", (0, 0.8), 1.6e-4),
    (smooth(k_nl=1e7), "F", (200, 600), 4e-2),
    (smooth("geometry", k_nl=1e7), "mu_k", (0, 4), -1.6e-3),
    (smooth(**STRONG), "mu_k", (0, 4), -4e-3),
    (smooth(F=1000, l1=0.1, l2=0.3), "mu_k", (1.5, 3), -4e-4),
]


@pytest.mark.parametrize(("model", "parameter", "bounds", "distance"), CYCLES)
def test_prediction_and_cycle_meet_at_the_critical_value(model, parameter, bounds, distance):
    """The error of the amplitude is of first order in the distance, that of the frequency of second."""
    point = hopf(model, parameter, bounds)
    (near, slow), (far, fast) = (errors(point, point.value + d) for d in (distance / 4, distance))
    assert far < 0.01
    assert far / near == pytest.approx(4, rel=0.05)
    assert fast / slow == pytest.approx(16, rel=0.05)


def test_a_supercritical_cycle_attracts():
    model = smooth(k_nl=1e7)
    point = hopf(model, "mu_k", (0, 0.8))
    value = point.value + 2.5e-3
    start = point.state + 0.6 * (predicted(point, value) - point.state)
    times = np.linspace(395, 400, 4000)
    settled = run(model, "mu_k", value, start, 400, t_eval=times)
    assert point.criticality == "supercritical"
    off = np.ptp(settled.q, axis=0) / 2 - point.amplitude(value)
    assert np.linalg.norm(off) < 0.04 * np.linalg.norm(point.amplitude(value))


def test_a_subcritical_cycle_is_the_border_below_the_critical_value():
    """Claim C24: limit cycles where the equilibrium is stable, far below its critical value of 1.735."""
    model = smooth(**STRONG)
    point = hopf(model, "mu_k", (0, 4))
    assert point.value == pytest.approx(1.735143, abs=1e-6)
    assert point.criticality == "subcritical"
    for value in (1.73, 1.6, 1.45):
        for share, grows in ((0.8, False), (1.1, True)):
            start = point.state + share * (predicted(point, value) - point.state)
            after = run(model, "mu_k", value, start, 20.0, t_eval=np.linspace(19, 20, 2000))
            assert (np.ptp(after["x1"]) / 2 > 1.2 * point.amplitude(value)[0]) == grows


def test_the_cycle_ends_where_the_slider_begins_to_stick():
    point = hopf(fl.SliderOnBelt(**STRONG), "mu_k", (0, 4))
    cycles = hopf(smooth(**STRONG), "mu_k", (0, 4))
    assert cycles.valid_until == -np.inf
    state, period = cycle(cycles, point.valid_until)
    samples = run(cycles.model, "mu_k", point.valid_until, state, period, t_eval=np.linspace(0, period, 999))
    assert samples.relative_velocity.min() == pytest.approx(0, abs=0.01)
