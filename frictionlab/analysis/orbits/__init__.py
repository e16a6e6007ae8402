"""Periodic orbits.

`shooting` makes a guess, state and period, of a steady state, a run or a state, corrects it by Newton's
method with the tangent flow and checks the result; `periodic_orbit` gives the orbit with its
monodromy matrix and Floquet multipliers.
"""
