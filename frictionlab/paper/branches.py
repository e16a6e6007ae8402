"""Figs 9 to 14: steady states against mu_k for three contacts, with and without GN.

GN is the geometrical nonlinearity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from frictionlab.analysis.steady_state import SteadyState
from frictionlab.plotting import RunFigure, plot_bifurcation, plot_intensity, plot_phase_plane
from frictionlab.plotting.legends import legend_beside
from frictionlab.plotting.parameters import parameter_value

from . import motions, scenes
from .result import PaperFigure
from .setting import Setting
from .wording import moving, stretches

SECTIONS = {9: (1e4,), 11: (0.0, 1e7), 13: scenes.SOFT_AND_HARD}  # k_nl of each
INTENSITIES = {10: (1e4,), 12: scenes.SOFT_AND_HARD, 14: scenes.SOFT_AND_HARD}
WITHOUT = (13, 14)  # GN
PLANES = 2.0  # mu_k of Figs 13d to f
SHOWN = 0.3  # seconds of them


@dataclass(frozen=True, eq=False)
class Branches:
    """What Figs 9 to 14 show.

    Parameters
    ----------
    sweeps : dict of (float, str) to Bifurcation
        By k_nl (N/m^3) and start ("rest", "near").
    cycles : dict of float to SteadyState
        At mu_k = 2, by k_nl; of Fig. 13 only.
    """

    sweeps: dict[tuple[float, str], Any]
    cycles: dict[float, SteadyState]


def figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 9, 10, 11, 12, 13 or 14."""
    geometry = number not in WITHOUT
    stiffnesses = {**SECTIONS, **INTENSITIES}[number]
    sweeps = {(k, "rest"): motions.from_rest(k, setting, geometry) for k in stiffnesses}
    if number in INTENSITIES:
        sweeps |= {(k, "near"): motions.from_near(k, setting, geometry) for k in stiffnesses}
    cycles = {k: cycle(k, setting) for k in stiffnesses} if number == 13 else {}
    what = "x1 at the onset of stick" if number in SECTIONS else "intensity L_s"
    caption = f"{what} against mu_k, {motions.GN[geometry]}"
    summary = [f"k_nl = {k:g} N/m^3, from {start}: {_in_words(b)}" for (k, start), b in sweeps.items()]
    draw = _draw_sections if number in SECTIONS else _draw_intensities
    how = str(setting) if geometry else setting.solver  # without GN both impact laws are the same
    return PaperFigure(number, caption, Branches(sweeps, cycles), tuple(summary), draw, how)


def cycle(k_nl: float, setting: Setting) -> SteadyState:
    """The motion of Figs 13d to f."""
    return motions.single(motions.contact(k_nl, geometry=False).replace(mu_k=PLANES), setting)


def _in_words(found: Any) -> str:
    strong = found.intensities[moving(found)]
    size = f"; L_s {np.nanmin(strong):.5g} to {np.nanmax(strong):.5g}" if len(strong) else ""
    return f"{stretches(found)}{size}"


def _draw_sections(result: PaperFigure) -> RunFigure:
    sweeps, cycles = result.data.sweeps, result.data.cycles
    rows, columns = (2, len(cycles)) if cycles else (1, len(sweeps))
    picture = RunFigure(figsize=(max(7.5, 4.4 * columns), 4.2 * rows), layout="constrained")
    panels = picture.subplots(rows, columns, squeeze=False)
    for i, ((k_nl, _), found) in enumerate(sweeps.items()):
        ax = panels[0, i]
        plot_bifurcation(found, ax, legend=False)
        ax.set_title(_title("abc"[i], found.model, k_nl, columns))
    for i, (k_nl, found) in enumerate(cycles.items()):
        plot_phase_plane(found.trajectory, panels[1, i], window=SHOWN)
        panels[1, i].set_title(_title("def"[i], found.model, k_nl, columns))
    _legends(panels)
    gn = "without" if cycles else "with"
    planes = f", and phase planes at $\\mu_k$ = {PLANES:g}" if cycles else ""
    picture.suptitle(result.heading(f"from rest, {gn} the geometrical nonlinearity{planes}"))
    return picture


def _title(letter: str, model: Any, k_nl: float, columns: int) -> str:
    value = parameter_value(model, "k_nl", k_nl)
    return f"({letter}) {value}" if columns > 1 else value


def _legends(panels: Any) -> None:
    """One for each row, of all that occurs in it."""
    for row in panels:
        handles = {h.get_label(): h for ax in row for h in ax.get_legend_handles_labels()[0]}
        legend_beside(row[-1], list(handles.values()))


def _draw_intensities(result: PaperFigure) -> RunFigure:
    sweeps = result.data.sweeps
    stiffnesses = list(dict.fromkeys(k for k, _ in sweeps))
    picture = RunFigure(figsize=(max(7.5, 4.4 * len(stiffnesses)), 4.2), layout="constrained")
    panels = picture.subplots(1, len(stiffnesses), squeeze=False)
    for i, k_nl in enumerate(stiffnesses):
        _draw_intensity([sweeps[k_nl, start] for start in ("rest", "near")], panels[0, i])
        title = _title("abc"[i], sweeps[k_nl, "rest"].model, k_nl, len(stiffnesses))
        panels[0, i].set_title(title)
    legend_beside(panels[0, -1])
    gn = "without" if result.number in WITHOUT else "with"
    picture.suptitle(result.heading(f"{gn} the geometrical nonlinearity; hollow: at rest"))
    return picture


def _draw_intensity(found: list[Any], ax: Axes) -> None:
    plot_intensity(found, ax, legend=False)
