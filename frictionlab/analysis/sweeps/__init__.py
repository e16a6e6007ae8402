"""Many independent runs.

`sweep` (any function over a grid), `bifurcation` (steady states against a parameter) and `ablation` (studies
of all scenes of a model) make tasks: models with the arguments of a function.  `tasks` runs them in threads
or any executor.  A `journal` keeps the results, and its file lets an interrupted sweep go on.  Basins and
uncertainties are computed in the same way.

`factorial_design` has the switches of an ablation and their scenes; it finds numbers in the results, and the
effects of the switches on them.
"""
