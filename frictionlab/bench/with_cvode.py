"""CVODE (Hindmarsh et al. 2005) with its root finding, through scikit-sundae."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from .external import External, Lowered


@dataclass(frozen=True)
class Cvode(External):
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


def _events(functions: Lowered) -> Any:
    def events(time: float, y: np.ndarray, out: np.ndarray) -> None:
        functions.guards(y, out)

    # sksundae reads these two from the function itself; the type checker knows no attributes of functions
    both = [True] * functions.count, [-1] * functions.count
    events.terminal, events.direction = both  # type: ignore[attr-defined]
    return events
