"""Solver settings, models, times and grids of parameters of the paper's computations.

`Setting` says by which algorithm, with which impact law and how finely figures 7 to 18 are computed.  The
paper gives no grids: mu_k goes in steps of 0.05 or 0.1, with further values that its text names, and the
preload is varied over the range of Fig. 4.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.components import PlasticImpact
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models import SliderOnBelt
from frictionlab.validation import check_choice

ALGORITHMS = ("exact", "paper")
IMPACTS = ("paper", "full gap rate")
PAPER_STEP = 2e-4  # s, of the paper's algorithm: that at which it gives the paper's 1.58 Hz
# s.  Under Eq. (13) there are thousands of ever shorter flights: replaced by their limit from here on, which
# leaves
# errors of 1e-8 in the usual structure.
CHATTER_LIMIT = 1e-5
MAX_EVENTS_AND_STEPS = 1_000_000  # events, and steps, of a run: one that grows without bound ends there
TAYLOR = Taylor(chatter=CHATTER_LIMIT, max_events=MAX_EVENTS_AND_STEPS, max_steps=MAX_EVENTS_AND_STEPS)
HIGHEST_FREQUENCY = 20.0  # Hz, of a mode of the usual structure
# The exact solver returns to a state within rounding.  A fixed step detects an event up to a step late, while
# a state moves by 2 pi f h of its size, 2.5 %: at both crossings, and at an event or more before each.
RETURN_TOLERANCES = {"exact": 1e-6, "paper": round(4 * 2 * pi * HIGHEST_FREQUENCY * PAPER_STEP, 3)}

Array = NDArray[Any]
USUAL = SliderOnBelt()
STIFF = SliderOnBelt(F=800.0, k_nl=1e7, k4=5e6, k5=5e6, k6=5e6)  # Figs 16 to 18
CONTACT_STIFFNESSES = (0.0, 1e4, 1e7)  # k_nl in N/m^3
MU_K_NAMED_IN_TEXT = (0.05, 0.75)  # further mu_k that the text on Fig. 11 names
MU_K_SMALL = (0.01, 0.02, 0.03, 0.04, 0.05, 0.38)  # and without GN: "very small", and where Fig. 13 begins


MU_K_AT_ONSET = (1.35, 1.4)  # and sliding only, where Fig. 17b begins


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
        return TAYLOR if self.algorithm == "exact" else RK4(step=PAPER_STEP)

    @property
    def tolerance(self) -> float:
        """To which share of its size a motion has to return to count as periodic."""
        return RETURN_TOLERANCES[self.algorithm]

    def adapt_model(self, model: Any) -> Any:
        """The model with the impact law asked for; without GN both laws are the same."""
        if self.impact == "paper" or "phi" not in model.coordinates:
            return model
        return model.replace(impact=PlasticImpact(penetration_rate="full"))

    def with_solver(self, algorithm: str, impact: str) -> Setting:
        """The setting with another algorithm and impact law."""
        return replace(self, algorithm=algorithm, impact=impact)

    @property
    def solver(self) -> str:
        """The algorithm in words."""
        return "exact solver" if self.algorithm == "exact" else f"paper's algorithm, step {PAPER_STEP:g} s"

    def __str__(self) -> str:
        return f"{self.solver}, {'Eq. (13)' if self.impact == 'paper' else 'full gap rate'}"


class Times(NamedTuple):
    """Seconds of transient, and of the window that is classified."""

    transient: float
    window: float


USUAL_TIMES = Times(300.0, 100.0)  # by Eq. (13) the belt's rotation takes 200 s to settle
FIXED_STEP_TIMES = Times(300.0, 60.0)
STIFF_TIMES = Times(150.0, 50.0)  # at 30 Hz; sliding only it settles as slowly as the usual one


def times_of(model: Any, setting: Setting) -> Times:
    """The times for a model, by the cost of its motion and by how slowly it settles."""
    if setting.algorithm == "paper":
        return FIXED_STEP_TIMES
    smooth = "separation" not in model.interface.modes
    return STIFF_TIMES if model.k4 == STIFF.k4 and not smooth else USUAL_TIMES


def mu_k(setting: Setting) -> Array:
    """0.05, 0.1, ... 3: Figs 9 and 10."""
    return _sorted_grid(np.arange(1, 61)[_grid_slice(setting)] * 0.05)


def mu_k_coarse(setting: Setting, *further: float) -> Array:
    """0.1, 0.2, ... 3 and the further values that a text names: where there are many sweeps."""
    return _sorted_grid(np.append(np.arange(1, 31)[_grid_slice(setting)] * 0.1, further))


def mu_k_near(setting: Setting) -> Array:
    """0.2, 0.4, ... 3, for the start near the equilibrium: eigenvalues say exactly where it is stable."""
    return mu_k(setting)[1::2] if setting.quick else mu_k(setting)[3::4]


def mu_k_stiff(setting: Setting) -> Array:
    """0.1, 0.2, ... 3, and closer together at the lower end."""
    return _sorted_grid(np.append(np.arange(1, 31)[_grid_slice(setting)] * 0.1, (0.05, 0.1, 0.15)))


def mu_k_sliding(setting: Setting) -> Array:
    """Of the stiff structure, sliding only: as fine as for Fig. 9."""
    return np.union1d(mu_k(setting), MU_K_AT_ONSET)


def preloads(setting: Setting) -> Array:
    """F in N: 50, 100, ... 1000."""
    return _sorted_grid(np.arange(1, 21)[_grid_slice(setting)] * 50.0)


def _grid_slice(setting: Setting) -> slice:
    return slice(3, None, 4) if setting.quick else slice(None)


def _sorted_grid(values: Array) -> Array:
    """Ascending, each once, without the rounding of steps."""
    return np.unique(np.round(values, 10))
