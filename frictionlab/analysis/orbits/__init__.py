"""Periodic orbits.

`orbit_guess` makes a state and a period of a steady state, a run or a state; `shooting` corrects them by
Newton's method with the tangent flow and checks the result; `periodic_orbit` gives the orbit with its
monodromy matrix and Floquet multipliers.
"""
