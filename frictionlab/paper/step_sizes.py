"""What a fixed step does to a motion: conditions checked at the end of each step, against events located.

Erratum E5: with Eq. (13) as printed the slider leaves the belt again right after many impacts, in flights
shorter than any step.  A fixed step jumps over those that fit into it, so that each step size gives another
motion.  With the full gap rate in the impact law there are no such flights, and all steps agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import steady_state
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.plotting.appearance import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION, ink, legible
from frictionlab.plotting.figure import legend_beside, new_figure
from frictionlab.plotting.labels import parameter_label

from . import scenes
from .scenes import IMPACTS, RETURN_TOLERANCES, Setting, sweep_results

if TYPE_CHECKING:
    from frictionlab.models.library.sliders import SliderOnBelt

Array = NDArray[np.float64]
STUDY_STEPS = (5e-4, 2e-4, 1e-4, 5e-5)  # s
MU_K: Array = np.round(np.arange(1, 16) * 0.2, 10).astype(np.float64)
QUICK_SLICE = slice(0, None, 3)
STUDY_TIMES = scenes.Times(60.0, 30.0)

IMPACT_LAW_NAMES = {"paper": "Eq. (13) as printed", "full gap rate": "full gap rate in the impact law"}
STEP_COLOURS = (ORANGE, BLUE, GREEN, VERMILLION, PURPLE, SKY)
STEP_MARKERS = "^sDvPX"


@dataclass(frozen=True, eq=False)
class StepSeries:
    """Steady states from rest over mu_k by one algorithm.

    Parameters
    ----------
    step : float or None
        Of the paper's algorithm, s; None where every event is located.
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
    series: tuple[StepSeries, ...]

    def of(self, impact: str) -> tuple[StepSeries, ...]:
        """The series with one impact law, the exact one last."""
        return tuple(s for s in self.series if s.impact == impact)

    def plot(self) -> Any:
        """Draw L_s and the strongest frequency against mu_k, by impact law, into a new figure."""

        return draw_step_study(self)

    def errors(self, impact: str) -> dict[float, Array]:
        """Step -> |L_s - exact|/exact (K,) where the exact solver finds a vibration."""
        *fixed, exact = self.of(impact)
        moving = np.array([kind != MotionKind.EQUILIBRIUM for kind in exact.kinds]) & (exact.intensity > 0)
        off = {s.step: np.abs(s.intensity - exact.intensity)[moving] for s in fixed if s.step is not None}
        return {step: deviation / exact.intensity[moving] for step, deviation in off.items()}


def step_study(setting: Setting, steps: Sequence[float] = STUDY_STEPS) -> StepStudy:
    """L_s and the strongest frequency from rest over mu_k: several fixed steps (s), and the exact solver.

    Of the setting the algorithm and the impact law are not used.
    """
    values = MU_K[QUICK_SLICE] if setting.quick else MU_K
    ways = [(step, impact) for impact in IMPACTS for step in (*steps, None)]
    return StepStudy(values, tuple(_series(step, impact, values, setting) for step, impact in ways))


def _series(step: float | None, impact: str, values: Array, setting: Setting) -> StepSeries:
    own = replace(setting, algorithm="exact" if step is None else "paper", impact=impact)
    method = own.method if step is None else RK4(step=step)
    times = scenes.times_of(own.adapt_model(scenes.USUAL), own) if step is None else STUDY_TIMES
    study = partial(_steady_motion, method=method, tolerance=RETURN_TOLERANCES[own.algorithm], times=times)
    name = f"step study {method.describe()} {times}"
    rows = sweep_results(name, study, scenes.USUAL, {"mu_k": values}, own).results
    kinds = tuple(row["kind"] for row in rows)
    return StepSeries(step, impact, kinds, _values_of(rows, "intensity"), _values_of(rows, "strongest"))


def _values_of(rows: Any, name: str) -> Array:
    return np.array([np.nan if row[name] is None else row[name] for row in rows], dtype=float)


def _steady_motion(
    model: SliderOnBelt, method: Method, tolerance: float, times: scenes.Times
) -> dict[str, Any]:
    steady = steady_state(model, method=method, tolerance=tolerance, progress=False, **times._asdict())
    spectrum = None if steady.kind == MotionKind.EQUILIBRIUM else steady.spectrum()
    strongest = None if spectrum is None else float(spectrum.peaks()[0][0])
    return {"kind": steady.kind, "intensity": steady.intensity, "strongest": strongest}


def draw_step_study(study: StepStudy) -> Figure:
    """L_s and the strongest frequency against mu_k, by impact law."""
    picture = new_figure(11.0, 7.0)
    panels = picture.subplots(2, 2, sharex=True, sharey="row")
    for column, impact in zip(panels.T, IMPACTS):
        _draw_impact_law(study, impact, *column)
        column[0].set_title(IMPACT_LAW_NAMES[impact])
    panels[0, 0].set_ylabel(r"intensity $L_{\mathrm{s}}$ (m$^{2}$)")
    panels[1, 0].set_ylabel("strongest line of $x_1$ (Hz)")
    panels[1, 0].set_ylim(0.0, None)
    legend_beside(panels[0, 1])
    return picture


def _draw_impact_law(study: StepStudy, impact: str, above: Axes, below: Axes) -> None:
    *fixed, exact = study.of(impact)
    for series, colour, marker in zip(fixed, STEP_COLOURS, STEP_MARKERS):
        style = {
            "color": legible(colour, above),
            "marker": marker,
            "linestyle": "none",
            "markersize": 5.0,
            "alpha": 0.9,
        }
        _draw_series(study, series, above, below, style)
    _draw_series(
        study, exact, above, below, {"color": ink(above), "marker": ".", "linewidth": 1.0, "zorder": 1.5}
    )
    above.set_yscale("log")
    below.set_xlabel(parameter_label(scenes.USUAL, "mu_k"))


def _draw_series(
    study: StepStudy, series: StepSeries, above: Axes, below: Axes, style: dict[str, Any]
) -> None:
    moving = np.array([kind != MotionKind.EQUILIBRIUM for kind in series.kinds])
    above.plot(study.mu_k, np.where(moving, series.intensity, np.nan), label=series.label, **style)
    below.plot(study.mu_k, series.strongest, **style)
