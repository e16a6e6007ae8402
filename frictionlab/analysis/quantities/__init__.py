"""Quantities of a model: numbers with exact derivatives by all parameters, for sensitivity and uncertainty.

`sensitivity` says what one is, a function of a model that also knows its gradient and takes many parameter
values at once, and normalises and sorts gradients (`fl.sensitivity`).  `equilibrium_quantities` and
`critical_quantities` are those of linear stability.  `orbit_quantities` are those of periodic orbits.
`optimum` (`fl.optimum`) follows gradients; `uncertainty` (`fl.uncertainty`) gives the
distribution of a quantity from those of the parameters, at scrambled Sobol points.
Every quantity can also be the study of a sweep or an ablation.
"""
