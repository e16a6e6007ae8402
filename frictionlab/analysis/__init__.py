"""Analyses of models: runs, and what can be learnt from them.

`simulate` and `ensemble` run models; `lyapunov`, `motion_scales` (with spectra) and `energy_audit` (the
energy balance of a run) look at motions; `parameter_flow` gives the derivatives of a run by parameters.
`verify` tells whether a run can be trusted: it runs a model again by other methods and from a neighbouring
state; `run_comparison` compares two runs in their events and, between these, in their states, and makes the
warning that steady states and explorers show from the defects of some steps of a run.

All further analyses are packages: `steady_state` (what a motion settles to), `orbits` (periodic orbits, their
multipliers, and their branches along a parameter), `sweeps` (many runs over parameters, in workers,
resumable), `basins` (which initial states lead to which attractor), `quantities` (numbers with exact
derivatives: sensitivity, uncertainty, optima), `fitting` (parameters from measurements).

Analyses take `Trajectory` objects from the solver and return frozen dataclasses with arrays.
"""
