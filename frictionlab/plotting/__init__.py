"""Figures of runs, stability and sweeps: plain functions that draw into `ax` and return the artists made.

None of them uses pyplot, so a figure is freed with its last reference and no window opens.
"""

from __future__ import annotations

from .ablation import plot_ablation
from .animation import animate
from .basins import plot_basin_stability, plot_basins
from .bifurcation import plot_bifurcation, plot_intensity
from .critical import plot_critical
from .displacements import plot_displacements
from .energy import plot_energies, plot_works
from .figure import RunFigure
from .forces import plot_contact_forces
from .locus import plot_frequencies, plot_growth_rates
from .orbit_branch import plot_orbit_branch
from .phase_plane import plot_phase_plane
from .rates import plot_rates
from .root_locus import plot_root_locus
from .run import plot_run
from .shading import shade_modes
from .spectrum import Spectrum, amplitude_spectrum, plot_spectrum
from .stability_map import plot_stability_map

__all__ = [
    "RunFigure",
    "Spectrum",
    "amplitude_spectrum",
    "animate",
    "plot_ablation",
    "plot_basin_stability",
    "plot_basins",
    "plot_bifurcation",
    "plot_contact_forces",
    "plot_critical",
    "plot_displacements",
    "plot_energies",
    "plot_frequencies",
    "plot_growth_rates",
    "plot_intensity",
    "plot_orbit_branch",
    "plot_phase_plane",
    "plot_rates",
    "plot_root_locus",
    "plot_run",
    "plot_spectrum",
    "plot_stability_map",
    "plot_works",
    "shade_modes",
]
