"""Eigenvalues of linearised models.

`eigenvalues` linearises one model at its equilibrium.  `root_locus` does so along a path of a parameter, and
keeps each mode in one column through crossings, veerings and coalescence.  `displaced_equilibrium` gives a
state near an equilibrium, from which runs start (``x0="near"``).  `linear_system` has the linearised system
with inputs and outputs, as control engineers write it, and its frequency responses.
"""
