"""Figures of what analyses found.

    sweeps          motions against a parameter, branches of periodic orbits, any sweep over its grid
    ablation        the scenes of an ablation, the effects of its switches, the lattice of scenes
    state_space     steady states, periodic orbits and final states in a phase plane, basins of attraction
    quantities      sensitivities, distributions, Sobol indices and optima of quantities, residuals of a fit

Each function takes a result of `frictionlab.analysis` and returns artists.
"""
