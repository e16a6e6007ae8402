"""Energy audit.

The belt's drive pays for everything. Above, what each contribution has done since the start; their sum
is the energy that the system has gained, to rounding. Below, where that energy is.
"""

import frictionlab as fl
from frictionlab.plotting import RunFigure, plot_energies, plot_works

run = fl.simulate(fl.SliderOnBelt(mu_k=1.4).without("geometry"), 1.0)
audit = fl.energy_audit(run, progress=False)
assert audit.error < 1e-13

figure = RunFigure(figsize=(9, 6), layout="constrained")
above, below = figure.subplots(2, 1, sharex=True)
plot_works(audit, above)
plot_energies(audit, below)
above.set_xlabel("")
