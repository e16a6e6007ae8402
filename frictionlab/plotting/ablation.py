"""Small multiples of an ablation: the result of a study for each scene."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Real
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from frictionlab.analysis.spectrum import Spectrum
from frictionlab.analysis.steady_state.motion_kind import MotionKind
from frictionlab.analysis.steady_state.result import SteadyState
from frictionlab.analysis.sweeps.ablation import all_of
from frictionlab.analysis.sweeps.bifurcation import Bifurcation
from frictionlab.plotting.runs.phase_plane import plot_phase_plane
from frictionlab.plotting.runs.spectrum import DECADES

from .bifurcation import LOG_SCALE_RATIO, plot_bifurcation
from .figure import RunFigure, axes_or_new
from .style import BLACK, BLUE, GREY, state_label, state_unit

SHOWN_PERIODS = 3  # periods drawn of a periodic motion
SHOWN_SECONDS = 2.0  # drawn of others
COLUMNS = 4  # panels side by side


def plot_ablation(ablation: Any, *, name: str = "x1") -> list[Axes]:
    """Draw what a study gave for each scene: a small panel for each, or bars of numbers.

    Parameters
    ----------
    ablation : Ablation
        With results that are SteadyState (drawn as phase planes), Bifurcation (section points), Spectrum,
        or numbers (None: no such number).
    name : str
        The coordinate to draw.

    Returns
    -------
    list of Axes
        Of a new figure, ``axes[0].figure``: one for each scene, of its own scale, or one of bars.

    Raises
    ------
    TypeError
        For results that are none of these.
    """
    known = [result for result in ablation.results if result is not None]
    if all(isinstance(result, Real) for result in known):
        return [_bars(ablation)]
    draw = _panel_for(known)
    count = len(ablation.results)
    columns = min(COLUMNS, count)
    rows = -(-count // columns)
    figure = RunFigure(figsize=(3.25 * columns, 3.0 * rows), layout="constrained")
    panels = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for ax, (without, result) in zip(panels, ablation, strict=True):
        if result is None:
            ax.text(0.5, 0.5, "not done", ha="center", va="center", transform=ax.transAxes)
        else:
            draw(result, ax, name)
        ax.set_title(_scene_title(without, ablation.switches) + _motion_title(result), fontsize=9.0)
    _share_labels(figure, panels)
    return panels


def _panel_for(results: Iterable[Any]) -> Any:
    kinds = {type(result) for result in results}
    panels = {SteadyState: _phase_plane, Bifurcation: _points, Spectrum: _spectrum}
    if len(kinds) != 1 or not kinds <= panels.keys():
        got = ", ".join(sorted(kind.__name__ for kind in kinds))
        raise TypeError(
            f"results must all be SteadyState, Bifurcation, Spectrum or numbers, got {got}: let the study "
            "return one of these"
        )
    return panels[kinds.pop()]


def _share_labels(figure: RunFigure, panels: list[Axes]) -> None:
    """Labels at the outer panels only, and one legend for all."""
    for i, ax in enumerate(panels):
        ax.tick_params(labelsize=8.0)
        ax.locator_params(axis="x", nbins=4)
        if i < len(panels) - COLUMNS:
            ax.set_xlabel("")
        if i % COLUMNS:
            ax.set_ylabel("")
    handles = {str(text): h for ax in panels for h, text in zip(*ax.get_legend_handles_labels())}
    if handles:
        figure.legend(handles=list(handles.values()), loc="outside right center", frameon=False)


def _phase_plane(result: Any, ax: Axes, name: str) -> None:
    run = result.trajectory
    if result.kind == MotionKind.EQUILIBRIUM:
        column = run.names.index(name)
        x, rate = run.final_state[[column, column + run.automaton.coordinates]]
        ax.plot(x, rate, "+", color=BLACK, markersize=9.0, label="equilibrium")
        ax.set(ylim=(-1.0, 1.0))
    else:
        seconds = SHOWN_PERIODS * result.period if result.kind == MotionKind.PERIODIC else SHOWN_SECONDS
        plot_phase_plane(run, ax, name=name, window=min(seconds, float(run.raw.t)))
    ax.set(xlabel=_state_axis_label(name), ylabel=_state_axis_label(f"{name}'"))


def _points(result: Any, ax: Axes, name: str) -> None:
    plot_bifurcation(result, ax, name=name, legend=False)


def _spectrum(result: Any, ax: Axes, name: str) -> None:
    ax.semilogy(result.frequencies, result.amplitudes, color=BLACK, linewidth=0.8)
    top = float(result.amplitudes.max())
    ax.set(xlim=(0.0, result.frequencies[-1]), ylim=(top * 10.0**-DECADES, 2 * top) if top > 0 else None)
    ax.set(xlabel="frequency (Hz)", ylabel=f"amplitude of {_state_axis_label(name)}")


def _state_axis_label(name: str) -> str:
    return f"{state_label(name)} ({state_unit(name)})"


def _scene_title(without: tuple[str, ...], switches: tuple[str, ...]) -> str:
    if not without:
        return all_of(len(switches)).replace("it", switches[0]) if switches else "all"
    left = [name for name in switches if name not in without]
    return f"only {left[0]}" if len(left) == 1 else f"without {', '.join(without)}" if left else "none"


def _motion_title(result: Any) -> str:
    kind = getattr(result, "kind", "")
    return f"\n{kind}" if isinstance(kind, str) and kind else ""


def _bars(ablation: Any) -> Axes:
    values = np.array([np.nan if result is None else result for _, result in ablation], dtype=float)
    ax = axes_or_new(None)
    bars = ax.barh(range(len(values)), np.nan_to_num(values), color=BLUE)
    ax.bar_label(bars, ["" if np.isnan(v) else f"{v:.5g}" for v in values], padding=4)
    for i in np.flatnonzero(np.isnan(values)):
        ax.text(0.01, float(i), "none", va="center", transform=ax.get_yaxis_transform())
    ax.set_yticks(range(len(values)), [_scene_title(without, ablation.switches) for without, _ in ablation])
    ax.invert_yaxis()
    known = values[~np.isnan(values)]
    if len(known) and known.min() > 0 and known.max() > LOG_SCALE_RATIO * known.min():
        ax.set_xscale("log")
    ax.axvline(0.0, color=GREY, linewidth=0.8)
    ax.margins(x=0.15)
    return ax
