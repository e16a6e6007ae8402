"""A model's contact and friction laws as functions of numbers, compiled once for every structure.

A law of one's own may use sympy's functions (exp, sqrt): they become numpy's here.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import sympy

from frictionlab.models.symbols import Structure, numbers, parameter_symbols, structure, symbolic

GAP, NORMAL_FORCE, SPEED = sympy.symbols("gap normal_force speed", real=True)


def contact_force(model: Any) -> Callable[[Any], Any]:
    """F_N (N) as a function of the gap (m): a number, an array or a polynomial."""
    force, values = _compiled(structure(model))[0], numbers(model)
    return lambda gap: force(gap, *values)


def sliding_force(model: Any) -> Callable[[Any, float], Any]:
    """The kinetic friction force (N) as a function of F_N (N) and the speed (m/s)."""
    kinetic, values = _compiled(structure(model))[1], numbers(model)
    return lambda normal_force, speed: kinetic(normal_force, speed, *values)


@lru_cache(maxsize=256)
def _compiled(key: Structure) -> tuple[Callable[..., Any], Callable[..., Any]]:
    copy, parameters = symbolic(key), parameter_symbols(key)
    force = sympy.lambdify([GAP, *parameters], copy.contact.force(GAP), modules="numpy")
    friction = copy.friction.kinetic(NORMAL_FORCE, SPEED)
    return force, sympy.lambdify([NORMAL_FORCE, SPEED, *parameters], friction, modules="numpy")
