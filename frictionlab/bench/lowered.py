"""An automaton's flow and guards as compiled functions of floats: what other tools are given."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy

from frictionlab.automaton import Mode
from frictionlab.hybrid.compiled import NUMBA

Array = Any


class Lowered(NamedTuple):
    """A mode: functions of (z, out) that write into `out`; the numbers of the parameters are inside."""

    rates: Callable[[Array, Array], None]
    guards: Callable[[Array, Array], None]
    jacobian: Callable[[Array, Array], None]  # of the rates, row by row
    count: int  # guards


@lru_cache(maxsize=64)
def lowered(mode: Mode, states: tuple[Any, ...], values: tuple[tuple[Any, float], ...]) -> Lowered:
    """Functions of a mode with these parameter values; compiled by numba where it is installed."""
    numbers = dict(values)
    flow = [sympy.sympify(e).subs(numbers) for e in mode.flow]
    guards = [sympy.sympify(event.function).subs(numbers) for event in mode.events]
    jacobian = list(sympy.Matrix(flow).jacobian(states))
    return Lowered(_writer(states, flow), _writer(states, guards), _writer(states, jacobian), len(guards))


def _writer(states: tuple[Any, ...], expressions: list[Any]) -> Callable[[Array, Array], None]:
    """f(z, out), from the source that sympy prints."""
    z = [sympy.Symbol(f"z{i}") for i in range(len(states))]
    shared, results = sympy.cse([e.xreplace(dict(zip(states, z, strict=True))) for e in expressions])
    lines = ["def function(z, out):", *(f"    z{i} = z[{i}]" for i in range(len(z)))]
    lines += [f"    {name} = {sympy.pycode(value)}" for name, value in shared]
    lines += [f"    out[{i}] = {sympy.pycode(value)}" for i, value in enumerate(results)] or ["    pass"]
    space: dict[str, Any] = {"math": np}
    exec("\n".join(lines), space)
    return NUMBA.njit(space["function"]) if NUMBA else space["function"]
