"""Quantities of a model: numbers with exact derivatives by all parameters, for sensitivity and uncertainty.

`quantities` defines the base class: a function of a model that also knows its gradient and takes many
parameter values at once.  It also has the quantities of an equilibrium, and `fl.sensitivity`, which
normalises and sorts gradients.  `critical_quantities` has those at the loss of stability, `folds` those
at a fold, `orbit_quantities` those of periodic orbits.

`optimum` (`fl.optimum`) minimises or maximises a quantity by its gradient; `uncertainty` (`fl.uncertainty`)
gives its distribution from those of the parameters, at scrambled Sobol points.  Every quantity can also be
the study of a sweep or an ablation.
"""
