"""What is done with models: runs, and what is found out from them.

`simulate` and `ensemble` run models; `lyapunov`, `spectrum` and `energy_audit` (the energy balance of a run)
look at motions.  All further analyses are packages: `verification` (can a run be trusted), `steady_state`
(what a motion settles to), `orbits` (periodic orbits and their multipliers), `continuation` (orbits followed
through a parameter), `sweeps` (many runs over parameters, in workers, resumable), `basins` (which initial
states lead to which attractor). Data pass as `Trajectory` objects from the solver and leave as frozen
dataclasses with arrays.
"""
