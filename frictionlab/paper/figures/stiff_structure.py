"""Figs 16 to 18, on a stiffer structure: the non-smooth behaviours, and response frequencies.

Figs 16 and 17: with and without stick and separation.  Fig. 18: frequencies of steady motions against
the unstable eigenfrequencies of the linearised system.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from frictionlab.analysis.options import SteadyStateKeywords
from frictionlab.analysis.steady_state.steady_state import SteadyState
from frictionlab.paper import scenes
from frictionlab.paper.results import PaperFigure
from frictionlab.paper.scenes import Setting, intervals_text
from frictionlab.plotting import RunFigure, plot_bifurcation, plot_cea_against_motion, plot_intensity
from frictionlab.plotting.appearance import BLUE, DASHED, VERMILLION
from frictionlab.plotting.figure import new_figure
from frictionlab.plotting.labels import state_label
from frictionlab.presentation import state_unit
from frictionlab.stability import critical_value

if TYPE_CHECKING:
    from frictionlab.analysis.sweeps.cea_against_motion import CEAAgainstMotion
    from frictionlab.hybrid.trajectory import Trajectory

MU_K = 2.5  # of Fig. 16
COMPARISON_SHOWN = 0.4  # seconds
SAMPLES = 4001
WITH_NONSMOOTH, SLIDING_ONLY = "with the non-smooth behaviours", "sliding only"
VARIANT_NAMES = {True: WITH_NONSMOOTH, False: SLIDING_ONLY}
VARIANT_STYLES = {WITH_NONSMOOTH: {"color": BLUE}, SLIDING_ONLY: {"color": VERMILLION, "linestyle": DASHED}}

Array = NDArray[np.float64]
F_MAX = 60.0
# Panel -> nonlinearities left out.
PANELS_WITHOUT = {
    "all three": (),
    "contact stiffness only": ("nonsmooth", "geometry"),
    "geometry only": ("cubic", "nonsmooth"),
    "non-smooth only": ("cubic", "geometry"),
}
UNBOUNDED_PANEL = "geometry only"  # its motion grows without bound, so the number of steps is limited
MAX_STEPS = 300_000


@dataclass(frozen=True, eq=False)
class NonsmoothComparison:
    """What Fig. 16 shows: steady states, by name."""

    steady_states: dict[str, SteadyState]


@dataclass(frozen=True, eq=False)
class NonsmoothSweeps:
    """What Fig. 17 shows: sweeps over mu_k from rest, by name, and where the equilibrium loses stability."""

    sweeps: dict[str, Any]
    critical: float


def nonsmooth_figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 16 or 17."""
    return _comparison_figure(setting) if number == 16 else _sweep_figure(setting)


def _comparison_figure(setting: Setting) -> PaperFigure:
    data = NonsmoothComparison(steady_states_compared(setting))
    caption = "steady states from rest at mu_k = 2.5"
    summary = (
        f"{name}: {steady.kind}, {_ranges_text(steady)}" for name, steady in data.steady_states.items()
    )
    return PaperFigure(16, caption, data, tuple(summary), _draw_comparison, str(setting))


def steady_states_compared(setting: Setting) -> dict[str, SteadyState]:
    """The steady states at mu_k = 2.5, with and without the non-smooth behaviours."""
    models = {
        name: scenes.stiff_model(nonsmooth).replace(mu_k=MU_K) for nonsmooth, name in VARIANT_NAMES.items()
    }
    return {name: scenes.steady_state_of(model, setting, section=None) for name, model in models.items()}


def samples(steady: SteadyState, name: str, seconds: float | None = None) -> tuple[Any, Any]:
    """Times and values of a state or of the normal force over the last `seconds`, or the whole window."""
    run = steady.trajectory
    length = run.raw.t if seconds is None else min(seconds, run.raw.t)
    count = SAMPLES if seconds is not None else 40 * SAMPLES
    t = np.clip(np.linspace(run.raw.t - length, run.raw.t, count), 0.0, run.raw.t)
    return t, contact_force(run, t) if name == "normal_force" else run(t)[:, run.names.index(name)]


def contact_force(run: Trajectory, t: Any) -> Any:
    """F_N without impulses, as in the paper: zero in chatter, where F_T = 0 and F_N is their mean."""
    return np.where(run.output("friction_force", t) == 0.0, 0.0, run.output("normal_force", t))


def ranges(steady: SteadyState) -> dict[str, float]:
    """Largest less smallest value over the window."""
    return {name: float(np.ptp(samples(steady, name)[1])) for name in ("x1", "y1", "normal_force")}


def _ranges_text(steady: SteadyState) -> str:
    x1, y1, force = ranges(steady).values()
    return f"range of x1 {x1:.4g} m, of y1 {y1:.4g} m, of F_N {force:.4g} N"


