"""Which kind of motion a run shows."""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.trajectory import Trajectory

from .clocks import come_round, undisturbed, unwound
from .fading import dies, fades
from .recurrence import FEWEST, NEARLY, SETTLING, Array, Recurrence, drifts, repeats, sizes, swells
from .sections import stick_onsets

EQUILIBRIUM, PERIODIC, NON_PERIODIC = "equilibrium", "periodic", "non-periodic"
UNSETTLED, ENDED = "not settled yet", "ended early"
AT_REST = 1e-3  # size of a dying motion, as a share of the coordinates, that counts as at rest
DYING = 1.4  # by which factor it has to shrink from the first quarter of the window to the last
ROUNDING = 1e-9
SAMPLES = 8001


def kind_of(run: Trajectory, crossings: Array, returns: Recurrence, tolerance: float) -> str:
    """The kind of motion in a run with these crossings (K, m) of a section, which return so nearly.

    Crossings are those of :func:`frictionlab.analysis.clocks.unwound`.
    """
    resting = _at_rest(run)
    if resting is not None:
        return EQUILIBRIUM if resting else UNSETTLED
    if repeats(returns, tolerance):
        return PERIODIC
    if _dies_slowly(run):
        return EQUILIBRIUM
    near = returns.deviation < NEARLY or returns.shrinking > SETTLING
    return UNSETTLED if len(crossings) < FEWEST or near or _on_its_way(run, crossings) else NON_PERIODIC


def _at_rest(run: Trajectory) -> bool | None:
    """Whether a motion without events has come to rest; None where it is not on its way there."""
    if not undisturbed(run):
        return None
    x = _even(run)[:, : run.automaton.coordinates or None]
    first, *_, last = (float(sizes(part).max()) for part in np.array_split(x, 4))
    if sizes(x).max() <= ROUNDING * np.abs(x).max():
        return come_round(run)  # what a force holds now it may move later on
    if len(run.events):
        return None
    if last <= ROUNDING * np.abs(x).max():
        return True
    return last < AT_REST * np.abs(x).max() if last < first / DYING else None


def _dies_slowly(run: Trajectory) -> bool:
    """Whether a motion without events has all but died, too slowly to shrink much within the window."""
    if len(run.events):
        return False
    x = _even(run)
    coordinates = x[:, : run.automaton.coordinates or None]
    small = sizes(coordinates).max() < AT_REST * np.abs(coordinates).max()
    return bool(small and dies(x, sizes(x)))


def _on_its_way(run: Trajectory, crossings: Array) -> bool:
    """Whether a motion that does not repeat goes one way all along."""
    size = sizes(unwound(run, run.raw.step_states))
    if drifts(crossings, size) or swells(run.raw.step_states) or fades(crossings, size):
        return True
    x = unwound(run, _even(run))
    return fades(x, sizes(x), evenly=not undisturbed(run))


def _even(run: Trajectory) -> Array:
    """States (N, m) at even times."""
    return run(np.linspace(0.0, run.raw.t, SAMPLES))


def onsets_in(run: Trajectory, period: float) -> int:
    """Transitions from slip to stick in a period: their mean over all whole periods of the run."""
    times = run.events.t[stick_onsets(run)]
    if not len(times):
        return 0
    count = max(1, int((times[-1] - times[0]) / period + 0.5))
    # Half a thousandth of a period aside, so that rounding does not count both ends.
    return round(int((times > times[-1] - (count - 5e-4) * period).sum()) / count)
