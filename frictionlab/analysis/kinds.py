"""Which kind of motion a run shows."""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.trajectory import Trajectory

from .recurrence import NEARLY, NEVER, SETTLING, Recurrence, drifts, repeats, sizes, swells
from .sections import stick_onsets

EQUILIBRIUM, PERIODIC, NON_PERIODIC = "equilibrium", "periodic", "non-periodic"
UNSETTLED, ENDED = "not settled yet", "ended early"
AT_REST = 1e-3  # size of a dying motion, as a share of the coordinates, that counts as at rest
DYING = 1.4  # by which factor it has to shrink from the first quarter of the window to the last
ROUNDING = 1e-9
SAMPLES = 8001


def kind_of(run: Trajectory, returns: Recurrence, crossings: np.ndarray, tolerance: float) -> str:
    """The kind of motion in a run with these crossings (K, m) of a section, which return so nearly."""
    resting = _at_rest(run)
    if resting is not None:
        return EQUILIBRIUM if resting else UNSETTLED
    if repeats(returns, tolerance):
        return PERIODIC
    states = run.raw.step_states
    near = returns.deviation < NEARLY or returns.shrinking > SETTLING
    on_its_way = near or drifts(crossings, sizes(states)) or swells(states)
    return UNSETTLED if returns is NEVER or on_its_way else NON_PERIODIC


def _at_rest(run: Trajectory) -> bool | None:
    """Whether a motion without events has come to rest; None where it is not on its way there."""
    if len(run.events):
        return None
    x = run(np.linspace(0.0, run.raw.t, SAMPLES))[:, : run.automaton.coordinates or None]
    first, *_, last = (float(sizes(part).max()) for part in np.array_split(x, 4))
    if last <= ROUNDING * np.abs(x).max():
        return True
    return last < AT_REST * np.abs(x).max() if last < first / DYING else None


def onsets_in(run: Trajectory, period: float) -> int:
    """Transitions from slip to stick in a period: their mean over all whole periods of the run."""
    times = run.events.t[stick_onsets(run)]
    if not len(times):
        return 0
    count = max(1, int((times[-1] - times[0]) / period + 0.5))
    # Half a thousandth of a period aside, so that rounding does not count both ends.
    return round(int((times > times[-1] - (count - 5e-4) * period).sum()) / count)
