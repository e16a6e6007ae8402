"""PathSim: block diagrams in Python; each mode is an ODE block with its zero crossings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from .external import Lowered, Restarted

STAGES = 13  # evaluations of a step of RKDP87, for the cap


@dataclass(frozen=True)
class PathSim(Restarted):
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

    def __init__(self, settings: PathSim, functions: Lowered) -> None:
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
        self.left = STAGES * most
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
