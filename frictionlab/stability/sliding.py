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

from .automata import follower
from .flow import Flow
from .pressed import pressed_gap
from .statics import Statics, each_statics
from .steady import Steady

Array = NDArray[np.float64]


def steady_sliding(model: Any, start: Array | None = None) -> Steady:
    """Steady sliding of a model at the equilibrium with F_N > 0 and the smallest gap.

    Or at that whose coordinates are `start` (n,), followed from there.
    """
    key, values = structure(model), numbers(model)
    flow = sliding_flow(key)

    def solve(values: Sequence[Any], count: int) -> Array:
        return _solved(key, values, count)

    def pressed(x: Array, values: Sequence[Any]) -> Any:
        return (flow.margin(x, values) > 0) & ~_resting(key, values)

    if start is None:
        return Steady(model, model.coordinates, flow, values, solve)
    followed = follower(flow, np.append(start, np.zeros(len(start))), values, pressed)
    return Steady(model, model.coordinates, flow, values, followed)


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
    x = np.full((2 * len(coordinates), count), np.nan)
    for statics, chosen in each_statics(key, values, coordinates, count):
        some = [v if np.ndim(v) == 0 else np.broadcast_to(v, (count,))[chosen] for v in values]
        x[:, chosen] = _pressed(statics, some, len(x), int(chosen.sum()))
    x[:, np.broadcast_to(_resting(key, values), (count,))] = np.nan
    return x


def _pressed(statics: Statics, values: Sequence[Any], rows: int, count: int) -> Array:
    gaps = pressed_gap(statics, values, count)
    x = np.zeros((rows, count))
    for row, q in zip(x, statics.coordinates(gaps, *values)):
        row[:] = q
    x[:, np.isnan(gaps)] = np.nan
    return x


def _resting(key: Structure, values: Sequence[Any]) -> Any:
    """Where the belt rests and the model has stick: friction has no derivative there."""
    speed = values[[s.name for s in parameter_symbols(key)].index("v")]
    return (np.asarray(speed) == 0) & ("stick" in symbolic(key).interface.modes)
