# The public names of frictionlab.plotting, each once.  `__init__.py` loads a name from its module when it is
# first used, as loading all the modules takes a second.

from .animation.animate import animate as animate
from .figure import RunFigure as RunFigure
from .figure import add_missing_legend as add_missing_legend
from .figure import axes_or_new as axes_or_new
from .overview import Spectrum as Spectrum
from .overview import amplitude_spectrum as amplitude_spectrum
from .overview import label_modes as label_modes
from .overview import plot_amplitudes as plot_amplitudes
from .overview import plot_energies as plot_energies
from .overview import plot_phase_plane as plot_phase_plane
from .overview import plot_run as plot_run
from .overview import plot_spectrogram as plot_spectrogram
from .overview import plot_spectrum as plot_spectrum
from .overview import plot_verification as plot_verification
from .overview import plot_works as plot_works
from .root_locus import plot_eigenvalues as plot_eigenvalues
from .root_locus import plot_equilibrium as plot_equilibrium
from .root_locus import plot_frequencies as plot_frequencies
from .root_locus import plot_frequency_response as plot_frequency_response
from .root_locus import plot_growth_rates as plot_growth_rates
from .root_locus import plot_root_locus as plot_root_locus
from .stability_boundaries import plot_critical as plot_critical
from .stability_boundaries import plot_hopf as plot_hopf
from .stability_boundaries import plot_stability_map as plot_stability_map
from .studies.ablation import plot_ablation as plot_ablation
from .studies.ablation import plot_effects as plot_effects
from .studies.ablation import plot_scene_lattice as plot_scene_lattice
from .studies.quantities import plot_fit as plot_fit
from .studies.quantities import plot_optimum as plot_optimum
from .studies.quantities import plot_sensitivity as plot_sensitivity
from .studies.quantities import plot_sobol_indices as plot_sobol_indices
from .studies.quantities import plot_uncertainty as plot_uncertainty
from .studies.state_space import plot_basin_stability as plot_basin_stability
from .studies.state_space import plot_basins as plot_basins
from .studies.state_space import plot_ends as plot_ends
from .studies.state_space import plot_lyapunov as plot_lyapunov
from .studies.state_space import plot_orbit as plot_orbit
from .studies.state_space import plot_steady_state as plot_steady_state
from .studies.state_space import plot_tangent_flow as plot_tangent_flow
from .studies.sweeps import plot_bifurcation as plot_bifurcation
from .studies.sweeps import plot_cea_against_motion as plot_cea_against_motion
from .studies.sweeps import plot_intensity as plot_intensity
from .studies.sweeps import plot_orbit_branch as plot_orbit_branch
from .studies.sweeps import plot_sweep as plot_sweep
from .time_histories import plot_contact_forces as plot_contact_forces
from .time_histories import plot_displacements as plot_displacements
from .time_histories import plot_rates as plot_rates
from .time_histories import shade_modes as shade_modes

__all__: list[str]
