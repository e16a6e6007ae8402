"""Fig. 6: with the geometrical nonlinearity (GN) two pairs of modes are unstable, without it only one.

The text gives k_nl and the range of mu_k no more than for Fig. 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictionlab.models import SliderOnBelt
from frictionlab.plotting import RunFigure, plot_frequencies, plot_growth_rates
from frictionlab.plotting.parameters import parameter_value
from frictionlab.stability import RootLocus, StabilityChange, root_locus, stability_changes

from .coalescence import MU_K, POINTS
from .critical import WITH, WITHOUT
from .pairs import coupled_pair, growing_modes, in_words
from .result import PaperFigure

MODEL = SliderOnBelt(F=1000.0, l1=0.1, l2=0.3)
PANELS = ("(a) frequencies", "(b) growth rates", "(c) frequencies", "(d) growth rates")


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


def figure(number: int) -> PaperFigure:
    """Fig. 6."""
    data = two_pairs()
    caption = "eigenvalues with and without the geometrical nonlinearity"
    values = f"F = {MODEL.F:g} N, l1 = {MODEL.l1:g} m, l2 = {MODEL.l2:g} m"
    summary = tuple(f"{name}: {in_words(changes)}" for name, changes in data.changes.items())
    return PaperFigure(number, f"{caption}, {values}", data, summary, _draw)


def two_pairs() -> TwoPairs:
    """Root loci, pairs that couple and changes of stability, with and without GN."""
    models = {WITH: MODEL, WITHOUT: MODEL.without("geometry")}
    loci = {name: root_locus(m, "mu_k", np.linspace(*MU_K, POINTS)) for name, m in models.items()}
    pairs = {
        name: sorted({coupled_pair(locus, mode) for mode in growing_modes(locus)})
        for name, locus in loci.items()
    }
    return TwoPairs(loci, pairs, {name: stability_changes(m, "mu_k", MU_K) for name, m in models.items()})


def _draw(result: PaperFigure) -> RunFigure:
    picture = RunFigure(figsize=(11.0, 7.5), layout="constrained")
    panels = picture.subplots(2, 2, sharex=True)
    for (left, right), (name, locus) in zip(panels, result.data.loci.items()):
        modes = [mode for pair in result.data.pairs[name] for mode in pair]
        plot_frequencies(locus, left, modes=modes, legend=False)
        plot_growth_rates(locus, right, modes=modes)
    for ax, title in zip(panels.flat, PANELS):
        ax.set_title(f"{title}, {WITH if ax in panels[0] else WITHOUT}")
    for ax in panels[0]:
        ax.set_xlabel("")
    values = ", ".join(parameter_value(MODEL, name, MODEL.parameters[name]) for name in ("F", "l1", "l2"))
    picture.suptitle(f"Fig. {result.number}: modes that couple, {values}")
    return picture
