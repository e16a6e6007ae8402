"""Figures of equilibria and their stability, at one set of parameters and against parameters.

    root_locus              the mechanism displaced to an equilibrium, with its forces; eigenvalues, growth
                            rates and frequencies of the modes
    stability_boundaries    critical values in a plane, and the map of growing pairs; the vibration born where
                            an equilibrium loses its stability

Results of `frictionlab.stability` come in, artists go out.
"""
