"""Dense output: a step's Taylor polynomial is computed again from the state at its start.

Storing states instead of polynomials needs a twentieth of the memory and costs a jet per step looked at.
"""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.compiled import kernel
from frictionlab.hybrid.jets import mode_jets, states_at
from frictionlab.hybrid.powers import is_near_zero, scale_of_powers, series_near_zero


@kernel
def series_of_step(code, numbers, mode, order, h, z, J):
    """The jets of which a step of length `h` from `z` consists, as the step was taken."""
    mode_jets(code, numbers, mode, order, z, J)
    if code.powers[mode] and is_near_zero(code, order, mode, J):
        passes = h > scale_of_powers(code, mode, J)
        series_near_zero(code, numbers, mode, order, z, passes, J)


@kernel
def sample(code, numbers, order, step_times, step_modes, step_states, steps, times, out, J):
    """Write the states at ascending `times`, each within the step of number ``steps[i]``, into `out`."""
    current = -1
    for i in range(times.shape[0]):
        step = steps[i]
        if step != current:
            mode, h = step_modes[step], step_times[step, 1]
            series_of_step(code, numbers, mode, order, h, step_states[step], J)
            current = step
        states_at(J, order, times[i] - step_times[step, 0], out[i])


def subdivide(step_times: np.ndarray, parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Times that cut every step into `parts`, ends left out, and the step each belongs to."""
    share = np.arange(parts) / parts
    times = step_times[:, :1] + step_times[:, 1:] * share
    steps = np.repeat(np.arange(len(step_times)), parts)
    return times.ravel(), steps
