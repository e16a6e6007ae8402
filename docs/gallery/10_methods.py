"""Methods compared: error against step.

The paper's fixed-step algorithm beside the solver that locates every event, on a second of stick, slip
and flight. With the gap's full rate in the impact law the error falls with the fourth power of the step
(dashed) once the step is small enough.
"""

import numpy as np

import frictionlab as fl
from frictionlab.plotting import RunFigure

model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
exact = fl.simulate(model, 1.0)
steps = np.array([8e-4, 4e-4, 2e-4, 1e-4, 5e-5])


def error(method):
    return np.abs(fl.simulate(model, 1.0, method=method).final_state - exact.final_state).max()


errors = np.array([error(fl.RK4(step=step)) for step in steps])
other_order = error(fl.Taylor(order=34))
assert other_order < 1e-12 < errors.min()

figure = RunFigure(figsize=(7, 4.5), layout="constrained")
ax = figure.add_subplot()
ax.loglog(steps, errors, "o-", color="#D55E00", label="RK4, the paper's algorithm")
ax.loglog(
    steps, errors[-1] * (steps / steps[-1]) ** 4, "--", color="#999999", label="fourth power of the step"
)
ax.axhline(other_order, color="#0072B2", label="two Taylor methods, orders 26 and 34")
ax.set_xticks(steps, [f"{1e3 * step:g}" for step in steps])
ax.set_xticks([], minor=True)
ax.set(xlabel="step (ms)", ylabel="largest error of the state after 1 s")
ax.legend(frameon=False)
