"""Branches of periodic orbits, followed through a parameter.

`continue_orbit` follows a branch both ways from an orbit; `driver` chooses the steps, ends a branch, locates
folds, period doublings and Neimark-Sacker points between two points of it, and names what happens where the
sequence of modes changes; `pseudo_arclength` takes one step (tangent predictor, Newton corrector) and gives a
`BranchPoint`.
"""
