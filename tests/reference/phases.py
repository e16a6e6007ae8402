"""Motions in phases, each with rates of its own, by DOP853 of scipy from event to event.

Nothing comes from the package.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Function = Callable[[float, Any], Any]  # of time and state
# Rates, and what ends the phase: functions that fall through zero, each with the phase that follows, or with
# a function that gives it and its first state.
Phase = tuple[Function, tuple[tuple[Function, Any], ...]]


def until_events(
    phases: Mapping[Any, Phase], phase: Any, z: Any, t_end: float, *, t: float = 0.0, **options: Any
) -> tuple[Any, list[tuple[float, Any, Any]]]:
    """The state at `t_end`, and of each event its time, the phase that it begins, and the state there."""
    events, z = [], np.array(z, dtype=float)
    options = {"rtol": 1e-12, "atol": 1e-13} | options
    while t < t_end:
        rates, ends = phases[phase]
        falling = [_falling(function) for function, _ in ends]
        found = solve_ivp(rates, (t, t_end), z, "DOP853", events=falling, **options)
        t, z = float(found.t[-1]), found.y[:, -1].copy()
        for (_, then), times in zip(ends, found.t_events or (), strict=True):
            if len(times):
                phase, z = then(t, z) if callable(then) else (then, z)
                z = np.array(z, dtype=float)
                events.append((t, phase, z))
                break
    return z, events


def _falling(function: Function) -> Any:
    def of(t: float, z: Any) -> Any:
        return function(t, z)

    of.terminal, of.direction = True, -1
    return of
