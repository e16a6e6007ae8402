"""The steady states that Figs 7 to 18 and their claims share, each computed once, and results in words.

`steady_states` and `sweep_results` are `fl.bifurcation` and `fl.sweep` as a Setting says, kept in files
where there is a folder; the others name what each figure needs.  Printed numbers are text, so that
their last digit is known: a value agrees with one where it rounds to it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from functools import lru_cache
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import SteadyState, steady_state
from frictionlab.analysis.sweeps.bifurcation import bifurcation
from frictionlab.analysis.sweeps.sweep import sweep
from frictionlab.hybrid.methods.base import Method

from . import scenes
from .scenes import Setting, times_of

CACHE: dict[str, Any] = {}

START_NAMES = {"near": "near the equilibrium", "rest": "far from it (at rest)"}
EXAMPLES = (0.3, 1.4, 2.5)  # mu_k of Fig. 7
STICK_SECTION = "stick"
TURNING_SECTION = "x1'"  # the section of Fig. 17b, passed either way
MU_K_PRELOAD = 2.5
GEOMETRY_NAMES = {True: "with GN", False: "without GN"}

MAX_INTERVALS = 7  # intervals that a text lists at most
GRID_TOLERANCE = 1e-9  # for values that are the same but for rounding

ROUNDING_MARGIN = 1 + 1e-9  # a value that lies exactly between two roundings agrees with both


def steady_states(
    model: Any,
    values: Any,
    setting: Setting,
    x0: str = "rest",
    *,
    parameter: str = "mu_k",
    section: Any = None,
) -> Any:
    """`fl.bifurcation` as the setting says.

    Raises
    ------
    KeyboardInterrupt
        After ctrl-C; what was done is in the file, if there is a folder.
    """
    model = setting.adapt_model(model)
    options: dict[str, Any] = {"section": section, "tolerance": setting.tolerance}
    options |= times_of(model, setting)._asdict()
    asked = [model.to_dict(), parameter, list(values), x0, setting.method.describe(), options]

    def compute(path: Path | None) -> Any:
        return bifurcation(
            model,
            parameter,
            values,
            x0,
            method=setting.method,
            workers=setting.workers,
            resume=path,
            progress=setting.progress,
            **options,
        )

    return _cached(asked, setting, compute)


def sweep_results(
    name: str, function: Callable[[Any], Any], model: Any, over: dict[str, Any], setting: Setting
) -> Any:
    """`fl.sweep` of a function; `name` says which, with all that it depends on but for the model."""
    model = setting.adapt_model(model)
    asked = [name, model.to_dict(), {key: list(values) for key, values in over.items()}]

    def compute(path: Path | None) -> Any:
        options: dict[str, Any] = {"workers": setting.workers, "progress": setting.progress}
        return sweep(model, function, over, resume=path, **options)

    return _cached(asked, setting, compute)


def _cached(asked: Any, setting: Setting, compute: Callable[[Path | None], Any]) -> Any:
    key = hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:16]
    if key not in CACHE:
        path = None
        if setting.resume is not None:
            setting.resume.mkdir(parents=True, exist_ok=True)
            path = setting.resume / f"{key}.jsonl"
        CACHE[key] = compute(path)
    return CACHE[key]


def model_with_contact(k_nl: float, geometry: bool = True) -> Any:
    """The usual model with another contact, with or without the geometrical nonlinearity (GN)."""
    model = scenes.USUAL.replace(k_nl=k_nl)
    return model if geometry else model.without("geometry")


def example_steady_states(start: str, setting: Setting) -> Any:
    """Fig. 7: mu_k 0.3, 1.4 and 2.5."""
    return steady_states(scenes.USUAL, EXAMPLES, setting, start, section=STICK_SECTION)


def sweep_from_rest(k_nl: float, setting: Setting, geometry: bool = True) -> Any:
    """Figs 9, 11 and 13: from rest, against mu_k."""
    if k_nl == scenes.USUAL.k_nl and geometry:
        values = scenes.mu_k(setting)
    else:
        values = scenes.mu_k_coarse(setting, *(scenes.MU_K_NAMED_IN_TEXT if geometry else scenes.MU_K_SMALL))
    return steady_states(model_with_contact(k_nl, geometry), values, setting, section=STICK_SECTION)


def sweep_from_near(k_nl: float, setting: Setting, geometry: bool = True) -> Any:
    """Figs 10, 12 and 14: from near the equilibrium, against mu_k."""
    return steady_states(
        model_with_contact(k_nl, geometry), scenes.mu_k_near(setting), setting, "near", section=STICK_SECTION
    )


def preload_sweep(geometry: bool, setting: Setting) -> Any:
    """Fig. 15: against the preload."""
    model = model_with_contact(1e7, geometry).replace(mu_k=MU_K_PRELOAD)
    return steady_states(model, scenes.preloads(setting), setting, parameter="F", section=STICK_SECTION)


def stiff_model(nonsmooth: bool) -> Any:
    """The model of Figs 16 to 18, with or without the non-smooth behaviours."""
    return scenes.STIFF if nonsmooth else scenes.STIFF.without("nonsmooth")


def stiff_sweep(nonsmooth: bool, setting: Setting, start: str = "rest") -> Any:
    """Fig. 17: against mu_k."""
    values = scenes.mu_k_stiff(setting) if nonsmooth else scenes.mu_k_sliding(setting)
    return steady_states(
        stiff_model(nonsmooth),
        values,
        setting,
        start,
        section=STICK_SECTION if nonsmooth else TURNING_SECTION,
    )


def sliding_sweep_downwards(setting: Setting) -> Any:
    """The sliding-only model of Fig. 17b along its vibration, from mu_k = 3 down."""
    values = scenes.mu_k_sliding(setting)[::-1]
    return steady_states(stiff_model(False), values, setting, "continue", section=TURNING_SECTION)


def steady_state_of(model: Any, setting: Setting, section: Any = STICK_SECTION) -> SteadyState:
    """The steady state of one model from rest, with its run; a figure and its claim share it."""
    model = setting.adapt_model(model)
    times, tolerance = scenes.times_of(model, setting), setting.tolerance
    return _cached_steady_state(model, times, setting.method, section, tolerance, setting.progress)


@lru_cache(maxsize=32)
def _cached_steady_state(
    model: Any, times: scenes.Times, method: Method, section: Any, tolerance: float, progress: bool
) -> SteadyState:
    options: dict[str, Any] = times._asdict() | {"method": method, "tolerance": tolerance}
    return steady_state(model, section=section, progress=progress, **options)


def is_vibration(found: Any) -> NDArray[np.bool_]:
    """Where a sweep found a vibration, periodic or not, as booleans."""
    return np.isin(found.kinds, (MotionKind.PERIODIC, MotionKind.NON_PERIODIC))


def is_kind(found: Any, kind: str) -> NDArray[np.bool_]:
    """Where a sweep found this kind of motion, as booleans."""
    return np.array(found.kinds) == kind


def in_range(found: Any, first: float, last: float, *, open_end: bool = False) -> NDArray[np.bool_]:
    """Which values lie in [first, last], or in [first, last)."""
    return (found.values >= first - GRID_TOLERANCE) & (
        found.values < last + (-GRID_TOLERANCE if open_end else GRID_TOLERANCE)
    )


def intervals_text(found: Any) -> str:
    """ "equilibrium 0.05 to 0.35, periodic 0.4 to 3"; where they alternate often, how often each."""
    groups = [(kind, [v for _, v in group]) for kind, group in groupby(zip(found.kinds, found.values), _kind)]
    if len(groups) <= MAX_INTERVALS:
        return ", ".join(f"{kind} {_range_text(values)}" for kind, values in groups)
    return ", ".join(_share_text(found, kind) for kind in dict.fromkeys(found.kinds))


def count(held: Any) -> str:
    """ "3 of 10"."""
    return f"{int(np.sum(held))} of {len(held)}"


def _kind(pair: tuple[str, float]) -> str:
    return pair[0]


def _range_text(values: list[float]) -> str:
    return f"{values[0]:g}" if len(values) == 1 else f"{values[0]:g} to {values[-1]:g}"


def _share_text(found: Any, kind: str) -> str:
    chosen = is_kind(found, kind)
    values = found.values[chosen]
    return f"{kind} at {count(chosen)} values ({_range_text(values.tolist())})"


def regimes(found: Any) -> list[tuple[str, int]]:
    """Kind, and the onsets of stick in a period where there is one, of all that has settled."""
    settled = is_vibration(found) | is_kind(found, MotionKind.EQUILIBRIUM)
    return [(kind, int(n)) for kind, n, known in zip(found.kinds, found.onsets, settled) if known]


def regime_changes(found: Any) -> int:
    """How often neighbours along a sweep are of different regimes."""
    each = regimes(found)
    return sum(a != b for a, b in pairwise(each))


def agrees_with_printed(value: float, printed: str) -> bool:
    """Whether a value rounds to the number printed."""
    return abs(value - float(printed)) <= half_unit(printed) * ROUNDING_MARGIN


def half_unit(printed: str) -> float:
    """Half a unit of the last digit."""
    return 0.5 * 10.0 ** -len(printed.partition(".")[2])


def list_text(values: Iterable[float], digits: int) -> str:
    """Numbers in brackets, as the paper prints a state."""
    return f"[{', '.join(f'{value:.{digits}f}' for value in values)}]"
