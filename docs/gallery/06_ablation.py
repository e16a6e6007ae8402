"""Ablation: which nonlinearity does what.

The critical friction coefficient with each of the three nonlinearities on or off. The non-smooth
behaviours do not matter, as the system slides near its equilibrium; the belt's rotation does.
"""

import frictionlab as fl
from frictionlab.plotting import plot_ablation

model = fl.SliderOnBelt(k_nl=1e7)
table = fl.ablation(model, lambda one: fl.critical_value(one, "mu_k", bounds=(0, 4)), progress=False)
assert table["nonsmooth"] == table[()]

axes = plot_ablation(table)
axes[0].set_xlabel("critical coefficient of friction")
axes[0].margins(x=0.15)
figure = axes[0].figure
