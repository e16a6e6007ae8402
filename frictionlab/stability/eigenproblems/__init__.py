"""Eigenvalues of linearised models.

`eigenvalues` linearises one model at its equilibrium; `root_locus` does so along a path of a parameter, and
keeps each mode in one column through crossings, veerings and coalescence.
"""
