"""Recurrence on sequences whose period is known."""

import numpy as np
import pytest

from frictionlab.analysis.recurrence import NEVER, drifts, recurrence, repeats, swells

SIZE = np.ones(2)
K = 300


def found(states, tolerance=1e-6):
    states = np.asarray(states, dtype=float)
    returns = recurrence(0.1 * np.arange(len(states)), states, SIZE, tolerance)
    return returns, repeats(returns, tolerance)


def cyclic(*values):
    return np.array([[values[i % len(values)], 0.5] for i in range(K)])


def spiral(decay, turn, size=0.1):
    k = np.arange(K)
    radius = size * decay**k
    return np.column_stack([radius * np.cos(turn * k), radius * np.sin(turn * k)])


@pytest.mark.parametrize("period", [1, 2, 3, 7, 50])
def test_a_cycle_has_its_period(period):
    returns, periodic = found(cyclic(*np.linspace(0.0, 1.0, period)))
    assert (returns.lag, periodic, returns.deviation) == (period, True, 0.0)
    assert returns.period == pytest.approx(0.1 * period)


def test_a_cycle_has_to_be_seen_three_times():
    assert found(cyclic(*np.linspace(0.0, 1.0, 100)))[1]
    assert not found(cyclic(*np.linspace(0.0, 1.0, 101)))[1]


def test_a_small_doubling_is_a_doubling():
    returns, periodic = found(cyclic(0.3, 0.3 + 5e-4))
    assert (returns.lag, periodic) == (2, True)


def test_a_doubling_that_still_settles_is_no_single_cycle():
    settling = cyclic(0.3, 0.3 + 5e-4) + 5e-3 * 0.9 ** np.arange(K)[:, None]
    returns, _ = found(settling)
    assert returns.lag == 2


@pytest.mark.parametrize("turn", [0.0, 2 * np.pi / 7, 2 * np.pi * 2 / 5, np.pi, 1.0])
@pytest.mark.parametrize("decay", [0.95, 0.98, 0.99, 0.995])
def test_a_spiral_inwards_is_single_or_not_settled(decay, turn):
    returns, periodic = found(spiral(decay, turn))
    assert returns.lag == 1 or not periodic
    if decay < 0.97:
        assert periodic
    if not periodic:
        assert returns.shrinking > 1.5 or drifts(spiral(decay, turn), SIZE)


def test_a_cycle_within_a_thousandth_is_no_other_motion_yet():
    shaken = cyclic(0.0, 1.0) + np.random.default_rng(1).uniform(0.0, 1e-4, (K, 2))
    returns, periodic = found(shaken)
    assert not periodic
    assert returns.lag % 2 == 0
    assert 1e-6 < returns.deviation < 1e-3
    assert found(shaken, tolerance=1e-3)[0].lag == 2


def test_noise_does_not_repeat_and_does_not_drift():
    states = np.random.default_rng(1).uniform(size=(K, 2))
    returns, periodic = found(states)
    assert not periodic
    assert returns.shrinking < 1.5
    assert not drifts(states, SIZE)


def test_growth_drifts():
    assert drifts(spiral(1.002, 1.0), SIZE)
    assert not found(spiral(1.002, 1.0))[1]
    assert drifts(np.column_stack([np.sqrt(np.arange(K)), np.ones(K)]), SIZE)


def test_few_crossings_tell_nothing():
    for count in range(3):
        assert found(np.zeros((count, 2)))[0] == NEVER
    assert not drifts(np.arange(10.0).reshape(5, 2), SIZE)


def test_a_size_that_doubles_swells():
    t = np.linspace(0.0, 100.0, 4001)
    steady = np.column_stack([np.cos(t), np.sin(t), np.zeros_like(t)])
    assert not swells(steady)
    assert not swells(steady * np.exp(0.004 * t)[:, None])
    assert swells(steady * np.exp(0.02 * t)[:, None])
    assert swells(steady * np.exp(-0.02 * t)[:, None])
    assert not swells(steady[:0])
