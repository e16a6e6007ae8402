"""Scales of a motion: the range of each state, by which differences are measured, and the period of an
oscillation.

States are measured in three groups, coordinates, velocities and others, as each group has a unit of its own.
"""

from __future__ import annotations

from math import floor, log10
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import Model

Array = NDArray[np.float64]

# Range of a coordinate, as a share of the largest of them, below which it counts as that.
MIN_RANGE_RTOL = 1e-6
AT_REST_RTOL = 1e-9  # share of a coordinate's values below which it does not move

LEAST_MOTION_RTOL = 1e-6  # share of its values by which a coordinate is measured where it moves less

DEFAULT_PERIOD = 0.1  # s, of the slider on a belt
ROUND_NUMBER_RTOL = 1e-9  # share by which rounding may keep a number from the round one that it is


def state_ranges(states: Any) -> Array:
    """Range of each state over a motion; zero where there is none."""
    states = np.asarray(states, dtype=float)
    return states.max(axis=0) - states.min(axis=0) if len(states) else np.zeros(states.shape[1])


def state_groups(coordinates: int) -> tuple[slice, slice, slice]:
    """Coordinates, velocities, other states: each has a unit of its own."""
    return slice(coordinates), slice(coordinates, 2 * coordinates), slice(2 * coordinates, None)


def state_scales(states: Array, coordinates: int) -> Array:
    """The range of each state, by which differences are measured.

    It is at least a share of the largest range in its group, so that a state that only decays is not compared
    by its own small range.  A group that does not move is measured by its values.
    """
    found, values = state_ranges(states), np.abs(states).max(axis=0)
    for group in state_groups(coordinates):
        largest = found[group].max(initial=0.0) or values[group].max(initial=0.0) or 1.0
        found[group] = np.maximum(found[group], MIN_RANGE_RTOL * largest)
    return found


def motion_size(run: Trajectory, samples: int | None = None) -> Array:
    """Size of a motion, or of its first `samples`, in each state: the largest range in its group.

    Groups are coordinates, velocities, others.
    """
    # sampled within steps too: at the events of dry friction all velocities may be zero
    states = run.states[:samples]
    ranges, values = state_ranges(states), np.abs(states).max(axis=0)
    for group in state_groups(run.automaton.coordinates):
        largest = max(ranges[group].max(initial=0.0), LEAST_MOTION_RTOL * values[group].max(initial=0.0))
        ranges[group] = largest or 1.0
    return ranges


def oscillation_period(source: Any) -> float:
    """About the period of an oscillation (s): the model's; for an automaton that of the slider on a belt."""
    return source.period if isinstance(source, Model) else DEFAULT_PERIOD


def rounded_period(source: Any) -> float:
    """The same as 1, 2 or 5 times a power of ten, from below."""
    return round_down_1_2_5(oscillation_period(source))


def round_down_1_2_5(x: float) -> float:
    """The next smaller of 1, 2, 5, 10, 20, ...

    >>> round_down_1_2_5(37.0), round_down_1_2_5(0.05)
    (20.0, 0.05)
    """
    limit = x * (1 + ROUND_NUMBER_RTOL)
    power = 10.0 ** floor(log10(limit))
    return float(f"{max(d for d in (1, 2, 5) if d * power <= limit) * power:.3g}")
