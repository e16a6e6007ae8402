"""All branches of equilibria over a range of a parameter, also those that exist over a part of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .automata import automaton_of, no_equilibrium, steady_from, steady_states, values_of
from .statics import by_gap
from .steady import Steady
from .view import steady

Array = NDArray[np.float64]
SAMPLES = 9  # values at which all equilibria are looked for: one branch may live between two of them
SAME, ROUNDING = 1e-6, 1e-12  # shares of a state and of the largest, to which two branches agree


def branches(model: Any, parameter: str, bounds: tuple[float, float]) -> list[Steady]:
    """The equilibria inside the guards of a mode at some values in the range, each followed from there.

    Where they follow from the gap (`by_gap`) the one with the smallest gap.

    Raises
    ------
    ValueError
        If there is none in the range.
    """
    if by_gap(model):
        return [steady(model)]
    at, found = np.linspace(*bounds, SAMPLES), []
    ways: list[Array] = []  # states (m, SAMPLES) of each branch, NaN where it is not
    for i, value in enumerate(at):
        mode, flow, points = steady_states(model, **{parameter: float(value)})
        for x in points.T:
            if any(view.flow is flow and _same(way[:, i], x) for view, way in zip(found, ways)):
                continue
            values = values_of(automaton_of(model).replace(**{parameter: float(value)}))
            found.append(steady_from(model, mode, flow, x, values))
            ways.append(found[-1].solve(*found[-1].at({parameter: at})))
    if not found:
        raise no_equilibrium(model)
    return found


def _same(x: Array, other: Array) -> bool:
    size = np.fmax(np.abs(x), np.abs(other))
    return bool((np.abs(x - other) <= SAME * size + ROUNDING * size.max()).all())
