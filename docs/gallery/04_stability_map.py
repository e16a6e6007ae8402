"""Stability map.

How many modes grow, over preload and friction, with the boundary followed to rounding. With the belt's
rotation (right) the critical friction is smaller at every preload, as the paper's Figs. 4 and 5 say.
"""

import numpy as np

import frictionlab as fl
from frictionlab.plotting import RunFigure, plot_stability_map

full = fl.SliderOnBelt()
scenes = {"without the belt's rotation": full.without("geometry"), "with it": full}
axes_of_map = {"x": ("F", np.linspace(50, 1000, 39)), "y": ("mu_k", np.linspace(0, 3, 41))}
maps = {name: fl.stability_map(model, **axes_of_map) for name, model in scenes.items()}

figure = RunFigure(figsize=(11, 4), layout="constrained")
for ax, (name, found) in zip(figure.subplots(1, 2, sharey=True), maps.items(), strict=True):
    plot_stability_map(found, ax, legend=name == "with it")
    ax.set_title(name)
