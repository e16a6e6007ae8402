"""Root locus: two modes couple.

As friction grows two frequencies draw together and meet; from there on one of the two modes grows and
the other decays. This is flutter, the mechanism behind the paper's Figs. 2, 3 and 6.
"""

import numpy as np

import frictionlab as fl
from frictionlab.plotting import RunFigure, plot_frequencies, plot_growth_rates, plot_root_locus

model = fl.SliderOnBelt()
locus = fl.root_locus(model, "mu_k", np.linspace(0, 3, 301))
critical = fl.critical_value(model, "mu_k", bounds=(0, 3))

figure = RunFigure(figsize=(11, 3.8), layout="constrained")
frequencies, growth, plane = figure.subplots(1, 3)
plot_frequencies(locus, frequencies, legend=False)
plot_growth_rates(locus, growth, legend=False)
plot_root_locus(locus, plane)
for ax in (frequencies, growth):
    ax.axvline(critical, color="#999999", linewidth=0.8)
    ax.set_title(f"critical: {critical:.4f}")
