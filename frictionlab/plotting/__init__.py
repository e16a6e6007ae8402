"""Figures of runs, stability and sweeps: plain functions that draw into `ax` and return the artists made.

None of them uses pyplot, so a figure is freed with its last reference and no window opens.

    figure                  figures that show themselves in a notebook, the axes to draw into, legends; a
                            panel as data: curves, labels, limits (what the explorers' panels return)
    appearance              `fl.style`, the user's settings of matplotlib, colours on dark backgrounds;
                            lines and colours of coordinates and modes
    labels                  symbols, meanings and units of states and parameters on axes and in legends
    time_histories          which part of a run is shown, its samples and modes; displacements, rates and
                            contact forces against time
    overview                a coordinate against its rate, coloured by mode; the amplitude spectrum of a
                            state; `plot_run`: four of these in one figure; energies and works, and what a
                            verification found
    root_locus              the mechanism displaced to an equilibrium, with its forces; eigenvalues, growth
                            rates and frequencies of the modes
    stability_boundaries    critical values in a plane, and the map of growing pairs; the vibration born where
                            an equilibrium loses its stability
    studies/                what analyses found: sweeps and bifurcations, ablations, motions and basins in
                            state space, sensitivities and uncertainties of quantities
    animation/              the mechanism or the time history of a run, frame by frame

Each function takes the result of an analysis and returns artists; all it computes are samples of a run.
"""

from __future__ import annotations

from frictionlab.lazy_names import homes_in_stub, loader_of_names

_HOME = homes_in_stub(__loader__, __path__[0])
__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]  # it reads literals only
__getattr__ = loader_of_names(__name__, _HOME, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
