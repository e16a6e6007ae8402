"""Many independent runs.

`sweep` (any function over a grid), `bifurcation` (steady states against a parameter) and `ablation` (studies
of all combinations of a model's switches) make tasks, models with arguments. `sweep.run_tasks` does them
in threads or any executor and hands each result, data that JSON can hold, to a `journal`, from which a sweep
that was cut off goes on. `factorial_design` has the switches of an ablation and their combinations; it finds
numbers in the results, and the effects of the switches on them.
"""
