"""What is done with models: runs, and what is found out from them.

`simulate` and `ensemble` run models; `lyapunov`, `spectrum` and `energy_audit` (the energy balance of a run)
look at motions; `parameter_flow` gives the derivatives of a run by parameters.  All further analyses are
packages: `verification` (can a run be trusted), `steady_state` (what a motion settles to), `orbits` (periodic
orbits and their multipliers), `continuation` (orbits followed through a parameter), `sweeps` (many runs over
parameters, in workers, resumable), `basins` (which initial states lead to which attractor), `quantities`
(numbers with exact derivatives: sensitivity, uncertainty, optima), `fitting` (parameters from measurements).
Data pass as `Trajectory` objects from the solver and leave as frozen dataclasses with arrays.
"""