def _sweep_figure(setting: Setting) -> PaperFigure:
    data = NonsmoothSweeps(
        {name: scenes.stiff_sweep(n, setting) for n, name in VARIANT_NAMES.items()}, critical_mu_k()
    )
    summary = [f"{name}: {intervals_text(sweep)}" for name, sweep in data.sweeps.items()]
    summary.append(f"the equilibrium loses stability at mu_k {data.critical:.4f}")
    return PaperFigure(
        17, "steady states from rest against mu_k", data, tuple(summary), _draw_sweeps, str(setting)
    )


@cache
def critical_mu_k() -> float:
    """Where the equilibrium loses stability; the non-smooth behaviours do not change it."""
    value = critical_value(scenes.STIFF, "mu_k", (0.0, 3.0))
    return np.nan if value is None else float(value)


def _draw_comparison(result: PaperFigure) -> RunFigure:
    picture = new_figure(8.5, 8.0)
    panels = picture.subplots(3, 1, sharex=True)
    for name, steady in result.data.steady_states.items():
        for ax, state in zip(panels, ("x1", "y1", "normal_force")):
            t, values = samples(steady, state, COMPARISON_SHOWN)
            ax.plot(t - t[0], values, label=name, linewidth=1.2, **VARIANT_STYLES[name])
    for ax, state, letter in zip(panels, ("x1", "y1"), "ab"):
        ax.set(ylabel=f"{state_label(state)} ({state_unit(state)})", title=f"({letter})")
    panels[2].set(xlabel="time (s)", ylabel="$F_N$ (N)", title="(c)")
    for ax in panels:
        ax.margins(x=0)
    picture.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    picture.suptitle(result.heading(f"steady states from rest, $\\mu_k$ = {MU_K:g}"))
    return picture


def _legend_below(ax: Axes, handles: list[Any]) -> None:
    place = {"loc": "upper left", "bbox_to_anchor": (0.0, -0.16)}
    ax.legend(handles=handles, ncols=2, fontsize=9.0, frameon=False, **place)


def _draw_sweeps(result: PaperFigure) -> RunFigure:
    data = result.data
    picture = new_figure(13.2, 4.4)
    panels = picture.subplots(1, 3)
    for ax, (name, sweep), letter in zip(panels, data.sweeps.items(), "ab"):
        plot_bifurcation(sweep, ax, legend=False)
        ax.set_title(f"({letter}) {name}")
    handles = {h.get_label(): h for ax in panels[:2] for h in ax.get_legend_handles_labels()[0]}
    _legend_below(panels[0], list(handles.values()))
    plot_intensity(list(data.sweeps.values()), panels[2], labels=list(data.sweeps), legend=False)
    panels[2].axvline(data.critical, color="0.5", linewidth=1.0, linestyle=":", label="equilibrium unstable")
    _legend_below(panels[2], panels[2].get_legend_handles_labels()[0])
    panels[2].set_title("(c) intensity")
    picture.suptitle(result.heading("from rest, with and without the non-smooth behaviours"))
    return picture


@dataclass(frozen=True, eq=False)
class ResponseFrequencies:
    """What Fig. 18 shows: panels by the nonlinearities that are left in."""

    panels: dict[str, CEAAgainstMotion]


def frequency_figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 18."""
    data = ResponseFrequencies({name: frequency_panel(name, setting) for name in PANELS_WITHOUT})
    summary = tuple(f"{name}: {deviation_text(each)}" for name, each in data.panels.items())
    return PaperFigure(number, "spectra of x1 against mu_k", data, summary, _draw_frequencies, str(setting))


def frequency_panel(name: str, setting: Setting) -> CEAAgainstMotion:
    """One of the four panels of Fig. 18: steady states from rest."""
    model = scenes.STIFF.without(*PANELS_WITHOUT[name])
    method = setting.method
    if name == UNBOUNDED_PANEL:
        method = replace(method, max_steps=MAX_STEPS)
    times = scenes.times_of(model, setting)._asdict()
    options = SteadyStateKeywords(method=method, tolerance=setting.tolerance, **times)
    return scenes.cea_and_motions(model, scenes.mu_k_stiff(setting), options, F_MAX, setting)


def deviation_text(each: CEAAgainstMotion) -> str:
    """How far the strongest line is from the eigenvalue that grows fastest."""
    deviations = each.deviations
    if not len(deviations):
        return "no motion where an eigenvalue grows"
    median, values = 100 * np.median(deviations), len(deviations)
    return (
        f"strongest line {np.nanmin(each.dominant):.2f} to {np.nanmax(each.dominant):.2f} Hz, "
        f"off the unstable eigenfrequency by {median:.1f} % (median, {values} values), "
        f"{100 * deviations.max():.1f} % at most"
    )


def _draw_frequencies(result: PaperFigure) -> RunFigure:
    picture = new_figure(11.0, 8.0)
    axes = picture.subplots(2, 2, sharex=True, sharey=True)
    for ax, (name, each), letter in zip(axes.flat, result.data.panels.items(), "abcd"):
        plot_cea_against_motion(each, ax, legend=False)
        ax.set_title(f"({letter}) {name}")
    for ax in axes.flat:
        ax.label_outer()
    picture.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", frameon=False)
    picture.suptitle(result.heading("spectra of $x_1$ in steady states from rest"))
    return picture
