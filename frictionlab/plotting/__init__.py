"""Figures of runs, stability and sweeps: plain functions that draw into `ax` and return the artists made.

None of them uses pyplot, so a figure is freed with its last reference and no window opens.

    figure                  figures that show themselves in a notebook, the axes to draw into, legends
    appearance              `fl.style`, the user's settings of matplotlib, colours on dark backgrounds
    style                   lines and colours of coordinates and modes, symbols of states and parameters
    drawing                 a panel as data: curves, labels, limits (the explorers' panels give these)
    runs/                   panels of one run, and `plot_run`, which is four of them
    stability/              equilibria, eigenvalues, critical values, Hopf points
    bifurcation, basins, energy, ablation, factorial_effects, sweep, motions,
    fitting, sensitivity, uncertainty, verification                            what analyses found
    animation/              the slider on its belt, frame by frame

A result of an analysis comes in, artists go out; nothing is computed here but samples of a run.
"""

from __future__ import annotations

from .ablation import plot_ablation
from .animation.animate import animate
from .basins import plot_basin_stability, plot_basins
from .bifurcation import plot_bifurcation, plot_intensity, plot_orbit_branch
from .energy import plot_energies, plot_works
from .factorial_effects import plot_effects, plot_scene_lattice
from .figure import RunFigure, axes_or_new
from .fitting import plot_fit
from .motions import plot_ends, plot_lyapunov, plot_orbit, plot_steady_state, plot_tangent_flow
from .runs.overview import plot_run
from .runs.phase_plane import plot_phase_plane
from .runs.spectrum import Spectrum, amplitude_spectrum, plot_amplitudes, plot_spectrum
from .runs.time_histories import plot_contact_forces, plot_displacements, plot_rates
from .runs.time_window import shade_modes
from .sensitivity import plot_sensitivity
from .stability.equilibrium import plot_equilibrium
from .stability.hopf import plot_hopf
from .stability.root_locus import plot_eigenvalues, plot_frequencies, plot_growth_rates, plot_root_locus
from .stability.stability_boundaries import plot_critical, plot_stability_map
from .sweep import plot_sweep
from .uncertainty import plot_sobol_indices, plot_uncertainty
from .verification import plot_verification

__all__ = [
    "RunFigure",
    "Spectrum",
    "amplitude_spectrum",
    "animate",
    "axes_or_new",
    "plot_ablation",
    "plot_amplitudes",
    "plot_basin_stability",
    "plot_basins",
    "plot_bifurcation",
    "plot_contact_forces",
    "plot_critical",
    "plot_displacements",
    "plot_effects",
    "plot_eigenvalues",
    "plot_ends",
    "plot_energies",
    "plot_equilibrium",
    "plot_fit",
    "plot_frequencies",
    "plot_growth_rates",
    "plot_hopf",
    "plot_intensity",
    "plot_lyapunov",
    "plot_orbit",
    "plot_orbit_branch",
    "plot_phase_plane",
    "plot_rates",
    "plot_root_locus",
    "plot_run",
    "plot_scene_lattice",
    "plot_sensitivity",
    "plot_sobol_indices",
    "plot_spectrum",
    "plot_stability_map",
    "plot_steady_state",
    "plot_sweep",
    "plot_tangent_flow",
    "plot_uncertainty",
    "plot_verification",
    "plot_works",
    "shade_modes",
]
