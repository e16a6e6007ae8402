"""The methods that are compared, by name, each with the package it needs.

`InterpretedTaylor` is our own method without native code, to show what native code gains.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.kernels import run_state, taylor_steps
from frictionlab.hybrid.methods.base import ActiveRun, Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor

from .callback_adapters import Cvode, PathSim, SolveIvp
from .compiled_adapters import Diffrax, Heyoka

MAX_STEPS = 100_000  # cap of steps of the slow methods; those that reach the end take a fifth of it


@dataclass(frozen=True)
class InterpretedTaylor(Taylor):
    """The Taylor method on the tape alone: the program's own code holds no addresses of native code."""

    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        system = run.system._replace(code=run.problem.program.code)
        truncation = run_state.Truncation(self.degree, self.tol)
        return taylor_steps.advance_taylor(system, truncation, run.cursor, record, run.scratch)


@dataclass(frozen=True)
class BenchMethod:
    """A method by name, made for an automaton, and the package it needs."""

    family: str
    name: str
    create: Callable[[HybridAutomaton], Method]
    package: str = ""


def _taylor(tol: float) -> BenchMethod:
    return BenchMethod("frictionlab", f"frictionlab, tol {tol:.0e}", lambda a: Taylor(tol=tol))


def _order(order: int) -> BenchMethod:
    """The order that heyoka has at a tolerance of 1e-15, to compare the times of a step."""
    name = f"frictionlab, tol 1e-15, order {order}"
    return BenchMethod("frictionlab, other order", name, lambda a: Taylor(tol=1e-15, order=order))


def _interpreted(tol: float) -> BenchMethod:
    name = f"frictionlab, tol {tol:.0e}, interpreted"
    return BenchMethod("frictionlab, interpreted", name, lambda a: InterpretedTaylor(tol=tol))


def _rk4(step: float) -> BenchMethod:
    return BenchMethod("RK4", f"RK4, step {step:g} s", lambda a: RK4(step=step))


def _ivp(integrator: str, rtol: float) -> BenchMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return SolveIvp(automaton, integrator, rtol, rtol * 1e-3)

    return BenchMethod(f"scipy {integrator}", f"scipy {integrator}, rtol {rtol:.0e}", create)


def _heyoka(tol: float) -> BenchMethod:
    return BenchMethod("heyoka", f"heyoka, tol {tol:.0e}", lambda a: Heyoka(a, tol), "heyoka")


def _cvode(formula: str, rtol: float) -> BenchMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return Cvode(automaton, formula, rtol, rtol * 1e-3)

    return BenchMethod(f"CVODE {formula}", f"CVODE {formula}, rtol {rtol:.0e}", create, "sksundae")


def _pathsim(rtol: float) -> BenchMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return PathSim(automaton, rtol=rtol, atol=rtol * 1e-3, max_steps=MAX_STEPS)

    return BenchMethod("PathSim RKDP87", f"PathSim RKDP87, rtol {rtol:.0e}", create, "pathsim")


def _diffrax(rtol: float) -> BenchMethod:
    def create(automaton: HybridAutomaton) -> Method:
        return Diffrax(automaton, rtol, rtol * 1e-3, max_steps=MAX_STEPS)

    return BenchMethod("diffrax Dopri8", f"diffrax Dopri8, rtol {rtol:.0e}", create, "diffrax")


METHODS = (
    *map(_taylor, (1e-15, 1e-10, 1e-6)),
    _order(20),
    _interpreted(1e-15),
    *map(_rk4, (1e-3, 1e-4, 2e-5)),
    *(_ivp(name, rtol) for name in ("DOP853", "RK45", "LSODA") for rtol in (1e-7, 1e-10)),
    _ivp("Radau", 1e-7),
    *map(_heyoka, (1e-15, 1e-9)),
    *(_cvode(formula, rtol) for formula in ("Adams", "BDF") for rtol in (1e-8, 1e-11)),
    *map(_pathsim, (1e-7, 1e-10)),
    *map(_diffrax, (1e-8, 1e-12)),
)
