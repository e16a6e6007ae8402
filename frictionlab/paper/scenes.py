"""Models and grids of Figs 7 to 18.

The paper gives no grids: mu_k goes in steps of 0.05 or 0.1, with further values that its text names, and the
preload is varied over the range of Fig. 4.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.models import SliderOnBelt

from .setting import Setting

Array = NDArray[Any]
USUAL = SliderOnBelt()
STIFF = SliderOnBelt(F=800.0, k_nl=1e7, k4=5e6, k5=5e6, k6=5e6)  # Figs 16 to 18
SOFT_AND_HARD = (0.0, 1e4, 1e7)  # k_nl in N/m^3
NAMED = (0.05, 0.75)  # further mu_k that the text on Fig. 11 names
SMALL = (0.01, 0.02, 0.03, 0.04, 0.05, 0.38)  # and without GN: "very small", and where Fig. 13 begins


TURN = (1.35, 1.4)  # and sliding only, where Fig. 17b begins


class Times(NamedTuple):
    """Seconds thrown away, and looked at."""

    transient: float
    window: float


USUAL_TIMES = Times(300.0, 100.0)  # by Eq. (13) the belt's rotation takes 200 s to settle
FIXED_STEP_TIMES = Times(300.0, 60.0)
STIFF_TIMES = Times(150.0, 50.0)  # at 30 Hz; sliding only it settles as slowly as the usual one


def times_of(model: Any, setting: Setting) -> Times:
    """What a model is given, by the cost of its motion and by how slowly it settles."""
    if setting.algorithm == "paper":
        return FIXED_STEP_TIMES
    smooth = "separation" not in model.interface.modes
    return STIFF_TIMES if model.k4 == STIFF.k4 and not smooth else USUAL_TIMES


def mu_k(setting: Setting) -> Array:
    """0.05, 0.1, ... 3: Figs 9 and 10."""
    return _tidy(np.arange(1, 61)[_every(setting)] * 0.05)


def mu_k_coarse(setting: Setting, *further: float) -> Array:
    """0.1, 0.2, ... 3 and the further values that a text names: where there are many sweeps."""
    return _tidy(np.append(np.arange(1, 31)[_every(setting)] * 0.1, further))


def mu_k_near(setting: Setting) -> Array:
    """0.2, 0.4, ... 3, for the start near the equilibrium: eigenvalues say exactly where it is stable."""
    return mu_k(setting)[1::2] if setting.quick else mu_k(setting)[3::4]


def mu_k_stiff(setting: Setting) -> Array:
    """0.1, 0.2, ... 3, and closer together at the lower end."""
    return _tidy(np.append(np.arange(1, 31)[_every(setting)] * 0.1, (0.05, 0.1, 0.15)))


def mu_k_sliding(setting: Setting) -> Array:
    """Of the stiff structure, sliding only: as fine as for Fig. 9."""
    return np.union1d(mu_k(setting), TURN)


def preloads(setting: Setting) -> Array:
    """F in N: 50, 100, ... 1000."""
    return _tidy(np.arange(1, 21)[_every(setting)] * 50.0)


def _every(setting: Setting) -> slice:
    return slice(3, None, 4) if setting.quick else slice(None)


def _tidy(values: Array) -> Array:
    """Ascending, each once, without the rounding of steps."""
    return np.unique(np.round(values, 10))
