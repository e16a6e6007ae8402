"""Bifurcation diagram.

What the motion from rest settles to, for each coefficient of friction: x1 at every onset of stick, and
below the intensity L_s, Eq. (20). Without the belt's rotation the cycle hardly changes, as in the
paper's Figs. 13 and 14.
"""

import numpy as np

import frictionlab as fl
from frictionlab.plotting import RunFigure, plot_bifurcation, plot_intensity

model = fl.SliderOnBelt().without("geometry")
values = np.linspace(0.1, 2.9, 141)
diagram = fl.bifurcation(model, "mu_k", values, transient=150, window=20, progress=False)

figure = RunFigure(figsize=(8, 6), layout="constrained")
above, below = figure.subplots(2, 1, sharex=True)
plot_bifurcation(diagram, above)
plot_intensity(diagram, below)
above.set_xlabel("")
