"""The claims of the paper, C1 to C25, and what a computation says of each.

    linear_stability      C1 to C8: equilibria, eigenvalues, critical friction
    bifurcations          C9 to C15: motions and steady states with all three nonlinearities, Figs 7 to 12;
                          C16 to C20: without the geometrical nonlinearity, Figs 13 to 15
    nonsmooth             C21 to C25: with and without the non-smooth behaviours, Figs 16 to 18

Each module of claims has a table CHECKS: a function that gives the Claim (C1 to C8), or a ClaimCheck that
`frictionlab.paper.results.compare` puts to the exact solver with both impact laws and to the paper's
algorithm.
"""
