"""The steady states that Figs 7 to 17 and their claims speak of."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from frictionlab.analysis.steady_state import SteadyState, steady_state
from frictionlab.hybrid.methods import Method

from . import scenes
from .setting import Setting
from .sweeps import steady_states

STARTS = {"near": "near the equilibrium", "rest": "far from it (at rest)"}
EXAMPLES = (0.3, 1.4, 2.5)  # mu_k of Fig. 7
STICK = "stick"
TURNING = "x1'"  # the section of Fig. 17b, passed either way
MU_K_PRELOAD = 2.5
GN = {True: "with GN", False: "without GN"}


def contact(k_nl: float, geometry: bool = True) -> Any:
    """The usual model with another contact, with or without the geometrical nonlinearity (GN)."""
    model = scenes.USUAL.replace(k_nl=k_nl)
    return model if geometry else model.without("geometry")


def examples(start: str, setting: Setting) -> Any:
    """Fig. 7: mu_k 0.3, 1.4 and 2.5."""
    return steady_states(scenes.USUAL, EXAMPLES, setting, start, section=STICK)


def from_rest(k_nl: float, setting: Setting, geometry: bool = True) -> Any:
    """Figs 9, 11 and 13: from rest, against mu_k."""
    if k_nl == scenes.USUAL.k_nl and geometry:
        values = scenes.mu_k(setting)
    else:
        values = scenes.mu_k_coarse(setting, *(scenes.NAMED if geometry else scenes.SMALL))
    return steady_states(contact(k_nl, geometry), values, setting, section=STICK)


def from_near(k_nl: float, setting: Setting, geometry: bool = True) -> Any:
    """Figs 10, 12 and 14: from near the equilibrium, against mu_k."""
    return steady_states(contact(k_nl, geometry), scenes.mu_k_near(setting), setting, "near", section=STICK)


def over_preload(geometry: bool, setting: Setting) -> Any:
    """Fig. 15: against the preload."""
    model = contact(1e7, geometry).replace(mu_k=MU_K_PRELOAD)
    return steady_states(model, scenes.preloads(setting), setting, parameter="F", section=STICK)


def stiff(nonsmooth: bool) -> Any:
    """The model of Figs 16 to 18, with or without the non-smooth behaviours."""
    return scenes.STIFF if nonsmooth else scenes.STIFF.without("nonsmooth")


def stiff_sweep(nonsmooth: bool, setting: Setting, start: str = "rest") -> Any:
    """Fig. 17: against mu_k."""
    values = scenes.mu_k_stiff(setting) if nonsmooth else scenes.mu_k_sliding(setting)
    return steady_states(stiff(nonsmooth), values, setting, start, section=STICK if nonsmooth else TURNING)


def sliding_downwards(setting: Setting) -> Any:
    """The sliding-only model of Fig. 17b along its vibration, from mu_k = 3 down."""
    values = scenes.mu_k_sliding(setting)[::-1]
    return steady_states(stiff(False), values, setting, "continue", section=TURNING)


def single(model: Any, setting: Setting, section: Any = STICK) -> SteadyState:
    """The steady state of one model from rest, with its run; a figure and its claim share it."""
    model = setting.adapted(model)
    times, tolerance = scenes.times_of(model, setting), setting.tolerance
    return _settled(model, times, setting.method, section, tolerance, setting.progress)


@lru_cache(maxsize=32)
def _settled(
    model: Any, times: scenes.Times, method: Method, section: Any, tolerance: float, progress: bool
) -> SteadyState:
    options: dict[str, Any] = times._asdict() | {"method": method, "tolerance": tolerance}
    return steady_state(model, section=section, progress=progress, **options)
