"""Figures of runs, stability and sweeps: plain functions that draw into `ax` and return the artists made.

None of them uses pyplot, so a figure is freed with its last reference and no window opens.

    figure                  figures that show themselves in a notebook, the axes to draw into, legends; a
                            panel as data: curves, labels, limits (the explorers' panels give these)
    appearance              `fl.style`, the user's settings of matplotlib, colours on dark backgrounds
    style                   lines and colours of coordinates and modes, symbols of states and parameters
    runs/                   panels of one run, and `plot_run`, which is four of them
    stability/              equilibria, eigenvalues, critical values, Hopf points
    studies/                what analyses found: sweeps and bifurcations, ablations, motions and basins in
                            state space, sensitivities and uncertainties of quantities
    animation/              the slider on its belt, frame by frame

A result of an analysis comes in, artists go out; nothing is computed here but samples of a run.
"""

from __future__ import annotations

from frictionlab.lazy_names import homes_in_stub, loader_of_names

_HOME = homes_in_stub(__loader__, __path__[0])
__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]
__getattr__ = loader_of_names(__name__, _HOME, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
