"""Limits that stay while they can, and curves of fewer points that lose no peak."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionlab.plotting.figure import ENVELOPE_BINS, envelope
from frictionlab.widgets.panels.tile import MIN_FILL, data_range, linear_limits, logarithmic_limits

pytestmark = pytest.mark.plain_python

NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)


@given(NUMBERS, NUMBERS)
def test_new_limits_hold_the_data_and_are_not_much_wider(a, b):
    low, high = linear_limits(None, (min(a, b), max(a, b)))
    assert low <= min(a, b) <= max(a, b) <= high
    span = max(abs(b - a), 1e-3 * max(abs(a), abs(b)), 1e-12)
    assert high - low <= span / MIN_FILL * 1.01


@given(NUMBERS, NUMBERS)
def test_limits_just_chosen_stay(a, b):
    found = min(a, b), max(a, b)
    chosen = linear_limits(None, found)
    assert linear_limits(chosen, found) == chosen


def test_limits_follow_what_leaves_them_and_what_gets_small():
    assert linear_limits((-1.0, 1.0), (-0.9, 0.9)) == (-1.0, 1.0)
    assert linear_limits((-1.0, 1.0), (-0.9, 1.1))[1] >= 1.1
    low, high = linear_limits((-1.0, 1.0), (-0.01, 0.01))
    assert -0.02 < low < -0.01 < 0.01 < high < 0.02


@given(st.floats(1e-12, 1e12))
def test_a_logarithmic_axis_spans_five_decades_below_the_largest(top):
    low, high = logarithmic_limits(None, (0.0, top))
    assert high / 10 <= top * (1 + 1e-9)
    assert top <= high * (1 + 1e-9)
    assert high / low == pytest.approx(1e5)


def test_without_data_there_are_limits_all_the_same():
    assert data_range([[np.nan], []]) is None
    assert linear_limits(None, None) == (0.0, 1.0)
    assert logarithmic_limits(None, (0.0, 0.0)) == (1e-5, 1.0)


@pytest.mark.parametrize("n", [4 * ENVELOPE_BINS + 1, 20_011])
def test_the_envelope_has_the_extremes_of_every_part_and_the_ends(n):
    x = np.linspace(0.0, 20.0, n)
    y = np.random.default_rng(n).normal(size=n)
    few_x, few_y = envelope(x, y)
    assert len(few_x) <= 2 * ENVELOPE_BINS + 2
    assert set(zip(few_x, few_y)) <= set(zip(x, y))
    assert (np.diff(few_x) > 0).all()
    assert (few_x[0], few_x[-1]) == (x[0], x[-1])
    edges = np.linspace(0, n, ENVELOPE_BINS + 1).astype(int)
    for first, last in pairwise(edges):
        inside = few_y[(few_x >= x[first]) & (few_x <= x[last - 1])]
        assert (inside.min(), inside.max()) == (y[first:last].min(), y[first:last].max())


def test_a_short_curve_is_left_as_it_is():
    y = np.random.default_rng(0).normal(size=4 * ENVELOPE_BINS)
    assert np.array_equal(envelope(np.arange(4.0 * ENVELOPE_BINS), y)[1], y)


def test_the_envelope_keeps_the_one_sample_that_stands_out():
    y = np.zeros(20_000)
    y[12_345] = 7.0
    assert 7.0 in envelope(np.arange(20_000.0), y)[1]
