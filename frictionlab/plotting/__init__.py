"""Figures of runs: plain functions that draw into `ax` and return the artists they made.

None of them uses pyplot, so a figure is freed with its last reference and no window opens.
"""

from __future__ import annotations

from .displacements import plot_displacements
from .figure import RunFigure
from .forces import plot_contact_forces
from .phase_plane import plot_phase_plane
from .run import plot_run
from .shading import shade_modes
from .spectrum import Spectrum, amplitude_spectrum, plot_spectrum

__all__ = [
    "RunFigure",
    "Spectrum",
    "amplitude_spectrum",
    "plot_contact_forces",
    "plot_displacements",
    "plot_phase_plane",
    "plot_run",
    "plot_spectrum",
    "shade_modes",
]
