"""Periodic orbits, and their branches along a parameter.

`periodic_orbit` takes a guess, state and period, from a steady state, a run or a state, corrects it by
Newton's method with the tangent flow (shooting), checks the result, and gives the orbit with its monodromy
matrix and Floquet multipliers.

`continue_orbit` follows a branch both ways from an orbit; `branches` chooses the steps, ends a branch,
locates folds, period doublings and Neimark-Sacker points between two of its points, and tells what kind of
change there is where the sequence of modes changes; `pseudo_arclength` takes one step (tangent predictor,
Newton corrector) and gives a `BranchPoint`.
"""
