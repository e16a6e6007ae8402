"""Quantities of a model: numbers with exact derivatives by all parameters, for sensitivity and uncertainty.

`quantities` says what one is, a function of a model that also knows its gradient and takes many parameter
values at once, has those of an equilibrium, and normalises and sorts gradients (`fl.sensitivity`).
`critical_quantities` are those of the loss of stability.  `orbit_quantities` are those of periodic orbits.
`optimum` (`fl.optimum`) follows gradients; `uncertainty` (`fl.uncertainty`) gives the
distribution of a quantity from those of the parameters, at scrambled Sobol points.
Every quantity can also be the study of a sweep or an ablation.
"""
