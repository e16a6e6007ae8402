"""Figs 2 to 6: two modes couple as mu_k grows; critical mu_k against the preload; two unstable pairs.

Figs 2 and 3: frequencies and growth rates for three contacts.  The text gives neither the values of k_nl
nor the range of mu_k: k_nl is that of Figs 9 to 14, and mu_k ends at mu_s = 3.  Frequencies are in Hz, as
those of Fig. 8.

Figs 4 and 5: the critical mu_k for three contacts, and with and without the geometrical nonlinearity
(GN).  The text gives neither the range of F nor, for Fig. 5, k_nl: the preload goes up to that of Fig. 3,
and k_nl is the 1e4 N/m^3 that the paper takes unless it says otherwise.

Fig. 6: with GN two pairs of modes are unstable, without it only one; k_nl and the range of mu_k as for
Fig. 5.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from frictionlab.models import SliderOnBelt
from frictionlab.paper.results import PaperFigure
from frictionlab.plotting import RunFigure, plot_critical, plot_frequencies, plot_growth_rates
from frictionlab.plotting.appearance import BLACK, BLUE, DASHED, VERMILLION, ink, legible
from frictionlab.plotting.figure import legend_beside, new_figure
from frictionlab.plotting.labels import parameter_symbol, parameter_value_text
from frictionlab.plotting.root_locus import growing_legend_handle
from frictionlab.stability import (
    CriticalCurve,
    RootLocus,
    StabilityChange,
    root_locus,
    stability_changes,
)
from frictionlab.stability.boundaries.stability_changes import curve_and_gaps

COALESCENCE_PRELOADS = {2: 100.0, 3: 1000.0}
STIFFNESSES = (0.0, 1e4, 1e7)
MU_K = (0.0, 3.0)
LOCUS_POINTS = 601
# Dashed over solid: where two curves coincide both are seen.
STIFFNESS_STYLES = dict(zip(STIFFNESSES, ((BLACK, "-"), (VERMILLION, DASHED), (BLUE, "-"))))

# N: closer together where the curves bend, and the paper's usual 200 N.
PRELOAD_GRID = np.sort(np.append(1000.0 * np.linspace(0.0, 1.0, 61)[1:] ** 2, 200.0))
MAX_CHANGE = 0.15  # between neighbours: a curve that changes by more is computed between them too
MAX_REFINEMENTS = 5
WITH_GEOMETRY, WITHOUT_GEOMETRY = "with GN", "without GN"

TWO_PAIRS_MODEL = SliderOnBelt(F=1000.0, l1=0.1, l2=0.3)
TWO_PAIRS_PANELS = ("(a) frequencies", "(b) growth rates", "(c) frequencies", "(d) growth rates")


def growing_modes(locus: RootLocus) -> list[int]:
    """The modes that grow somewhere, the fastest first."""
    fastest = np.nanmax(locus.growth_rates, axis=0)
    return [int(mode) for mode in np.argsort(-fastest) if fastest[mode] > 0]


def coupled_pair(locus: RootLocus, mode: int) -> tuple[int, int]:
    """A growing mode and the one nearest in frequency where it grows fastest, by ascending index."""
    row = locus.frequencies[np.nanargmax(locus.growth_rates[:, mode])]
    distances = np.abs(row - row[mode])
    distances[mode] = np.inf
    first, second = sorted((mode, int(np.argmin(distances))))
    return first, second


def stability_changes_text(changes: Iterable[StabilityChange]) -> str:
    """ "0 -> 1 at mu_k 1.5138 (15.61 Hz)" and so on: how the number of growing pairs changes with mu_k."""
    steps = [
        f"{c.unstable[0]} -> {c.unstable[1]} at {c.value:.4f} ({c.frequency:.2f} Hz)" for c in changes
    ] or ["no change"]
    return ", ".join(steps).replace(" at ", " at mu_k ", 1)


@dataclass(frozen=True, eq=False)
class Coalescence:
    """What Figs 2 and 3 show; the dictionaries go by k_nl (N/m^3).

    Parameters
    ----------
    preload : float
        F, N.
    loci : dict of RootLocus
        All modes against mu_k.
    pairs : dict of (int, int)
        The columns of the two modes that couple: the one that grows fastest, and its partner.
    changes : dict of tuple of StabilityChange
        All changes of stability, of any mode.
    """

    preload: float
    loci: dict[float, RootLocus]
    pairs: dict[float, tuple[int, int]]
    changes: dict[float, tuple[StabilityChange, ...]]


def coalescence_figure(number: int) -> PaperFigure:
    """Fig. 2 (F = 100 N) or 3 (F = 1000 N)."""
    data = coalescence(COALESCENCE_PRELOADS[number])
    caption = f"eigenvalues of the two modes that couple, F = {data.preload:g} N"
    summary = (
        f"k_nl = {k:g} N/m^3: {stability_changes_text(changes)}" for k, changes in data.changes.items()
    )
    return PaperFigure(number, caption, data, tuple(summary), _draw_coalescence)


def coalescence(preload: float) -> Coalescence:
    """Root loci and changes of stability for the three values of k_nl."""
    models = {k: SliderOnBelt(F=preload, k_nl=k) for k in STIFFNESSES}
    loci = {k: root_locus(model, "mu_k", np.linspace(*MU_K, LOCUS_POINTS)) for k, model in models.items()}
    pairs = {k: coupled_pair(locus, growing_modes(locus)[0]) for k, locus in loci.items()}
    return Coalescence(
        preload, loci, pairs, {k: stability_changes(m, "mu_k", MU_K) for k, m in models.items()}
    )


def _draw_coalescence(result: PaperFigure) -> RunFigure:
    data = result.data
    picture = new_figure(11.0, 4.2)
    left, right = picture.subplots(1, 2)
    for k, locus in data.loci.items():
        colour, linestyle = STIFFNESS_STYLES[k]
        color = legible(colour)
        style = {
            "label": parameter_value_text(locus.model, "k_nl", k),
            "color": color,
            "linestyle": linestyle,
        }
        for plot, ax in (plot_frequencies, left), (plot_growth_rates, right):
            plot(locus, ax, modes=data.pairs[k], legend=False, **style)
        right.plot(data.changes[k][0].value, 0.0, "o", color=color, markersize=5, zorder=3)
    legend_beside(
        right, [*right.get_legend_handles_labels()[0], growing_legend_handle(), _critical_legend_handle(data)]
    )
    left.set_title("(a) frequencies")
    right.set_title("(b) growth rates")
    model = next(iter(data.loci.values())).model
    picture.suptitle(
        f"Fig. {result.number}: the two modes that couple, {parameter_value_text(model, 'F', data.preload)}"
    )
    return picture


def _critical_legend_handle(data: Any) -> Line2D:
    symbol = parameter_symbol(next(iter(data.loci.values())).model, "mu_k")
    return Line2D([], [], color=ink(), linestyle="", marker="o", markersize=5, label=f"critical {symbol}")


@dataclass(frozen=True, eq=False)
class CriticalPreload:
    """What Figs 4 and 5 show: curves of the first loss of stability, by k_nl (N/m^3) or by name."""

    curves: Mapping[float | str, CriticalCurve]


def critical_figure(number: int) -> PaperFigure:
    """Fig. 4 or 5."""
    data, what = (
        (critical_by_stiffness(), "for three values of k_nl")
        if number == 4
        else (critical_by_geometry(), "with and without GN")
    )
    names = (key if isinstance(key, str) else f"k_nl = {key:g} N/m^3" for key in data.curves)
    summary = tuple(f"{name}: {_end_values_text(curve)}" for name, curve in zip(names, data.curves.values()))
    return PaperFigure(number, f"critical mu_k against the preload {what}", data, summary, _draw_critical)


def critical_by_stiffness() -> CriticalPreload:
    """Fig. 4."""
    return CriticalPreload({k: _refined_curve(SliderOnBelt(k_nl=k)) for k in STIFFNESSES})


def critical_by_geometry() -> CriticalPreload:
    """Fig. 5."""
    model = SliderOnBelt()
    return CriticalPreload(
        {WITH_GEOMETRY: _refined_curve(model), WITHOUT_GEOMETRY: _refined_curve(model.without("geometry"))}
    )


@cache
def _refined_curve(model: SliderOnBelt) -> CriticalCurve:
    at = PRELOAD_GRID
    curve, _ = curve_and_gaps(model, "mu_k", MU_K, over=("F", at))
    for _ in range(MAX_REFINEMENTS):
        steep = np.array(jump_indices(curve), dtype=int)
        if not steep.size:
            break
        between = 0.5 * (curve.at[steep] + curve.at[steep + 1])
        curve = _merge_curves(curve, curve_and_gaps(model, "mu_k", MU_K, over=("F", between))[0])
    curve.at.flags.writeable = curve.values.flags.writeable = False  # the cache returns the same arrays again
    return curve


def _merge_curves(curve: CriticalCurve, more: CriticalCurve) -> CriticalCurve:
    at = np.append(curve.at, more.at)
    order = np.argsort(at)
    return replace(curve, at=at[order], values=np.append(curve.values, more.values)[order])


def _end_values_text(curve: CriticalCurve) -> str:
    ends = ", ".join(preload_point_text(curve, i) for i in (0, -1))
    jumps = ", ".join(f"{curve.at[i]:.0f} N" for i in jump_indices(curve))
    return f"critical mu_k {ends}" + (f"; jumps at F = {jumps}, as another mode comes first" if jumps else "")


def preload_point_text(curve: CriticalCurve, i: int) -> str:
    """A point of a curve in words."""
    return f"{curve.values[i]:.4f} at F = {curve.at[i]:.4g} N"


def jump_indices(curve: CriticalCurve) -> list[int]:
    """Indices of the points right before a jump."""
    return np.flatnonzero(np.abs(np.diff(curve.values)) > MAX_CHANGE).tolist()


def _draw_critical(result: PaperFigure) -> RunFigure:
    curves = result.data.curves
    labels = [
        k if isinstance(k, str) else parameter_value_text(c.model, "k_nl", k) for k, c in curves.items()
    ]
    picture = new_figure(7.5, 4.2)
    ax = picture.add_subplot()
    plot_critical(list(curves.values()), ax, labels=labels)
    ax.set_xlim(left=0.0)
    ax.set_ylim(bottom=0.0)
    ax.set_title(f"Fig. {result.number}: first loss of stability")
    return picture


@dataclass(frozen=True, eq=False)
class TwoPairs:
    """What Fig. 6 shows; the dictionaries go by "with GN" and "without GN".

    Parameters
    ----------
    loci : dict of RootLocus
        All modes against mu_k.
    pairs : dict of list of (int, int)
        The columns of the modes that couple, pair by pair.
    changes : dict of tuple of StabilityChange
    """

    loci: dict[str, RootLocus]
    pairs: dict[str, list[tuple[int, int]]]
    changes: dict[str, tuple[StabilityChange, ...]]


def two_pairs_figure(number: int) -> PaperFigure:
    """Fig. 6."""
    data = two_pairs()
    caption = "eigenvalues with and without the geometrical nonlinearity"
    values = f"F = {TWO_PAIRS_MODEL.F:g} N, l1 = {TWO_PAIRS_MODEL.l1:g} m, l2 = {TWO_PAIRS_MODEL.l2:g} m"
    summary = tuple(f"{name}: {stability_changes_text(changes)}" for name, changes in data.changes.items())
    return PaperFigure(number, f"{caption}, {values}", data, summary, _draw_two_pairs)


def two_pairs() -> TwoPairs:
    """Root loci, pairs that couple and changes of stability, with and without GN."""
    models = {WITH_GEOMETRY: TWO_PAIRS_MODEL, WITHOUT_GEOMETRY: TWO_PAIRS_MODEL.without("geometry")}
    loci = {name: root_locus(m, "mu_k", np.linspace(*MU_K, LOCUS_POINTS)) for name, m in models.items()}
    pairs = {
        name: sorted({coupled_pair(locus, mode) for mode in growing_modes(locus)})
        for name, locus in loci.items()
    }
    return TwoPairs(loci, pairs, {name: stability_changes(m, "mu_k", MU_K) for name, m in models.items()})


def _draw_two_pairs(result: PaperFigure) -> RunFigure:
    picture = new_figure(11.0, 7.5)
    panels = picture.subplots(2, 2, sharex=True)
    for (left, right), (name, locus) in zip(panels, result.data.loci.items()):
        modes = [mode for pair in result.data.pairs[name] for mode in pair]
        plot_frequencies(locus, left, modes=modes, legend=False)
        plot_growth_rates(locus, right, modes=modes)
    for ax, title in zip(panels.flat, TWO_PAIRS_PANELS):
        ax.set_title(f"{title}, {WITH_GEOMETRY if ax in panels[0] else WITHOUT_GEOMETRY}")
    for ax in panels[0]:
        ax.set_xlabel("")
    values = ", ".join(
        parameter_value_text(TWO_PAIRS_MODEL, name, TWO_PAIRS_MODEL.parameters[name])
        for name in ("F", "l1", "l2")
    )
    picture.suptitle(f"Fig. {result.number}: modes that couple, {values}")
    return picture
