"""Recurrence on sequences whose period is known."""

import numpy as np
import pytest

from frictionlab.analysis.steady_state.classification import (
    NO_RECURRENCE,
    all_parts_decay,
    amplitude_changes,
    crossings_drift,
    find_recurrence,
    is_periodic,
    part_decays,
)

SIZE = np.ones(2)
K = 300
TIME = 0.125  # between crossings; exact in binary, so that equal times are equal


def found(states, tolerance=1e-6):
    states = np.asarray(states, dtype=float)
    returns = find_recurrence(TIME * np.arange(len(states)), states, SIZE, tolerance)
    return returns, is_periodic(returns, tolerance)


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
    assert returns.period == pytest.approx(TIME * period)


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
        assert returns.shrinking > 1.5 or crossings_drift(spiral(decay, turn), SIZE)


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
    assert not crossings_drift(states, SIZE)


def test_growth_drifts():
    assert crossings_drift(spiral(1.002, 1.0), SIZE)
    assert not found(spiral(1.002, 1.0))[1]
    assert crossings_drift(np.column_stack([np.sqrt(np.arange(K)), np.ones(K)]), SIZE)


def test_few_crossings_tell_nothing():
    for count in range(3):
        assert found(np.zeros((count, 2)))[0] == NO_RECURRENCE
    assert not crossings_drift(np.arange(10.0).reshape(5, 2), SIZE)
    assert not part_decays(np.arange(10.0).reshape(5, 2), SIZE)
    assert not all_parts_decay(np.arange(10.0).reshape(5, 2), SIZE)


def test_a_size_that_doubles_swells():
    t = np.linspace(0.0, 100.0, 4001)
    steady = np.column_stack([np.cos(t), np.sin(t), np.zeros_like(t)])
    assert not amplitude_changes(steady)
    assert not amplitude_changes(steady * np.exp(0.004 * t)[:, None])
    assert amplitude_changes(steady * np.exp(0.02 * t)[:, None])
    assert amplitude_changes(steady * np.exp(-0.02 * t)[:, None])
    assert not amplitude_changes(steady[:0])


def test_a_state_that_comes_back_after_other_times_has_not_come_round():
    """A section that misses some returns, at random, has the same state at each crossing."""
    missed = np.cumsum(np.random.default_rng(2).integers(1, 4, K)) * TIME
    returns = find_recurrence(missed, cyclic(0.5), SIZE, 1e-6)
    assert not is_periodic(returns, 1e-6)
    by_turns = np.cumsum(np.tile([1, 2], K // 2)) * TIME  # it misses every third
    returns = find_recurrence(by_turns, cyclic(0.5), SIZE, 1e-6)
    assert (returns.lag, returns.period) == (2, 3 * TIME)


def test_a_state_that_is_met_twice_at_once_has_one_period():
    returns = find_recurrence(np.repeat(TIME * np.arange(K // 2), 2), cyclic(0.5), SIZE, 1e-6)
    assert (returns.lag, returns.period) == (2, TIME)


def test_the_period_is_that_of_the_end_where_early_returns_were_missed():
    times = TIME * np.append([0.0, 7.0, 12.0], 20 + np.arange(K - 3))
    returns = find_recurrence(times, cyclic(0.5), SIZE, 1e-6)
    assert (returns.lag, returns.period) == (1, TIME)


def two_modes(*rates, N=2000, T=100.0):
    """Coordinates and velocities of a chain of two masses whose modes of frequencies 1 and sqrt(3) decay."""
    t = np.linspace(0.0, T, N)
    values = np.array(rates) + 1j * np.array([1.0, np.sqrt(3.0)])
    modes, shapes = np.exp(np.outer(t, values)), np.array([[1.0, 1.0], [0.7, -0.7]])
    return np.column_stack([(modes @ shapes).real, (modes * values @ shapes).real])


@pytest.mark.parametrize("rate", [-1e-2, -1e-4, -1e-6, -1e-8])
def test_modes_that_beat_fade_however_slowly(rate):
    one, both = two_modes(0.0, rate), two_modes(rate, rate)
    assert part_decays(one, np.ptp(one, axis=0))
    assert not all_parts_decay(one, np.ptp(one, axis=0))
    assert part_decays(both, np.ptp(both, axis=0))
    assert part_decays(both[::-1], np.ptp(both, axis=0))


def test_modes_that_beat_without_damping_do_not_fade():
    kept = two_modes(0.0, 0.0)
    assert not part_decays(kept, np.ptp(kept, axis=0))
    assert not all_parts_decay(kept, np.ptp(kept, axis=0))


def test_what_nears_a_cycle_fades_but_does_not_die():
    """r' = r (1 - r^2)/50 from outside: r = (1 - exp(-t/25)/2)^(-1/2)."""
    t = np.linspace(0.0, 100.0, 4001)
    r = (1.0 - 0.5 * np.exp(-t / 25)) ** -0.5
    samples = np.column_stack([r * np.cos(t), r * np.sin(t)])
    assert not all_parts_decay(samples, np.ptp(samples, axis=0))
    lost = np.column_stack([np.exp(-t / 25) * np.cos(t), np.exp(-t / 25) * np.sin(t)])
    assert all_parts_decay(lost, np.ptp(lost, axis=0))
