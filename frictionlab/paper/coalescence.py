"""Figs 2 and 3: two modes couple as mu_k grows; frequencies and growth rates for three contacts.

The text gives neither the values of k_nl nor the range of mu_k: k_nl is that of Figs 9 to 14, and mu_k ends
at mu_s = 3.  Frequencies are in Hz, as those of Fig. 8.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from frictionlab.models import SliderOnBelt
from frictionlab.plotting import RunFigure, plot_frequencies, plot_growth_rates
from frictionlab.plotting.legends import legend_beside
from frictionlab.plotting.locus import growing_handle
from frictionlab.plotting.palette import BLACK, BLUE, DASHED, VERMILLION
from frictionlab.plotting.parameters import parameter_symbol, parameter_value
from frictionlab.stability import RootLocus, StabilityChange, root_locus, stability_changes

from .pairs import coupled_pair, growing_modes, in_words
from .result import PaperFigure

PRELOADS = {2: 100.0, 3: 1000.0}
STIFFNESSES = (0.0, 1e4, 1e7)
MU_K = (0.0, 3.0)
POINTS = 601
# Dashed over solid: where two curves coincide both are seen.
STYLES = dict(zip(STIFFNESSES, ((BLACK, "-"), (VERMILLION, DASHED), (BLUE, "-"))))


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


def figure(number: int) -> PaperFigure:
    """Fig. 2 (F = 100 N) or 3 (F = 1000 N)."""
    data = coalescence(PRELOADS[number])
    caption = f"eigenvalues of the two modes that couple, F = {data.preload:g} N"
    summary = (f"k_nl = {k:g} N/m^3: {in_words(changes)}" for k, changes in data.changes.items())
    return PaperFigure(number, caption, data, tuple(summary), _draw)


def coalescence(preload: float) -> Coalescence:
    """Root loci and changes of stability for the three values of k_nl."""
    models = {k: SliderOnBelt(F=preload, k_nl=k) for k in STIFFNESSES}
    loci = {k: root_locus(model, "mu_k", np.linspace(*MU_K, POINTS)) for k, model in models.items()}
    pairs = {k: coupled_pair(locus, growing_modes(locus)[0]) for k, locus in loci.items()}
    return Coalescence(
        preload, loci, pairs, {k: stability_changes(m, "mu_k", MU_K) for k, m in models.items()}
    )


def _draw(result: PaperFigure) -> RunFigure:
    data = result.data
    picture = RunFigure(figsize=(11.0, 4.2), layout="constrained")
    left, right = picture.subplots(1, 2)
    for k, locus in data.loci.items():
        color, linestyle = STYLES[k]
        style = {"label": parameter_value(locus.model, "k_nl", k), "color": color, "linestyle": linestyle}
        for plot, ax in (plot_frequencies, left), (plot_growth_rates, right):
            plot(locus, ax, modes=data.pairs[k], legend=False, **style)
        right.plot(data.changes[k][0].value, 0.0, "o", color=color, markersize=5, zorder=3)
    legend_beside(right, [*right.get_legend_handles_labels()[0], growing_handle(), _critical(data)])
    left.set_title("(a) frequencies")
    right.set_title("(b) growth rates")
    model = next(iter(data.loci.values())).model
    picture.suptitle(
        f"Fig. {result.number}: the two modes that couple, {parameter_value(model, 'F', data.preload)}"
    )
    return picture


def _critical(data: Any) -> Line2D:
    symbol = parameter_symbol(next(iter(data.loci.values())).model, "mu_k")
    return Line2D([], [], color=BLACK, linestyle="", marker="o", markersize=5, label=f"critical {symbol}")
