"""Many independent runs.

`sweep` (any function over a grid), `bifurcation` (steady states against a parameter) and `ablation` (studies
of all scenes of a model) make tasks: models with the arguments of a function.  `sweep.run_tasks` runs them in
threads or any executor and hands each result to a `journal`, from whose file an interrupted sweep can go on.
`factorial_design` has the switches of an ablation and their scenes; it finds numbers in the results, and the
effects of the switches on them.
"""
