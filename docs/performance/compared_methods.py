"""The methods that are compared, by name, each with the package it needs.

`InterpretedTaylor` is our own method without native code, to show what native code gains.  The regularised
model is a common alternative to events: it has tanh for the sign of friction and a contact that only pushes.
It has no events, no stick (v_r creeps where it should be zero) and no impacts: the contact springs back.  Any
integrator of stiff equations can run it; here it is LSODA with a compiled right-hand side.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from adapters import Cvode, Diffrax, Heyoka, PathSim, SolveIvp
from external import compile_peer
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.kernels import run_state, taylor_steps
from frictionlab.hybrid.methods.base import ActiveRun, Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models import SliderOnBelt
from frictionlab.models.mechanical.equations_of_motion import system_of
from frictionlab.models.symbols import symbol

REGULARISATION_WIDTH = 1e-3  # m/s, width over which friction reverses
RTOL = 1e-9

MAX_STEPS = 100_000  # most steps of the slow methods; runs that reach the end take a fifth of it


def regularised_flow(model: SliderOnBelt) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """States and their rates, with F_T = mu_k F_N tanh(v_r/width), and F_N = 0 unless the penetration is
    positive."""
    system = system_of(model.structure_key)
    contact = system.rubbing
    numbers = {symbol(name): value for name, value in model.parameters.items()}
    pressed = sympy.Piecewise((contact.pressing, contact.penetration > 0), (0, True))
    friction = model.mu_k * pressed * sympy.tanh(contact.relative_velocity / REGULARISATION_WIDTH)
    rows = zip(system.forces(contact, pressed), system.direction(contact), system.masses, strict=True)
    rates = [*system.v, *((force + w * friction) / mass for force, w, mass in rows)]
    return system.states, tuple(sympy.sympify(rate, strict=True).subs(numbers) for rate in rates)


def run_regularised(model: SliderOnBelt, t_end: float) -> tuple[np.ndarray, float, int]:
    """Final state from rest, processor time of a second run (a short first one compiles), and steps."""
    from scipy.integrate import solve_ivp

    z, rates = regularised_flow(model)
    flow = _compile_flow(z, rates)
    options: dict[str, Any] = {"method": "LSODA", "rtol": RTOL, "atol": RTOL * 1e-3}
    start = np.zeros(len(z))
    solve_ivp(flow, (0.0, min(t_end, 0.01)), start, **options)
    begin = time.process_time()
    solution = solve_ivp(flow, (0.0, t_end), start, **options)
    return solution.y[:, -1], time.process_time() - begin, len(solution.t) - 1


def _compile_flow(z: tuple[Any, ...], rates: tuple[Any, ...]) -> Any:
    kernel = compile_peer(sympy.lambdify([*z], list(rates), modules="math", cse=True))

    def flow(t: float, y: np.ndarray) -> np.ndarray:
        return np.array(kernel(*y))

    return flow


@dataclass(frozen=True)
class InterpretedTaylor(Taylor):
    """The Taylor method that interprets the tape: the code it uses holds no addresses of native code."""

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        system = run.system._replace(code=run.problem.program.code)
        truncation = run_state.Truncation(run.order, self.tol)
        return taylor_steps.advance_taylor(system, truncation, run.cursor, record, run.scratch)


@dataclass(frozen=True)
class ComparedMethod:
    """A method by name, how it is made for an automaton, and the package it needs."""

    family: str
    name: str
    create: Callable[[HybridAutomaton], Method]
    package: str = ""


def _taylor(tol: float) -> ComparedMethod:
    return ComparedMethod("frictionlab", f"frictionlab, tol {tol:.0e}", lambda a: Taylor(tol=tol))


def _order(order: int) -> ComparedMethod:
    """Taylor of a given order, that of heyoka at a tolerance of 1e-15, to compare the times of a step."""
    name = f"frictionlab, tol 1e-15, order {order}"
    return ComparedMethod("frictionlab, other order", name, lambda a: Taylor(tol=1e-15, order=order))


def _interpreted(tol: float) -> ComparedMethod:
    name = f"frictionlab, tol {tol:.0e}, interpreted"
    return ComparedMethod("frictionlab, interpreted", name, lambda a: InterpretedTaylor(tol=tol))


def _rk4(step: float) -> ComparedMethod:
    return ComparedMethod("RK4", f"RK4, step {step:g} s", lambda a: RK4(step=step))


def _ivp(integrator: str, rtol: float) -> ComparedMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return SolveIvp(automaton, integrator, rtol, rtol * 1e-3)

    return ComparedMethod(f"scipy {integrator}", f"scipy {integrator}, rtol {rtol:.0e}", create)


def _heyoka(tol: float, fast_math: bool = False) -> ComparedMethod:
    """It compiles each mode as a whole; its compact mode takes twice as long, and other settings of its
    compiler (opt_level=2, slp_vectorize) gain nothing."""
    family = "heyoka, fast_math" if fast_math else "heyoka"
    name = f"heyoka, tol {tol:.0e}" + (", fast_math" if fast_math else "")
    return ComparedMethod(family, name, lambda a: Heyoka(a, tol, fast_math), "heyoka")


def _cvode(formula: str, rtol: float) -> ComparedMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return Cvode(automaton, formula, rtol, rtol * 1e-3)

    return ComparedMethod(f"CVODE {formula}", f"CVODE {formula}, rtol {rtol:.0e}", create, "sksundae")


def _pathsim(rtol: float) -> ComparedMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return PathSim(automaton, rtol=rtol, atol=rtol * 1e-3, max_steps=MAX_STEPS)

    return ComparedMethod("PathSim RKDP87", f"PathSim RKDP87, rtol {rtol:.0e}", create, "pathsim")


def _diffrax(rtol: float) -> ComparedMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return Diffrax(automaton, rtol, rtol * 1e-3, max_steps=MAX_STEPS)

    return ComparedMethod("diffrax Dopri8", f"diffrax Dopri8, rtol {rtol:.0e}", create, "diffrax")


METHODS = (
    *map(_taylor, (1e-15, 1e-12, 1e-9, 1e-6)),
    _order(20),
    _interpreted(1e-15),
    *map(_rk4, (1e-3, 1e-4, 2e-5)),
    *(_ivp(name, rtol) for name in ("DOP853", "RK45", "LSODA") for rtol in (1e-7, 1e-10)),
    _ivp("Radau", 1e-7),
    *(_heyoka(tol, fast_math) for fast_math in (False, True) for tol in (1e-15, 1e-9)),
    *(_cvode(formula, rtol) for formula in ("Adams", "BDF") for rtol in (1e-8, 1e-11)),
    *map(_pathsim, (1e-7, 1e-10)),
    *map(_diffrax, (1e-8, 1e-12)),
)
