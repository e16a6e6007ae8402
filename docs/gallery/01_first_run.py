"""A first run.

The slider rests on the belt, which starts to move. Displacements, phase plane, contact forces and
spectrum of what it settles to; the ground of the panels tells the mode. Without the belt's rotation
every oscillation is like the last.
"""

import frictionlab as fl

model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
run = fl.simulate(model, 20.0)
assert run.status.ok

figure = fl.plot_run(run, window=0.4)
