"""Claims C21 to C25, with and without the non-smooth behaviours: Figs 16 to 18."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.paper import scenes
from frictionlab.paper.figures.stiff_structure import (
    PANELS_WITHOUT,
    SLIDING_ONLY,
    WITH_NONSMOOTH,
    critical_mu_k,
    deviation_text,
    frequency_panel,
    ranges,
    steady_states_compared,
)
from frictionlab.paper.results import ClaimCheck, Finding
from frictionlab.paper.scenes import (
    Setting,
    agrees_with_printed,
    count,
    in_range,
    intervals_text,
    is_kind,
    is_vibration,
)

if TYPE_CHECKING:
    from frictionlab.analysis.sweeps.bifurcation import Bifurcation

MIN_RATIO = 2.0  # times: "much larger"
MAX_DEVIATION = 0.02  # of the eigenfrequency: "close"
SYMBOLS = {"x1": ("x1", "m"), "y1": ("y1", "m"), "normal_force": ("F_N", "N")}


def _check_amplitudes(setting: Setting) -> Finding:
    """C21."""
    compared = steady_states_compared(setting)
    with_all, sliding = ranges(compared[WITH_NONSMOOTH]), ranges(compared[SLIDING_ONLY])
    held, text = {}, []
    for name, (symbol, unit) in SYMBOLS.items():
        held[f"that of {symbol} is much larger"] = sliding[name] > MIN_RATIO * with_all[name]
        ratio = sliding[name] / with_all[name]
        text.append(f"{symbol} {with_all[name]:.4g} and {sliding[name]:.4g} {unit} ({ratio:.1f} times)")
    return Finding(f"ranges with the non-smooth behaviours and without: {', '.join(text)}", held)


def _check_sliding(setting: Setting) -> Finding:
    """C22."""
    rest, down = scenes.stiff_sweep(False, setting), scenes.sliding_sweep_downwards(setting)
    periodic = {b: is_kind(b, MotionKind.PERIODIC)[in_range(b, 1.4, np.inf)] for b in (rest, down)}
    text = (
        f"followed from 3 down {intervals_text(down)}, periodic at {count(periodic[down])} values from 1.4 on"
        f"; from rest {intervals_text(rest)}, periodic at {count(periodic[rest])}"
    )
    return Finding(text, {"periodic for all mu_k >= 1.4": bool(periodic[down].all())})


def _check_nonsmooth(setting: Setting) -> Finding:
    """C23."""
    b = scenes.stiff_sweep(True, setting)
    irregular = is_kind(b, MotionKind.NON_PERIODIC)
    held = {"non-periodic for most mu_k": bool(irregular.mean() > 0.5)}
    return Finding(f"{intervals_text(b)}; non-periodic at {count(irregular)} values", held)


def _check_onset(setting: Setting) -> Finding:
    """C24."""
    sweeps = {
        True: scenes.stiff_sweep(True, setting),
        False: scenes.sliding_sweep_downwards(setting),
    }
    rest, near = (scenes.stiff_sweep(False, setting, start) for start in ("rest", "near"))
    first = {nonsmooth: _first_vibration(b) for nonsmooth, b in sweeps.items()}
    ratio = _least_intensity_ratio(sweeps)
    held = {
        "limit cycle from 0.15 with the non-smooth behaviours": bool(np.isclose(first[True], 0.15)),
        "limit cycle from 1.4 without them": bool(np.isclose(first[False], 1.4)),
        "the equilibrium loses stability at 1.735": agrees_with_printed(critical_mu_k(), "1.735"),
        "L_s is much larger without them": ratio > MIN_RATIO,
    }
    text = (
        f"first at {first[True]:g} with them, from rest; without them at {first[False]:g} followed from 3 "
        f"down, {_first_vibration(rest):g} from rest, {_first_vibration(near):g} from near the equilibrium; "
        f"stability lost at {critical_mu_k():.4f}; "
        f"from 1.4 on L_s is at least {ratio:.1f} times as large without"
    )
    return Finding(text, held)


def _first_vibration(b: Bifurcation) -> float:
    return float(b.values[is_vibration(b)].min(initial=np.inf))


def _least_intensity_ratio(sweeps: dict[bool, Any]) -> float:
    """The least ratio of the intensities at the values of mu_k from 1.4 on that both sweeps hold."""
    shared, i, j = np.intersect1d(sweeps[False].values, sweeps[True].values, return_indices=True)
    both = shared >= 1.4 - scenes.GRID_TOLERANCE
    return float((sweeps[False].intensities[i] / sweeps[True].intensities[j])[both].min())


def _check_frequencies(setting: Setting) -> Finding:
    """C25."""
    panels = {name: frequency_panel(name, setting) for name in PANELS_WITHOUT}
    off = {name: float(np.median(p.deviations)) for name, p in panels.items()}
    close = off["geometry only"]
    held = {
        "they are close with only GN": close < MAX_DEVIATION,
        "they differ more with only the cubic contact": off["contact stiffness only"] > close,
        "they differ more with only the non-smooth behaviours": off["non-smooth only"] > close,
        "they differ markedly with all three": off["all three"] > MAX_DEVIATION,
    }
    return Finding("; ".join(f"{name}: {deviation_text(p)}" for name, p in panels.items()), held)


CHECKS = {
    "C21": ClaimCheck(
        "Fig. 16",
        "mu_k 2.5, F 800 N, k4 to k6 5e6 N/m: amplitudes are much larger without the non-smooth behaviours",
        _check_amplitudes,
    ),
    "C22": ClaimCheck(
        "Fig. 17b",
        "sliding only: periodic for all mu_k >= 1.4 (x1 where its velocity is zero)",
        _check_sliding,
        impacts=False,
    ),
    "C23": ClaimCheck(
        "Fig. 17a", "with the non-smooth behaviours: non-periodic for most mu_k", _check_nonsmooth
    ),
    "C24": ClaimCheck(
        "Fig. 17c",
        "limit cycle from mu_k 0.15 with the non-smooth behaviours, from 1.4 without; the equilibrium loses "
        "stability at 1.735; L_s much larger without",
        _check_onset,
    ),
    "C25": ClaimCheck(
        "Fig. 18",
        "response frequencies against unstable eigenfrequencies: close with only GN; larger differences with "
        "only the cubic contact, or only the non-smooth behaviours; marked with all three",
        _check_frequencies,
    ),
}
