"""Steady sliding of a model, through its statics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.models.lagrange import mode_of
from frictionlab.models.regimes import regime
from frictionlab.models.symbols import Structure, numbers, parameter_symbols, structure, symbolic
from frictionlab.models.system import system_of

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

    solve: Callable[[Sequence[Any], int], Array] = partial(_solved, key)

    def pressed(x: Array, values: Sequence[Any]) -> Any:
        return (flow.margin(x, values) > 0) & ~_resting(key, values)

    if start is not None:
        solve = follower(flow, np.append(start, np.zeros(len(start))), values, pressed)
    guards = sliding_guards(key, bool(_belt_speed(key)(*values) > 0))
    return Steady(model, model.coordinates, flow, values, solve, guards)


@cache
def sliding_flow(key: Structure) -> Flow:
    """Sliding whose friction force has the sign of the belt's speed, whatever else the model can do."""
    found = system_of(key)
    mode = mode_of(found, (regime(found.rubbing, "slip", found),))
    return Flow(found.states, parameter_symbols(key), mode.flow, (found.rubbing.pressing,), len(found.q))


@cache
def sliding_guards(key: Structure, forwards: bool) -> tuple[Any, ...]:
    """The functions that stay positive while the model slides as in the flow: v_r, the gap."""
    found = system_of(key)
    contact = found.rubbing
    name = "slip" if "slip" in contact.modes else "slip+" if forwards else "slip-"
    sliding = regime(contact, name, found)
    return tuple(end.function for end in sliding.ends(sliding.force))


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
    return (np.asarray(_belt_speed(key)(*values)) == 0) & _sticks(key)


def _sticks(key: Structure) -> bool:
    return "stick" in system_of(key).rubbing.modes


@cache
def _belt_speed(key: Structure) -> Callable[..., Any]:
    found = system_of(key)
    speed = found.at_rest(found.rubbing.relative_velocity)
    return sympy.lambdify(parameter_symbols(key), speed, modules="numpy")
