"""Steady sliding of a model, through its statics."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.models.assembly import derive
from frictionlab.models.modes import build
from frictionlab.models.symbols import Structure, numbers, parameter_symbols, structure, symbolic

from .flow import Flow
from .pressed import pressed_gap
from .statics import statics_of
from .steady import Steady

Array = NDArray[np.float64]


def steady_sliding(model: Any) -> Steady:
    """Steady sliding of a model at the equilibrium with F_N > 0 and the smallest gap."""
    key = structure(model)

    def solve(values: Sequence[Any], count: int) -> Array:
        return _solved(key, values, count)

    return Steady(model, model.coordinates, sliding_flow(key), numbers(model), solve)


@cache
def sliding_flow(key: Structure) -> Flow:
    """Sliding whose friction force has the sign of the belt's speed, whatever else the model can do."""
    scene = derive(key)
    mode = build(scene, "slip")
    outputs = {"normal_force": scene.normal_force}
    return Flow(
        (*scene.q, *scene.v), parameter_symbols(key), mode.flow, tuple(outputs.values()), len(scene.q)
    )


def _solved(key: Structure, values: Sequence[Any], count: int) -> Array:
    coordinates = symbolic(key).coordinates
    try:
        statics = statics_of(key, values, coordinates)
    except ValueError:
        if count == 1:
            raise
        return np.hstack([_alone(key, values, i) for i in range(count)])
    gaps = pressed_gap(statics, values, count)
    x = np.zeros((2 * len(coordinates), count))
    for row, q in zip(x, statics.coordinates(gaps, *values)):
        row[:] = q
    x[:, np.isnan(gaps) | _resting(key, values)] = np.nan
    return x


def _alone(key: Structure, values: Sequence[Any], i: int) -> Array:
    """The i-th of many: one singular stiffness matrix must not spoil all."""
    single = [np.ravel(v)[min(i, np.size(v) - 1)] for v in values]
    try:
        return _solved(key, single, 1)
    except ValueError:
        return np.full((2 * len(symbolic(key).coordinates), 1), np.nan)


def _resting(key: Structure, values: Sequence[Any]) -> Any:
    """Where the belt rests and the model has stick: friction has no derivative there."""
    speed = values[[s.name for s in parameter_symbols(key)].index("v")]
    return (np.asarray(speed) == 0) & ("stick" in symbolic(key).interface.modes)
