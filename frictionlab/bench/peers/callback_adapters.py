"""Tools that call functions back: scipy's solve_ivp, CVODE, PathSim.

scipy as users call it: compiled right-hand side, a call for each mode, terminal events.  CVODE
(Hindmarsh et al. 2005) with its root finding, through scikit-sundae.  PathSim: block diagrams in
Python; each mode is an ODE block with its zero crossings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from .external import CompiledMode, ExternalMethod, RestartedMethod

IMPLICIT = ("Radau", "BDF", "LSODA")

EVALUATIONS_PER_STEP = 13  # evaluations of a step of RKDP87, for the cap


@dataclass(frozen=True)
class SolveIvp(ExternalMethod):
    """scipy.integrate.solve_ivp; the implicit methods are given the exact Jacobian.

    Parameters
    ----------
    integrator : str
        RK45, DOP853, LSODA, Radau ...
    rtol, atol : float
    """

    name: ClassVar[str] = "solve_ivp"

    integrator: str = "DOP853"
    rtol: float = 1e-10
    atol: float = 1e-13

    def prepare(self, z: np.ndarray) -> None:
        super().prepare(z)
        for functions in self.modes if self.integrator in IMPLICIT else ():
            functions.jacobian(z, np.empty(z.size**2))  # LSODA asks for it only where it is stiff

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        from scipy.integrate import solve_ivp

        functions = self.modes[mode]
        events = [_event(functions, i) for i in range(functions.count)]

        def rates(time: float, y: np.ndarray) -> np.ndarray:
            out = np.empty_like(y)
            functions.rates(y, out)
            return out

        def jacobian(time: float, y: np.ndarray) -> np.ndarray:
            out = np.empty(y.size**2)
            functions.jacobian(np.ascontiguousarray(y), out)
            return out.reshape(y.size, y.size)

        options: dict[str, Any] = {"method": self.integrator, "rtol": self.rtol, "atol": self.atol}
        if self.integrator in IMPLICIT:
            options["jac"] = jacobian
        found = solve_ivp(rates, (t, t_end), z, events=events, **options)
        hit = [i for i in range(functions.count) if len(found.t_events[i])]
        guard = hit[0] if hit else -1
        return float(found.t[-1]), found.y[:, -1].copy(), guard, len(found.t) - 1


def _event(functions: CompiledMode, i: int) -> Callable[[float, np.ndarray], float]:
    values = np.empty(functions.count)

    def event(time: float, y: np.ndarray) -> float:
        functions.guards(np.ascontiguousarray(y), values)
        return float(values[i])

    # solve_ivp reads these two from the function itself; the type checker knows no attributes of functions
    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    return event


@dataclass(frozen=True)
class Cvode(ExternalMethod):
    """SUNDIALS' multistep methods.

    Parameters
    ----------
    formula : "Adams" or "BDF"
    rtol, atol : float
    """

    name: ClassVar[str] = "cvode"

    formula: str = "Adams"
    rtol: float = 1e-11
    atol: float = 1e-14

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        functions = self.modes[mode]
        options: dict[str, Any] = {"method": self.formula, "rtol": self.rtol, "atol": self.atol}
        if functions.count:
            options |= {"eventsfn": _events(functions), "num_events": functions.count}
        solver = import_module("sksundae.cvode").CVODE(
            lambda time, y, out: functions.rates(y, out), max_num_steps=10**7, **options
        )
        found = solver.solve(np.array([t, t_end]), z)
        steps = len(found.t) - 1  # between two times it returns its own steps
        if found.i_events is None or not len(found.i_events):
            return float(found.t[-1]), np.array(found.y[-1]), -1, steps
        guard = int(np.flatnonzero(found.i_events[-1])[0])
        return float(found.t_events[-1]), np.array(found.y_events[-1]), guard, steps


def _events(functions: CompiledMode) -> Any:
    def events(time: float, y: np.ndarray, out: np.ndarray) -> None:
        functions.guards(y, out)

    # sksundae reads these two from the function itself; the type checker knows no attributes of functions
    both = [True] * functions.count, [-1] * functions.count
    events.terminal, events.direction = both  # type: ignore[attr-defined]
    return events


@dataclass(frozen=True)
class PathSim(RestartedMethod):
    """A simulation for each mode, built once.

    Parameters
    ----------
    solver : str
        RKDP87, RKV65, RKDP54, ...
    rtol, atol : float
    located : float
        An event is found where its guard is no larger than this.
    """

    name: ClassVar[str] = "pathsim"

    solver: str = "RKDP87"
    rtol: float = 1e-10
    atol: float = 1e-13
    located: float = 1e-10

    @cached_property
    def diagrams(self) -> list[_Diagram]:
        """Those of all modes."""
        return [_Diagram(self, functions) for functions in self.modes]

    def flow(self, mode: int, z: np.ndarray, length: float) -> tuple[float, np.ndarray, int, int]:
        return self.diagrams[mode].run(z, length, self.max_steps - self.steps)


class _Diagram:
    """One ODE block, and an event for each guard that stops the simulation; time starts at zero again."""

    def __init__(self, settings: PathSim, functions: CompiledMode) -> None:
        pathsim: Any = import_module("pathsim")
        self.functions, self.values = functions, np.empty(functions.count)
        self.halt: type[Exception] = pathsim.StopSimulation
        self.block = pathsim.blocks.ODE(self._rates, np.zeros(len(settings.automaton.states)))
        crossing = pathsim.events.ZeroCrossingDown
        self.simulation = pathsim.Simulation(
            [self.block],
            events=[
                crossing(self._guard(i), self._stop(i), settings.located) for i in range(functions.count)
            ],
            Solver=getattr(pathsim.solvers, settings.solver),
            log=False,
            tolerance_lte_rel=settings.rtol,
            tolerance_lte_abs=settings.atol,
        )

    def run(self, z: np.ndarray, length: float, most: int) -> tuple[float, np.ndarray, int, int]:
        """From `z` up to an event or the end: time that passed, state, guard or -1, steps."""
        self.found: tuple[float, np.ndarray, int] | None = None
        self.left = EVALUATIONS_PER_STEP * most
        self.block.initial_value = z
        self.simulation.dt = None  # it estimates the first step by itself
        self.simulation.reset()
        steps = self.simulation.run(length)["successful_steps"]
        end = self.found or (float(self.simulation.time), self.block.engine.state.copy(), -1)
        return *end, steps if self.left >= 0 else most

    def _rates(self, z: np.ndarray, u: np.ndarray, t: float) -> np.ndarray:
        self.left -= 1
        if self.left < 0:
            raise self.halt("step cap")
        out = np.empty_like(z)
        self.functions.rates(z, out)
        return out

    def _guard(self, i: int) -> Callable[[float], float]:
        def value(t: float) -> float:
            self.functions.guards(self.block.engine.state, self.values)
            return float(self.values[i])

        return value

    def _stop(self, i: int) -> Callable[[float], None]:
        def stop(t: float) -> None:
            # Where a later event of the same step is still to be located the step is taken back.
            self.found = self.found or (float(t), self.block.engine.state.copy(), i)
            self.simulation.stop()

        return stop
