"""Assertions about arrays that refuse to hold where there is nothing to compare."""

import numpy as np
import pytest


def assert_same_times(found, expected, **tolerance):
    """There is at least one time, there are as many as expected, and each is the expected one."""
    assert len(expected) > 0, "there is nothing to compare with"
    assert len(found) == len(expected)
    assert found == pytest.approx(expected, **tolerance)


def assert_all(conditions):
    """There is at least one sample, and the condition holds at all of them."""
    assert np.size(conditions) > 0, "there is no sample at which the condition could fail"
    assert np.all(conditions)
