"""What is done with models: runs, and what is found out from them.

`simulate` and `ensemble` run models; `lyapunov`, `motion_scales` (with spectra) and `energy_audit` (the
energy balance of a run) look at motions; `parameter_flow` gives the derivatives of a run by parameters.
`verify` tells whether a run can be trusted: it runs a model again by other methods and from a neighbouring
state; `run_comparison` compares two runs in their events and, between these, in their states, and samples
the defects of steps of one run, for the sentence that steady states and explorers show.All further analyses
are packages: `steady_state` (what a motion settles to), `orbits` (periodic orbits, their multipliers, and
how they follow a parameter), `sweeps` (many runs over parameters, in workers, resumable), `basins` (which
initial states lead to which attractor), `quantities` (numbers with exact derivatives: sensitivity,
uncertainty, optima), `fitting` (parameters from measurements). Data pass as `Trajectory` objects from the
solver and leave as frozen dataclasses with arrays.
"""
