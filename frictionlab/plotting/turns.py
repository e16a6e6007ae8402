"""Angles that turn are drawn modulo a turn, from -pi to pi, with ticks in multiples of pi.

The panels of explorers and pages follow the same rule, in pages/scripts/turns.js.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from matplotlib.ticker import FuncFormatter, MultipleLocator
from numpy.typing import NDArray

from frictionlab.presentation import state_unit

Array = NDArray[np.float64]
TURN = 2 * np.pi


class Cyclic(Protocol):
    """What has cyclic coordinates: an automaton, or a result of its runs."""

    @property
    def cyclic(self) -> Sequence[str]:
        """Their names."""
        ...


def turning_angles(automaton: Cyclic) -> list[str]:
    """The coordinates that are drawn modulo a turn: cyclic ones that are angles by their names.

    The motion of any other angle, as on a torsion spring, is not the same a turn further on.
    """
    return [name for name in automaton.cyclic if state_unit(name) == "rad"]


def within_turn(angle: Array) -> Array:
    """Angles between -pi and pi.

    >>> within_turn(np.array([0.5, 0.5 + 2 * np.pi, -4.0])).round(6).tolist()
    [0.5, 0.5, 2.283185]
    """
    return angle - TURN * np.floor((angle + np.pi) / TURN)


def cut_at_turns(angle: Array, other: Array) -> tuple[Array, Array]:
    """Angles (K,) modulo a turn and what is drawn over them (K,), cut where the angle comes to -pi or pi.

    There are three points more at each cut: on its one side, NaN, on its other.  Points more than half a turn
    apart do not tell how the angle has turned: they are not joined, and three NaN stand between them.
    """
    turn, fast = np.floor((angle + np.pi) / TURN), np.abs(np.diff(angle)) > np.pi
    cuts = np.flatnonzero((np.nan_to_num(np.diff(turn)) != 0) | fast) + 1
    border = TURN * np.maximum(turn[cuts - 1], turn[cuts]) - np.pi
    share = np.where(fast[cuts - 1], np.nan, (border - angle[cuts - 1]) / (angle[cuts] - angle[cuts - 1]))
    there = other[cuts - 1] + share * (other[cuts] - other[cuts - 1])
    nothing = np.full(len(cuts), np.nan)
    side = np.where(fast[cuts - 1], nothing, np.pi * np.sign(turn[cuts] - turn[cuts - 1]))
    places = np.repeat(cuts, 3)
    edges = np.column_stack([side, nothing, -side]).ravel()
    return np.insert(within_turn(angle), places, edges), np.insert(other, places, np.repeat(there, 3))


def tick_turns(axis: Any) -> None:
    """Tick an axis of matplotlib that shows more than pi at multiples of pi/2, written as such."""
    if abs(np.subtract(*axis.get_view_interval())) <= np.pi:
        return
    axis.set_major_locator(MultipleLocator(np.pi / 2))
    axis.set_major_formatter(FuncFormatter(lambda x, _: _multiple_of_pi(x)))


def _multiple_of_pi(x: float) -> str:
    halves = round(2 * x / np.pi)
    if not halves:
        return "0"
    count, under = (abs(halves) // 2, "") if halves % 2 == 0 else (abs(halves), "/2")
    return f"${'-' if halves < 0 else ''}{count if count > 1 else ''}\\pi{under}$"
