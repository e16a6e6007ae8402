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

from .animation.animate import animate
from .figure import RunFigure, axes_or_new
from .runs.overview import (
    Spectrum,
    amplitude_spectrum,
    plot_amplitudes,
    plot_phase_plane,
    plot_run,
    plot_spectrum,
)
from .runs.run_checks import plot_energies, plot_verification, plot_works
from .runs.time_histories import plot_contact_forces, plot_displacements, plot_rates, shade_modes
from .stability.root_locus import (
    plot_eigenvalues,
    plot_equilibrium,
    plot_frequencies,
    plot_growth_rates,
    plot_root_locus,
)
from .stability.stability_boundaries import plot_critical, plot_hopf, plot_stability_map
from .studies.ablation import plot_ablation, plot_effects, plot_scene_lattice
from .studies.quantities import plot_sensitivity, plot_sobol_indices, plot_uncertainty
from .studies.state_space import (
    plot_basin_stability,
    plot_basins,
    plot_ends,
    plot_lyapunov,
    plot_orbit,
    plot_steady_state,
    plot_tangent_flow,
)
from .studies.sweeps import plot_bifurcation, plot_intensity, plot_orbit_branch, plot_sweep

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
