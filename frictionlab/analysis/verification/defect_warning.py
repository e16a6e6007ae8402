"""A warning where steps of a run are less exact than they were asked to be, from the defects of a sample of
steps.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from frictionlab.hybrid.accuracy import defects
from frictionlab.hybrid.trajectory import Trajectory

SUSPECT_TOLERANCES = 1e4  # tolerances: the defects of sound steps are hundreds of times smaller
HARMLESS_DEFECT = 1e-9  # share of the motion's size, below what any analysis here resolves
STEPS_PER_MODE = 64  # steps of a mode that are sampled, so that the check costs next to nothing


def defect_warning(run: Trajectory) -> str | None:
    """A sentence where steps of a Taylor run are far less exact than asked, else None.

    Some steps of each mode are sampled, only of modes with other functions than polynomials of the states:
    for polynomials the series itself tells how long a step may be.
    """
    tol = run.description.get("method", {}).get("tol")
    if tol is None:
        return None
    code, order = run.problem.program.code, run.samples.order
    modes = [mode for mode in np.unique(run.raw.step_modes) if code.degrees[mode] >= order]
    steps = [_evenly_spread(np.flatnonzero(run.raw.step_modes == mode)) for mode in modes]
    if not steps:
        return None
    return defect_message(defects(run.problem, run.raw, order, np.concatenate(steps)), tol)


def defect_message(defect: Mapping[str, float], tol: float) -> str | None:
    """What is to be said of the defects of a run that was asked for a tolerance."""
    bad = {mode: size for mode, size in defect.items() if not size <= largest_sound_defect(tol)}
    if not bad:
        return None
    worst = max(bad, key=bad.__getitem__)
    return (
        f"steps in mode {worst!r} are wrong by up to {bad[worst]:.1g} of the motion's size, "
        f"{bad[worst] / tol:.0e} times the tolerance: a law may be too sharp there for its series"
    )


def largest_sound_defect(tol: float) -> float:
    """The defect above which steps that were asked for a tolerance are suspect."""
    return max(SUSPECT_TOLERANCES * tol, HARMLESS_DEFECT)


def _evenly_spread(steps: np.ndarray) -> np.ndarray:
    """Some of the steps, evenly spread."""
    return steps[np.unique(np.linspace(0, len(steps) - 1, STEPS_PER_MODE).astype(int))]
