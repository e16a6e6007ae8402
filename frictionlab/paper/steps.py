"""What a fixed step does to a motion: conditions looked at when a step is over, against events located.

Erratum E5: with Eq. (13) as printed the slider leaves the belt again right after many impacts, in flights
shorter than any step.  A fixed step jumps over those that fit into it, so that each step has a motion of its
own.  With the gap's full rate in the impact law there are no such flights, and all steps agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.steady_state import steady_state
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.rk4 import RK4

from . import scenes
from .setting import IMPACTS, TOLERANCES, Setting
from .sweeps import results
from .wording import AT_REST

Array = NDArray[np.float64]
STEPS = (5e-4, 2e-4, 1e-4, 5e-5)  # s
MU_K: Array = np.round(np.arange(1, 16) * 0.2, 10).astype(np.float64)
QUICK = slice(0, None, 3)
STUDY_TIMES = scenes.Times(60.0, 30.0)


@dataclass(frozen=True, eq=False)
class Series:
    """Steady states from rest over mu_k by one algorithm.

    Parameters
    ----------
    step : float or None
        Of the paper's algorithm, s; None: every event located.
    impact : str
        "paper" (Eq. 13 as printed) or "full gap rate".
    kinds : tuple of str (N,)
    intensity : array (N,)
        L_s, Eq. (20).
    strongest : array (N,)
        Frequency of the strongest line of x1, Hz; NaN at rest.
    """

    step: float | None
    impact: str
    kinds: tuple[str, ...]
    intensity: Array
    strongest: Array

    @property
    def label(self) -> str:
        """For a legend."""
        return "every event located" if self.step is None else f"fixed step {self.step:g} s"


@dataclass(frozen=True, eq=False)
class StepStudy:
    """All series over the same mu_k (N,)."""

    mu_k: Array
    series: tuple[Series, ...]

    def of(self, impact: str) -> tuple[Series, ...]:
        """The series with one impact law, the exact one last."""
        return tuple(s for s in self.series if s.impact == impact)

    def plot(self) -> Any:
        """Draw both against mu_k, by impact law, into a new figure."""
        from .steps_page import draw

        return draw(self)

    def errors(self, impact: str) -> dict[float, Array]:
        """Step -> |L_s - exact|/exact (K,) where the exact solver finds a vibration."""
        *fixed, exact = self.of(impact)
        moving = np.array([kind != AT_REST for kind in exact.kinds]) & (exact.intensity > 0)
        off = {s.step: np.abs(s.intensity - exact.intensity)[moving] for s in fixed if s.step is not None}
        return {step: apart / exact.intensity[moving] for step, apart in off.items()}


def step_study(
    steps: Sequence[float] = STEPS,
    *,
    quick: bool = False,
    workers: int | None = None,
    progress: bool = True,
    resume: str | Path | None = None,
) -> StepStudy:
    """L_s and the strongest frequency from rest over mu_k: several fixed steps, and the exact solver.

    Parameters
    ----------
    steps : sequence of float
        Of the paper's algorithm, s.
    quick : bool
        A third of the values of mu_k.
    workers, progress, resume
        As :func:`frictionlab.paper.figure`.

    Returns
    -------
    StepStudy

    Raises
    ------
    ValueError
        For a step that is no positive number.
    """
    folder = None if resume is None else Path(resume)
    setting = Setting(quick=quick, workers=workers, progress=progress, resume=folder)
    return study_of(setting, tuple(RK4(step=step).step for step in steps))


def study_of(setting: Setting, steps: Sequence[float] = STEPS) -> StepStudy:
    """The same by a setting, whose algorithm and impact law do not matter."""
    values = MU_K[QUICK] if setting.quick else MU_K
    ways = [(step, impact) for impact in IMPACTS for step in (*steps, None)]
    return StepStudy(values, tuple(_series(step, impact, values, setting) for step, impact in ways))


def _series(step: float | None, impact: str, values: Array, setting: Setting) -> Series:
    chosen = replace(setting, algorithm="exact" if step is None else "paper", impact=impact)
    method = chosen.method if step is None else RK4(step=step)
    times = scenes.times_of(chosen.adapted(scenes.USUAL), chosen) if step is None else STUDY_TIMES
    study = partial(_motion, method=method, tolerance=TOLERANCES[chosen.algorithm], times=times)
    name = f"step study {method.describe()} {times}"
    rows = results(name, study, scenes.USUAL, {"mu_k": values}, chosen).results
    kinds = tuple(row["kind"] for row in rows)
    return Series(step, impact, kinds, _column(rows, "intensity"), _column(rows, "strongest"))


def _column(rows: Any, name: str) -> Array:
    return np.array([np.nan if row[name] is None else row[name] for row in rows], dtype=float)


def _motion(model: Any, method: Method, tolerance: float, times: scenes.Times) -> dict[str, Any]:
    found = steady_state(model, method=method, tolerance=tolerance, progress=False, **times._asdict())
    spectrum = None if found.kind == AT_REST else found.spectrum()
    strongest = None if spectrum is None else float(spectrum.peaks()[0][0])
    return {"kind": found.kind, "intensity": found.intensity, "strongest": strongest}
