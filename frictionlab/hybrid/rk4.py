"""The paper's algorithm as a method."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from frictionlab.hybrid import bookkeeping
from frictionlab.hybrid.fixed_step import advance_fixed
from frictionlab.hybrid.methods import Method, Run
from frictionlab.hybrid.validation import check_number


@dataclass(frozen=True)
class RK4(Method):
    """The algorithm of the paper's Fig. 19: classical Runge-Kutta on a fixed time grid.

    The conditions of a state are looked at only at the end of a step; where one fails, bisection finds
    the instant within the step, the state changes, and the rest of the step follows.  After a re-contact
    slip is entered.  What happens and ends within a step is not seen, so the results depend on `step`;
    use it to compare with the paper.

    Parameters
    ----------
    step : float
        Length of a step in seconds.
    max_steps, max_events : int
        A run that reaches one ends with a status and keeps what it has.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.01, method=fl.RK4(step=1e-3))
    >>> run.stats["steps"]
    10
    """

    name: ClassVar[str] = "rk4"
    entry: ClassVar[Any] = staticmethod(advance_fixed)

    step: float = 2e-4
    max_steps: int = field(default=10_000_000, kw_only=True)

    def __post_init__(self) -> None:
        check_number("step", self.step, above=0.0, cure="2e-4 s reproduces the paper")
        self.check_caps()

    @property
    def degree(self) -> int:
        return 8

    def advance(self, run: Run, record: bookkeeping.Record) -> int:
        problem, states = run.problem, len(run.cursor.state)
        arrays = run.natives.code, problem.numbers, run.absolute
        scratch = np.empty((5, states)), np.empty(states)
        return advance_fixed(*arrays, self.step, run.cursor, record, run.work, *scratch)
