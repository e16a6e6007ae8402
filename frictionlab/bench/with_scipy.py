"""scipy's solve_ivp as one would use it: compiled right-hand side, a call for each mode, terminal events."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .external import External, Lowered

IMPLICIT = ("Radau", "BDF", "LSODA")


@dataclass(frozen=True)
class SolveIvp(External):
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


def _event(functions: Lowered, i: int) -> Callable[[float, np.ndarray], float]:
    values = np.empty(functions.count)

    def event(time: float, y: np.ndarray) -> float:
        functions.guards(np.ascontiguousarray(y), values)
        return float(values[i])

    # solve_ivp reads these two from the function itself; the type checker knows no attributes of functions
    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    return event
