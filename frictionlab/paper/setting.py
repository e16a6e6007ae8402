"""How the figures on steady states are computed: by which algorithm, with which impact law, how finely."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path
from typing import Any

from frictionlab.components import PlasticImpact
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.taylor import Taylor
from frictionlab.hybrid.validation import check_choice

ALGORITHMS = ("exact", "paper")
IMPACTS = ("paper", "full gap rate")
STEP = 2e-4  # s, of the paper's algorithm: that at which it gives the paper's 1.58 Hz
# s.  Under Eq. (13) flights pile up by the thousand: replaced by their limit from here on, which leaves
# errors of 1e-8 in the usual structure.
CHATTER = 1e-5
MOST = 1_000_000  # events, and steps, of a run: one that grows without bound ends there
TAYLOR = Taylor(chatter=CHATTER, max_events=MOST, max_steps=MOST)
FASTEST = 20.0  # Hz, of a mode of the usual structure
# The exact solver returns to a state within rounding.  A fixed step sees a condition up to a step late, while
# a state moves by 2 pi f h of its size, 2.5 %: at both crossings, and at an event or more before each.
TOLERANCES = {"exact": 1e-6, "paper": round(4 * 2 * pi * FASTEST * STEP, 3)}


@dataclass(frozen=True)
class Setting:
    """What the figures 7 to 18 can be computed with; see :func:`frictionlab.paper.figure`."""

    algorithm: str = "exact"
    impact: str = "paper"
    quick: bool = False
    workers: int | None = field(default=None, compare=False)
    progress: bool = field(default=True, compare=False)
    resume: Path | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        check_choice("algorithm", self.algorithm, ALGORITHMS)
        check_choice("impact", self.impact, IMPACTS)

    @property
    def method(self) -> Method:
        """The solver."""
        return TAYLOR if self.algorithm == "exact" else RK4(step=STEP)

    @property
    def tolerance(self) -> float:
        """To which share of its size a motion has to return to count as periodic."""
        return TOLERANCES[self.algorithm]

    def adapted(self, model: Any) -> Any:
        """The model with the impact law asked for; without GN both laws are the same."""
        if self.impact == "paper" or "phi" not in model.coordinates:
            return model
        return model.replace(impact=PlasticImpact(gap_rate="full"))

    def with_(self, algorithm: str, impact: str) -> Setting:
        """Another way, all else the same."""
        return replace(self, algorithm=algorithm, impact=impact)

    @property
    def solver(self) -> str:
        """The algorithm in words."""
        return "exact solver" if self.algorithm == "exact" else f"paper's algorithm, step {STEP:g} s"

    def __str__(self) -> str:
        return f"{self.solver}, {'Eq. (13)' if self.impact == 'paper' else 'full gap rate'}"
