"""diffrax (Kidger 2021): each mode's integration up to its first event is compiled once, by JAX."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import import_module
from typing import Any, ClassVar

import numpy as np
import sympy

from frictionlab.automaton import Mode

from .external import Restarted

LOCATED = 1e-12  # of time (s) and of a guard: smaller ones take all iterations it has


@dataclass(frozen=True)
class Diffrax(Restarted):
    """diffeqsolve with Dopri8, a PID controller and events located by bisection.

    Parameters
    ----------
    rtol, atol : float
    """

    name: ClassVar[str] = "diffrax"

    rtol: float = 1e-10
    atol: float = 1e-13

    @cached_property
    def solutions(self) -> list[Callable[..., Any]]:
        """Compiled, one for each mode."""
        automaton, values = self.automaton, self.values
        return [_solution(mode, automaton.states, values, self.max_steps) for mode in automaton.modes]

    def flow(self, mode: int, z: np.ndarray, length: float) -> tuple[float, np.ndarray, int, int]:
        # Not for the whole process: other users of JAX in it may want single precision.
        with import_module("jax").enable_x64(True):
            t, y, guard, steps = self.solutions[mode](z, length, self.rtol, self.atol)
        return float(t), np.array(y), int(guard), int(steps)


@lru_cache(maxsize=64)
def _solution(
    mode: Mode, states: tuple[Any, ...], values: tuple[Any, ...], max_steps: int
) -> Callable[..., Any]:
    """Time, state, guard, steps of a start and a length; the tolerances are arguments, to compile once."""
    jax, dx = import_module("jax"), import_module("diffrax")
    rates = _function(states, mode.flow, values)
    guards = _function(states, [event.function for event in mode.events], values) if mode.events else None
    term = dx.ODETerm(lambda t, y, args: rates(y))

    def solution(z: Any, length: Any, rtol: Any, atol: Any) -> Any:
        found = dx.diffeqsolve(
            term,
            dx.Dopri8(),
            t0=0.0,
            t1=length,
            dt0=None,
            y0=z,
            args=guards(z) <= 0.0 if guards else None,
            stepsize_controller=dx.PIDController(rtol=rtol, atol=atol),
            event=_event(guards) if guards else None,
            max_steps=max_steps,
            throw=False,
        )
        y = found.ys[-1]
        guard = jax.numpy.where(found.event_mask, guards(y).argmin(), -1) if guards else -1
        capped = found.result == dx.RESULTS.max_steps_reached  # counts rejected ones too
        steps = jax.numpy.where(capped, max_steps, found.stats["num_accepted_steps"])
        return found.ts[-1], y, guard, steps

    return jax.jit(solution)


def _event(guards: Callable[[Any], Any]) -> Any:
    """The smallest guard falls through zero; those that were zero at the start count from then on.

    One function, since of several in a step diffrax takes the first in the list, not in time, and since
    the root finder that cannot miss, bisection, wants one.
    """
    where: Any = import_module("jax.numpy").where

    def smallest(t: Any, y: Any, args: Any, **_: Any) -> Any:
        return where(args & (t <= 0.0), 1.0, guards(y)).min()

    bisection = import_module("optimistix").Bisection(rtol=0.0, atol=LOCATED, flip=True)
    return import_module("diffrax").Event(smallest, bisection, direction=False)


def _function(states: tuple[Any, ...], expressions: Sequence[Any], values: tuple[Any, ...]) -> Any:
    """Expressions as a function of an array, which returns one."""
    stack, numbers = import_module("jax.numpy").stack, dict(values)
    with_numbers = [sympy.sympify(e).subs(numbers) for e in expressions]
    function = sympy.lambdify(states, with_numbers, modules="jax", cse=True)
    return lambda y: stack(function(*y))
