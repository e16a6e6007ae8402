# The public names of frictionlab.plotting, each once; `__init__.py` loads a name from its module when it is
# first used, as the modules of all take a second to load.

from .ablation import plot_ablation as plot_ablation
from .animation.animate import animate as animate
from .basins import plot_basin_stability as plot_basin_stability
from .basins import plot_basins as plot_basins
from .bifurcation import plot_bifurcation as plot_bifurcation
from .bifurcation import plot_intensity as plot_intensity
from .bifurcation import plot_orbit_branch as plot_orbit_branch
from .energy import plot_energies as plot_energies
from .energy import plot_works as plot_works
from .factorial_effects import plot_effects as plot_effects
from .factorial_effects import plot_scene_lattice as plot_scene_lattice
from .figure import RunFigure as RunFigure
from .figure import axes_or_new as axes_or_new
from .fitting import plot_fit as plot_fit
from .motions import plot_ends as plot_ends
from .motions import plot_lyapunov as plot_lyapunov
from .motions import plot_orbit as plot_orbit
from .motions import plot_steady_state as plot_steady_state
from .motions import plot_tangent_flow as plot_tangent_flow
from .runs.overview import plot_run as plot_run
from .runs.phase_plane import plot_phase_plane as plot_phase_plane
from .runs.spectrum import Spectrum as Spectrum
from .runs.spectrum import amplitude_spectrum as amplitude_spectrum
from .runs.spectrum import plot_amplitudes as plot_amplitudes
from .runs.spectrum import plot_spectrum as plot_spectrum
from .runs.time_histories import plot_contact_forces as plot_contact_forces
from .runs.time_histories import plot_displacements as plot_displacements
from .runs.time_histories import plot_rates as plot_rates
from .runs.time_window import shade_modes as shade_modes
from .sensitivity import plot_sensitivity as plot_sensitivity
from .stability.equilibrium import plot_equilibrium as plot_equilibrium
from .stability.hopf import plot_hopf as plot_hopf
from .stability.root_locus import plot_eigenvalues as plot_eigenvalues
from .stability.root_locus import plot_frequencies as plot_frequencies
from .stability.root_locus import plot_growth_rates as plot_growth_rates
from .stability.root_locus import plot_root_locus as plot_root_locus
from .stability.stability_boundaries import plot_critical as plot_critical
from .stability.stability_boundaries import plot_stability_map as plot_stability_map
from .sweep import plot_sweep as plot_sweep
from .uncertainty import plot_sobol_indices as plot_sobol_indices
from .uncertainty import plot_uncertainty as plot_uncertainty
from .verification import plot_verification as plot_verification

__all__: list[str]
