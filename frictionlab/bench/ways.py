"""The methods that are compared, by name, each with the package it needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.taylor import Taylor

from .interpreted import Interpreted
from .with_cvode import Cvode
from .with_diffrax import Diffrax
from .with_heyoka import Heyoka
from .with_pathsim import PathSim
from .with_scipy import SolveIvp

MOST = 100_000  # steps of the slow ones, which take a fifth of that where they get through


@dataclass(frozen=True)
class Way:
    """A method by name, made for an automaton, and the package it needs."""

    family: str
    name: str
    make: Callable[[HybridAutomaton], Method]
    needs: str = ""


def _taylor(tol: float) -> Way:
    return Way("frictionlab", f"frictionlab, tol {tol:.0e}", lambda a: Taylor(tol=tol))


def _order(order: int) -> Way:
    """The order that heyoka has at a tolerance of 1e-15, to compare the times of a step."""
    name = f"frictionlab, tol 1e-15, order {order}"
    return Way("frictionlab, other order", name, lambda a: Taylor(tol=1e-15, order=order))


def _interpreted(tol: float) -> Way:
    name = f"frictionlab, tol {tol:.0e}, interpreted"
    return Way("frictionlab, interpreted", name, lambda a: Interpreted(tol=tol))


def _rk4(step: float) -> Way:
    return Way("RK4", f"RK4, step {step:g} s", lambda a: RK4(step=step))


def _ivp(integrator: str, rtol: float) -> Way:
    def make(automaton: HybridAutomaton) -> Method:
        return SolveIvp(automaton, integrator, rtol, rtol * 1e-3)

    return Way(f"scipy {integrator}", f"scipy {integrator}, rtol {rtol:.0e}", make)


def _heyoka(tol: float) -> Way:
    return Way("heyoka", f"heyoka, tol {tol:.0e}", lambda a: Heyoka(a, tol), "heyoka")


def _cvode(formula: str, rtol: float) -> Way:
    def make(automaton: HybridAutomaton) -> Method:
        return Cvode(automaton, formula, rtol, rtol * 1e-3)

    return Way(f"CVODE {formula}", f"CVODE {formula}, rtol {rtol:.0e}", make, "sksundae")


def _pathsim(rtol: float) -> Way:
    def make(automaton: HybridAutomaton) -> Method:
        return PathSim(automaton, rtol=rtol, atol=rtol * 1e-3, max_steps=MOST)

    return Way("PathSim RKDP87", f"PathSim RKDP87, rtol {rtol:.0e}", make, "pathsim")


def _diffrax(rtol: float) -> Way:
    def make(automaton: HybridAutomaton) -> Method:
        return Diffrax(automaton, rtol, rtol * 1e-3, max_steps=MOST)

    return Way("diffrax Dopri8", f"diffrax Dopri8, rtol {rtol:.0e}", make, "diffrax")


WAYS = (
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
