"""A limit cycle and its multipliers.

A periodic orbit by Newton's method, and the Floquet multipliers that say what becomes of a small deviation
after one period. All but the one along the orbit lie inside the unit circle, so the cycle attracts.
Stick makes one of them zero: it forgets.
"""

import numpy as np

import frictionlab as fl
from frictionlab.plotting import RunFigure, plot_phase_plane

model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
orbit = fl.periodic_orbit(model, fl.simulate(model, 60.0))
assert orbit.stable
assert np.abs(orbit.multipliers).min() < 1e-9

figure = RunFigure(figsize=(10, 4.2), layout="constrained")
left, right = figure.subplots(1, 2)
plot_phase_plane(orbit.trajectory, left, window=None)
left.set_title(f"period {orbit.period:.5f} s")

turn = np.linspace(0, 2 * np.pi, 181)
right.plot(np.cos(turn), np.sin(turn), color="#999999", linewidth=0.8)
right.plot(orbit.multipliers.real, orbit.multipliers.imag, "o", color="#0072B2")
right.set(aspect="equal", xlabel="real part", ylabel="imaginary part", title="Floquet multipliers")
