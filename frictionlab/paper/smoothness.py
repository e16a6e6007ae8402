"""Figs 16 and 17: with and without the non-smooth behaviours, on a stiffer structure."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from frictionlab.analysis.steady_state import SteadyState
from frictionlab.plotting import RunFigure, plot_bifurcation, plot_intensity
from frictionlab.plotting.palette import BLUE, DASHED, VERMILLION, label, unit
from frictionlab.stability import critical_value

from . import motions, scenes
from .result import PaperFigure
from .setting import Setting
from .wording import stretches

MU_K = 2.5  # of Fig. 16
SHOWN = 0.4  # seconds
SAMPLES = 4001
WITH, WITHOUT = "with the non-smooth behaviours", "sliding only"
NAMES = {True: WITH, False: WITHOUT}
STYLES = {WITH: {"color": BLUE}, WITHOUT: {"color": VERMILLION, "linestyle": DASHED}}


@dataclass(frozen=True, eq=False)
class Comparison:
    """What Fig. 16 shows: steady states, by name."""

    steady: dict[str, SteadyState]


@dataclass(frozen=True, eq=False)
class Smoothness:
    """What Fig. 17 shows: sweeps over mu_k from rest, by name, and where the equilibrium loses stability."""

    sweeps: dict[str, Any]
    critical: float


def figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 16 or 17."""
    return _comparison(setting) if number == 16 else _smoothness(setting)


def _comparison(setting: Setting) -> PaperFigure:
    data = Comparison(compared(setting))
    caption = "steady states from rest at mu_k = 2.5"
    summary = (f"{name}: {found.kind}, {_ranges(found)}" for name, found in data.steady.items())
    return PaperFigure(16, caption, data, tuple(summary), _draw_comparison, str(setting))


def compared(setting: Setting) -> dict[str, SteadyState]:
    """Both steady states at mu_k = 2.5."""
    models = {name: motions.stiff(nonsmooth).replace(mu_k=MU_K) for nonsmooth, name in NAMES.items()}
    return {name: motions.single(model, setting, section=None) for name, model in models.items()}


def samples(found: SteadyState, name: str, seconds: float | None = None) -> tuple[Any, Any]:
    """Times and values of a state or of the normal force over the last seconds, or all of the window."""
    run = found.trajectory
    length = run.raw.t if seconds is None else min(seconds, run.raw.t)
    count = SAMPLES if seconds is not None else 40 * SAMPLES
    t = np.clip(np.linspace(run.raw.t - length, run.raw.t, count), 0.0, run.raw.t)
    return t, contact_force(run, t) if name == "normal_force" else run(t)[:, run.names.index(name)]


def contact_force(run: Any, t: Any) -> Any:
    """F_N without impulses, as in the paper, so without their mean in chatter, where F_T = 0."""
    return np.where(run.output("friction_force", t) == 0.0, 0.0, run.output("normal_force", t))


def ranges(found: SteadyState) -> dict[str, float]:
    """Largest less smallest value over the window."""
    return {name: float(np.ptp(samples(found, name)[1])) for name in ("x1", "y1", "normal_force")}


def _ranges(found: SteadyState) -> str:
    x1, y1, force = ranges(found).values()
    return f"range of x1 {x1:.4g} m, of y1 {y1:.4g} m, of F_N {force:.4g} N"


def _smoothness(setting: Setting) -> PaperFigure:
    data = Smoothness({name: motions.stiff_sweep(n, setting) for n, name in NAMES.items()}, critical())
    summary = [f"{name}: {stretches(found)}" for name, found in data.sweeps.items()]
    summary.append(f"the equilibrium loses stability at mu_k {data.critical:.4f}")
    return PaperFigure(17, "steady states from rest against mu_k", data, tuple(summary), _draw, str(setting))


@cache
def critical() -> float:
    """Where the equilibrium loses stability; the non-smooth behaviours do not change it."""
    value = critical_value(scenes.STIFF, "mu_k", (0.0, 3.0))
    return np.nan if value is None else float(value)


def _draw_comparison(result: PaperFigure) -> RunFigure:
    picture = RunFigure(figsize=(8.5, 8.0), layout="constrained")
    panels = picture.subplots(3, 1, sharex=True)
    for name, found in result.data.steady.items():
        for ax, state in zip(panels, ("x1", "y1", "normal_force")):
            t, values = samples(found, state, SHOWN)
            ax.plot(t - t[0], values, label=name, linewidth=1.2, **STYLES[name])
    for ax, state, letter in zip(panels, ("x1", "y1"), "ab"):
        ax.set(ylabel=f"{label(state)} ({unit(state)})", title=f"({letter})")
    panels[2].set(xlabel="time (s)", ylabel="$F_N$ (N)", title="(c)")
    for ax in panels:
        ax.margins(x=0)
    picture.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    picture.suptitle(result.heading(f"steady states from rest, $\\mu_k$ = {MU_K:g}"))
    return picture


def _legend_below(ax: Axes, handles: list[Any]) -> None:
    place = {"loc": "upper left", "bbox_to_anchor": (0.0, -0.16)}
    ax.legend(handles=handles, ncols=2, fontsize=9.0, frameon=False, **place)


def _draw(result: PaperFigure) -> RunFigure:
    data = result.data
    picture = RunFigure(figsize=(13.2, 4.4), layout="constrained")
    panels = picture.subplots(1, 3)
    for ax, (name, found), letter in zip(panels, data.sweeps.items(), "ab"):
        plot_bifurcation(found, ax, legend=False)
        ax.set_title(f"({letter}) {name}")
    handles = {h.get_label(): h for ax in panels[:2] for h in ax.get_legend_handles_labels()[0]}
    _legend_below(panels[0], list(handles.values()))
    plot_intensity(list(data.sweeps.values()), panels[2], labels=list(data.sweeps), legend=False)
    panels[2].axvline(data.critical, color="0.5", linewidth=1.0, linestyle=":", label="equilibrium unstable")
    _legend_below(panels[2], panels[2].get_legend_handles_labels()[0])
    panels[2].set_title("(c) intensity")
    picture.suptitle(result.heading("from rest, with and without the non-smooth behaviours"))
    return picture
