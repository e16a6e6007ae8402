"""What analyses found, as figures.

    sweeps          motions against a parameter, branches of periodic orbits, any sweep over its grid
    fitting         residuals of a fit
    ablation        the scenes of an ablation, the effects of its switches, the lattice of scenes
    state_space     steady states, periodic orbits and ends in a phase plane, basins of attraction
    quantities      sensitivities, distributions and Sobol indices of quantities

A result of `frictionlab.analysis` comes in, artists go out.
"""
