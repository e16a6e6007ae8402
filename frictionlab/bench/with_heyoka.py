"""heyoka (Biscani & Izzo 2021): Taylor series of high order, compiled for each mode, with event detection."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import import_module
from math import prod
from typing import Any, ClassVar

import numpy as np
import sympy

from frictionlab.automaton import Mode

from .external import AT_ONCE, External


@dataclass(frozen=True)
class Heyoka(External):
    """heyoka's adaptive Taylor integrator.

    Parameters
    ----------
    tol : float
    """

    name: ClassVar[str] = "heyoka"

    tol: float = 1e-15

    @cached_property
    def integrators(self) -> list[Any]:
        """One for each mode, with a cell that holds the time at which it began."""
        automaton, values = self.automaton, self.values
        return [_integrator(mode, automaton.states, values, self.tol) for mode in automaton.modes]

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        integrator, began = self.integrators[mode]
        began[0] = t
        if self.automaton.modes[mode].events:
            integrator.reset_cooldowns()
        integrator.time, integrator.state[:] = t, z
        if self.automaton.modes[mode].events:
            # Where an event function is zero at the start of a step, heyoka does not find its next zero.
            integrator.step(min(AT_ONCE, t_end - t))
        outcome, _, _, steps, *_ = integrator.propagate_until(t_end)
        code = int(outcome)
        # A terminal event i that stops ends with the outcome -i - 1.
        guard = -code - 1 if -1000 < code < 0 else -1
        return integrator.time, integrator.state.copy(), guard, steps


def _converted(expression: Any, hy: Any) -> Any:
    """heyoka's expression; whole powers as products, since its pow() is not a number at a base of zero."""
    if expression.is_Number:
        return hy.expression(float(expression))
    if expression.is_Symbol:
        return hy.expression(expression.name)
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return prod(
            [_converted(expression.base, hy)] * (int(expression.exp) - 1),
            start=_converted(expression.base, hy),
        )
    parts = [_converted(part, hy) for part in expression.args]
    if expression.is_Add:
        return hy.sum(parts)
    return prod(parts[1:], start=parts[0]) if expression.is_Mul else hy.from_sympy(expression)


@lru_cache(maxsize=64)
def _integrator(mode: Mode, states: tuple[Any, ...], values: tuple[Any, ...], tol: float) -> Any:
    hy: Any = import_module("heyoka")

    names = [sympy.Symbol(f"z{i}") for i in range(len(states))]
    renamed, numbers = dict(zip(states, names, strict=True)), dict(values)

    def of(expression: Any) -> Any:
        return _converted(sympy.sympify(expression).subs(numbers).xreplace(renamed), hy)

    system = [(hy.expression(str(name)), of(rate)) for name, rate in zip(names, mode.flow, strict=True)]
    # A guard is positive while its mode lasts: without a direction the zero at the start is an event too.
    # With one, rounding can still make it fall through zero just after the start; that is passed over.
    began = [0.0]

    def goes_on(integrator: Any, sign: int) -> bool:
        return integrator.time - began[0] < AT_ONCE

    options = {"direction": hy.event_direction.negative, "callback": goes_on}
    events = [hy.t_event(of(event.function), **options) for event in mode.events]
    return hy.taylor_adaptive(system, [0.0] * len(states), tol=tol, t_events=events), began
