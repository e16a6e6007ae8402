"""The step-size study as a picture and as a page."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionlab.plotting import RunFigure
from frictionlab.plotting.legends import legend_beside
from frictionlab.plotting.palette import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION
from frictionlab.plotting.parameters import parameter_label

from . import scenes
from .setting import IMPACTS, STEP
from .steps import Series, StepStudy
from .wording import AT_REST

PAGE = "step-size.md"
LAWS = {"paper": "Eq. (13) as printed", "full gap rate": "full gap rate in the impact law"}
COLOURS = (ORANGE, BLUE, GREEN, VERMILLION, PURPLE, SKY)
MARKERS = "^sDvPX"
EXAMPLE = 1.4

TEXT = """\
# What a fixed step does to a motion

Written by `frictionlab reproduce`. The same model, the same start (rest), two ways to solve it: the paper's
algorithm, which looks at the conditions of stick, slip and separation when a fixed step is over, at several
steps; and the exact solver, which locates every event.

![Intensity and strongest frequency against mu_k]({picture})

With Eq. (13) as printed (left) an impact leaves the slider with the rate (x1' - x2') phi away from the belt.
Where that is positive it flies again at once, in flights of microseconds and less, until they have come to
nothing. A fixed step sees a flight only where it lasts longer than the step; each step therefore solves
another problem, and no step that one would take is small enough. With the gap's full rate in the law
(right) there are no such flights, and the steps agree with the exact solver.

{errors}

At mu_k = {example:g}:

{table}

The paper prints its algorithm (its Fig. 19) but no step. At {step:g} s it gives a motion that repeats
at 1.58 Hz, as the paper reports (its strongest line is the seventh harmonic); neither a larger nor a smaller
step does, nor does locating the events. So a figure of a non-smooth system is to be trusted only where it
stays the same when the step is halved *and* where the impact law leaves nothing to land between two steps.
frictionlab locates every event to rounding, so that there is no step to choose: see
[tutorials/05-trust-your-solver.ipynb](../tutorials/05-trust-your-solver.ipynb).
"""


def draw(study: StepStudy) -> Figure:
    """L_s and the strongest frequency against mu_k, by impact law."""
    picture = RunFigure(figsize=(11.0, 7.0), layout="constrained")
    panels = picture.subplots(2, 2, sharex=True, sharey="row")
    for column, impact in zip(panels.T, IMPACTS):
        _column(study, impact, *column)
        column[0].set_title(LAWS[impact])
    panels[0, 0].set_ylabel(r"intensity $L_{\mathrm{s}}$ (m$^{2}$)")
    panels[1, 0].set_ylabel("strongest line of $x_1$ (Hz)")
    panels[1, 0].set_ylim(0.0, None)
    legend_beside(panels[0, 1])
    return picture


def _column(study: StepStudy, impact: str, above: Axes, below: Axes) -> None:
    *fixed, exact = study.of(impact)
    for series, colour, marker in zip(fixed, COLOURS, MARKERS):
        style = {"color": colour, "marker": marker, "linestyle": "none", "markersize": 5.0, "alpha": 0.9}
        _draw(study, series, above, below, style)
    _draw(study, exact, above, below, {"color": BLACK, "marker": ".", "linewidth": 1.0, "zorder": 1.5})
    above.set_yscale("log")
    below.set_xlabel(parameter_label(scenes.USUAL, "mu_k"))


def _draw(study: StepStudy, series: Series, above: Axes, below: Axes, style: dict[str, Any]) -> None:
    moving = np.array([kind != AT_REST for kind in series.kinds])
    above.plot(study.mu_k, np.where(moving, series.intensity, np.nan), label=series.label, **style)
    below.plot(study.mu_k, series.strongest, **style)


def page(study: StepStudy, picture: str) -> str:
    """The page, in Markdown."""
    return TEXT.format(
        picture=picture, errors=_errors(study), table=_table(study), example=EXAMPLE, step=STEP
    )


def _errors(study: StepStudy) -> str:
    """Relative errors of L_s, by step and impact law."""
    head = f"| step (s) | error of L_s, {LAWS['paper']}: median, largest | {LAWS['full gap rate']} |"
    printed, full = (study.errors(impact) for impact in IMPACTS)
    rows = [f"| {step:g} | {_spread(printed[step])} | {_spread(full[step])} |" for step in printed]
    return "\n".join([head, "|---|---|---|", *rows])


def _spread(errors: Any) -> str:
    return f"{np.median(errors):.2g}, {errors.max():.2g}"


def _table(study: StepStudy) -> str:
    i = int(np.argmin(np.abs(study.mu_k - EXAMPLE)))
    rows = [
        f"| {s.label} | {LAWS[s.impact]} | {s.kinds[i]} | {s.intensity[i]:.4g} | {s.strongest[i]:.2f} |"
        for s in study.series
    ]
    head = "| algorithm | impact law | motion | L_s (m^2) | strongest line (Hz) |\n|---|---|---|---|---|"
    return "\n".join([head, *rows])
