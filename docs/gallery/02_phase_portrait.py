"""Two fates, one phase plane.

The same system, two starts. From rest (left) it ends on a cycle of stick, slip and flight; from one
percent beside the equilibrium (right) it slides on for ever, and its vibration dies out slowly. Where
both are possible, linear stability does not tell whether a brake is silent.
"""

import frictionlab as fl
from frictionlab.plotting import RunFigure, plot_phase_plane

model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
far, near = (fl.simulate(model, 20.0, x0=start) for start in ("rest", "near"))
assert len(near.events) == 0 < len(far.events)
assert fl.eigenvalues(model).stable

figure = RunFigure(figsize=(10, 4), layout="constrained")
left, right = figure.subplots(1, 2)
plot_phase_plane(far, left, window=5.0)
plot_phase_plane(near, right, window=None)
left.set_title("from rest: a cycle")
right.set_title("from near the equilibrium: back to it")
