"""Derivatives of any order along given directions, by sympy once, as numpy functions.

f(x + s u + t v + ...) is differentiated once by each of s, t, ... at zero.  The result is linear in each
direction, so it takes complex vectors, and it stays far smaller than a table of partial derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import NDArray

from .flow import Flow

Vector = NDArray[Any]


class Point(NamedTuple):
    """Where a flow is differentiated: its state (m,), and the values of its parameters."""

    flow: Flow
    state: NDArray[np.float64]
    values: Sequence[float]


def along(at: Point, *directions: Vector) -> Vector:
    """The derivative of x' along each of the directions (m,), complex or real: B(u, v) or C(u, v, w)."""
    return along_functions(at, at.flow.expressions, *directions)


def along_parameter(at: Point, parameter: str, *directions: Vector) -> Vector:
    """The derivative of x' by a parameter and along each of the directions (m,)."""
    return along_functions(at, _parameter_rates(at.flow, parameter), *directions)


def along_functions(at: Point, functions: tuple[Any, ...], *directions: Vector) -> Vector:
    """As :func:`along` for other functions of the state (k,); without directions their values."""
    form = _form(at.flow, functions, len(directions))
    return np.array(form(*at.state, *at.values, *chain.from_iterable(directions)))


@lru_cache(maxsize=256)
def _form(flow: Flow, functions: tuple[Any, ...], order: int) -> Callable[..., Any]:
    """A function of states, parameters and `order` directions, one after the other."""
    directions = [u for level in range(order) for u in _direction(level, len(flow.states))]
    expressions = list(_differentiated(functions, flow.states, order))
    arguments = [*flow.states, *flow.parameters, *directions]
    return sympy.lambdify(arguments, expressions, modules="numpy", cse=True)


@lru_cache(maxsize=256)
def _differentiated(functions: tuple[Any, ...], states: tuple[Any, ...], order: int) -> tuple[Any, ...]:
    if order == 0:
        return functions
    step = sympy.Dummy(real=True)
    moved = {x: x + step * u for x, u in zip(states, _direction(order - 1, len(states)))}
    lower = _differentiated(functions, states, order - 1)
    return tuple(_rate(f.xreplace(moved), step).xreplace({step: sympy.S.Zero}) for f in lower)


@lru_cache(maxsize=256)
def _parameter_rates(flow: Flow, parameter: str) -> tuple[Any, ...]:
    symbol = next(symbol for symbol in flow.parameters if symbol.name == parameter)
    return tuple(_rate(f, symbol) for f in flow.expressions)


def _rate(function: Any, symbol: Any) -> Any:
    # At a kink, such as that of |v_r|, no steady motion is smooth; elsewhere its impulse is zero.
    rate = sympy.diff(function, symbol)
    return rate.replace(sympy.DiracDelta, lambda *_: sympy.S.Zero) if rate.has(sympy.DiracDelta) else rate


@lru_cache(maxsize=64)
def _direction(level: int, count: int) -> tuple[Any, ...]:
    return tuple(sympy.Dummy(f"u{level}_{i}", real=True) for i in range(count))
