"""The regularised model, a common alternative to events: tanh for the sign of friction, a contact that only
pushes.

There are no events, no stick (v_r creeps where it should be zero) and no impacts: the contact springs
back.  Any integrator of stiff equations runs it, here LSODA with a compiled right-hand side.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import sympy

from frictionlab.hybrid.compilation import NUMBA
from frictionlab.models.mechanical.equations_of_motion import system_of
from frictionlab.models.symbols import structure_of_component, symbol

REGULARISATION_WIDTH = 1e-3  # m/s, width over which friction reverses
RTOL = 1e-9


def regularised_flow(model: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """States and their rates, with F_T = mu_k F_N tanh(v_r/width) and F_N only where the penetration is
    positive."""
    found = system_of(structure_of_component(model))
    contact = found.rubbing
    numbers = {symbol(name): value for name, value in model.parameters.items()}
    pressed = sympy.Piecewise((contact.pressing, contact.penetration > 0), (0, True))
    friction = model.mu_k * pressed * sympy.tanh(contact.relative_velocity / REGULARISATION_WIDTH)
    rows = zip(found.forces(contact, pressed), found.direction(contact), found.masses, strict=True)
    rates = [*found.v, *((force + w * friction) / mass for force, w, mass in rows)]
    return found.states, tuple(sympy.sympify(rate).subs(numbers) for rate in rates)


def run(model: Any, t_end: float) -> tuple[np.ndarray, float, int]:
    """State at the end, from rest, wall time of a second run (the first compiles), and steps."""
    from scipy.integrate import solve_ivp

    z, rates = regularised_flow(model)
    flow = _compile_flow(z, rates)
    options: dict[str, Any] = {"method": "LSODA", "rtol": RTOL, "atol": RTOL * 1e-3}
    start = np.zeros(len(z))
    solve_ivp(flow, (0.0, min(t_end, 0.01)), start, **options)
    begin = time.perf_counter()
    found = solve_ivp(flow, (0.0, t_end), start, **options)
    return found.y[:, -1], time.perf_counter() - begin, len(found.t) - 1


def _compile_flow(z: tuple[Any, ...], rates: tuple[Any, ...]) -> Any:
    kernel = sympy.lambdify([*z], list(rates), modules="math", cse=True)
    kernel = kernel if NUMBA is None else NUMBA.njit(kernel)

    def flow(t: float, y: np.ndarray) -> np.ndarray:
        return np.array(kernel(*y))

    return flow
