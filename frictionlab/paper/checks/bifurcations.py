"""Claims C9 to C15, with all three nonlinearities: Figs 7 to 12; C16 to C20, without the geometrical
nonlinearity (GN): Figs 13 to 15.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import spearmanr

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.paper import scenes
from frictionlab.paper.figures.bifurcations import (
    PHASE_PLANE_MU_K,
    example_cycle,
    phase_plane_cycle,
    steady_state_text,
)
from frictionlab.paper.results import ClaimCheck, Finding
from frictionlab.paper.scenes import (
    Setting,
    count,
    in_range,
    intervals_text,
    is_kind,
    is_vibration,
    regime_changes,
)

if TYPE_CHECKING:
    from frictionlab.analysis.steady_state.steady_state import SteadyState
    from frictionlab.analysis.sweeps.bifurcation import Bifurcation

EXPECTED_OUTCOMES = {
    "near": ("rest", "rest", "vibration"),
    "rest": ("rest", "vibration", "vibration"),
}
START_WORDS = {"near": "near", "rest": "far"}
CYCLE_FREQUENCY = 1.58, 0.005  # Hz, and half a unit of its last digit

SECTION_SPREAD = 0.1  # of their largest size: section values that differ by less are nearly the same
MIN_RANK_CORRELATION = 0.5  # rank correlation with mu_k above which the intensity "generally gets stronger"
MAX_PERIOD_VARIATION = 0.02  # share by which the period of a nearly unchanged oscillation may vary
MAX_CYCLE_DIFFERENCE = 0.02  # share by which cycles that are alike may differ in range or period
MAX_ROUGHNESS = 1.05  # variation along the sweep over the difference of its extremes: 1 if monotonic


def _outcome_words(kinds: tuple[str, ...]) -> list[str]:
    words: dict[str, str] = {
        MotionKind.EQUILIBRIUM: "rest",
        MotionKind.PERIODIC: "vibration",
        MotionKind.NON_PERIODIC: "vibration",
    }
    return [words.get(kind, kind) for kind in kinds]


def _check_starts(setting: Setting) -> Finding:
    by_start = {start: scenes.example_steady_states(start, setting) for start in scenes.START_NAMES}
    held, text = {}, []
    for start, b in by_start.items():
        for mu, kind, expected in zip(b.values, _outcome_words(b.kinds), EXPECTED_OUTCOMES[start]):
            held[f"{START_WORDS[start]} at {mu:g} leads to {expected}"] = kind == expected
        rows = (f"{kind} ({s:.4g}) at {mu:g}" for mu, kind, s in zip(b.values, b.kinds, b.intensities))
        text.append(f"{START_WORDS[start]}: {', '.join(rows)}")
    held["near and far lead to the same kind of motion at 2.5"] = (
        len({b.kinds[-1] for b in by_start.values()}) == 1
    )
    return Finding(f"kind (L_s in m^2) at mu_k: {'; '.join(text)}", held)


def _check_cycles(setting: Setting) -> Finding:
    low, high = example_cycle(1.4, setting), example_cycle(2.5, setting)
    frequency = 1 / low.period if low.kind == MotionKind.PERIODIC else np.nan
    held = {
        "the motion at 1.4 is periodic": low.kind == MotionKind.PERIODIC,
        "its frequency is 1.58 Hz": bool(abs(frequency - CYCLE_FREQUENCY[0]) <= CYCLE_FREQUENCY[1]),
        "the motion at 2.5 is non-periodic": high.kind == MotionKind.NON_PERIODIC,
    }
    return Finding(f"mu_k 1.4: {steady_state_text(low)}; mu_k 2.5: {steady_state_text(high)}", held)


RESPONSE_CHECKS = {
    "C9": ClaimCheck(
        "Fig. 7",
        "mu_k 0.3: near and far go to the equilibrium; 1.4: near to the equilibrium, far to a limit cycle; "
        "2.5: both to the limit cycle",
        _check_starts,
    ),
    "C10": ClaimCheck(
        "Fig. 8", "steady state periodic at mu_k 1.4, about 1.58 Hz; non-periodic at 2.5", _check_cycles
    ),
}


def _check_sections(setting: Setting) -> Finding:
    """C11."""
    b = scenes.sweep_from_rest(1e4, setting)
    ranges = {
        "periodic for 0.9 <= mu_k < 1.8": (MotionKind.PERIODIC, 0.9, 1.8),
        "non-periodic for 0.4 <= mu_k < 0.9": (MotionKind.NON_PERIODIC, 0.4, 0.9),
        "non-periodic for 1.8 <= mu_k < 3": (MotionKind.NON_PERIODIC, 1.8, 3.0),
    }
    return Finding(*_by_range(b, ranges))


def _by_range(b: Bifurcation, ranges: Mapping[str, tuple[str, float, float]]) -> tuple[str, dict[str, bool]]:
    """Intervals and counts as text, and whether each range has one kind throughout."""
    held, counts = {}, []
    for text, (kind, first, last) in ranges.items():
        there = is_kind(b, kind)[in_range(b, first, last, open_end=True)]
        held[text] = bool(there.all())
        counts.append(f"{text} at {count(there)} values")
    return f"{intervals_text(b)} ({'; '.join(counts)})", held


def _check_coexistence(setting: Setting) -> Finding:
    """C12."""
    rest, near = scenes.sweep_from_rest(1e4, setting), scenes.sweep_from_near(1e4, setting)
    low, high = in_range(rest, 0.0, 0.4, open_end=True), near.values > 1.5 + scenes.GRID_TOLERANCE
    held = {
        "only the equilibrium for mu_k < 0.4": bool(is_kind(rest, MotionKind.EQUILIBRIUM)[low].all()),
        "only the limit cycle for mu_k > 1.5": bool(is_vibration(near)[high].all()),
        "both in [0.4, 1.5]": _solutions_coexist(rest, near, 0.4, 1.5),
    }
    return Finding(f"from rest {intervals_text(rest)}; from near {intervals_text(near)}", held)


def _solutions_coexist(rest: Bifurcation, near: Bifurcation, first: float, last: float) -> bool:
    """Whether all motions from rest vibrate and all from near the equilibrium come to rest, in a range."""
    vibrates = is_vibration(rest)[in_range(rest, first, last)].all()
    return bool(vibrates and is_kind(near, MotionKind.EQUILIBRIUM)[in_range(near, first, last)].all())


def _check_linear_contact(setting: Setting) -> Finding:
    """C13."""
    b = scenes.sweep_from_rest(0.0, setting)
    there, odd = in_range(b, 0.9, 1.8, open_end=True), in_range(b, 1.3, 1.3)
    periodic = is_kind(b, MotionKind.PERIODIC)
    held = {"periodic for 0.9 <= mu_k < 1.8 but at 1.3": bool(periodic[there & ~odd].all())}
    for mu, expected in (1.3, False), (0.05, True):
        at = in_range(b, mu, mu)
        if at.any():  # a quick grid does not hold every value
            text = "a periodic cycle" if expected else "no periodic motion"
            held[f"{text} at {mu:g}"] = bool(periodic[at].all() == expected)
    return Finding(f"{intervals_text(b)} (periodic at {count(periodic[there])} values in [0.9, 1.8))", held)


def _check_hard_contact_with_geometry(setting: Setting) -> Finding:
    """C14."""
    b = scenes.sweep_from_rest(1e7, setting)
    there, at, periodic = in_range(b, 0.75, 2.9), in_range(b, 0.1, 0.1), is_kind(b, MotionKind.PERIODIC)
    x1 = np.concatenate([s[:, b.names.index("x1")] for s, t in zip(b.sections, there) if t and len(s)])
    held = {"periodic for 0.75 <= mu_k <= 2.9": bool(periodic[there].all())}
    if at.any():
        held["periodic at 0.1"] = bool(periodic[at].all())
    held["nearly the same section values there"] = bool(np.ptp(x1) < SECTION_SPREAD * np.abs(x1).max())
    counts = (
        f"periodic at {count(periodic[there])} values in [0.75, 2.9], x1 {x1.min():.5f} to {x1.max():.5f} m"
    )
    return Finding(f"{intervals_text(b)} ({counts})", held)


def _check_intensity(setting: Setting) -> Finding:
    """C15."""
    held, text = {}, []
    for k_nl in scenes.CONTACT_STIFFNESSES:
        rest, near = (
            scenes.sweep_from_rest(k_nl, setting),
            scenes.sweep_from_near(k_nl, setting),
        )
        first, last = (0.4, 1.5) if k_nl < 1e7 else (0.0, 0.6)
        both = "[0.4, 1.5]" if k_nl < 1e7 else "(0, 0.6]"
        held[f"both coexist in {both} for k_nl {k_nl:g}"] = _solutions_coexist(rest, near, first, last)
        vibrates = is_vibration(rest)
        if k_nl < 1e7:
            ranks: Any = spearmanr(rest.values[vibrates], rest.intensities[vibrates])
            trend = float(ranks[0])
            held[f"L_s grows with mu_k for k_nl {k_nl:g}"] = bool(trend > MIN_RANK_CORRELATION)
            text.append(
                f"k_nl {k_nl:g}: {_coexistence_text(rest, near)}, rank correlation of L_s {trend:.2f}"
            )
        else:
            inside = in_range(rest, 0.75, 2.9)
            weak, strong = (_mean(rest.intensities[vibrates & w]) for w in (inside, ~inside))
            held["L_s is lower in [0.75, 2.9] for k_nl 1e7"] = bool(weak < strong)
            means = f"mean L_s {weak:.4g} in [0.75, 2.9], {strong:.4g} outside"
            text.append(f"k_nl 1e7: {_coexistence_text(rest, near)}, {means}")
    return Finding("; ".join(text), held)


def _coexistence_text(rest: Bifurcation, near: Bifurcation) -> str:
    shared = [
        v
        for v, m in zip(rest.values, is_vibration(rest))
        if m and v in near.values[is_kind(near, MotionKind.EQUILIBRIUM)]
    ]
    return f"both at {shared[0]:g} to {shared[-1]:g}" if shared else "nowhere both"


def _mean(values: Any) -> float:
    return float(np.mean(values)) if len(values) else np.nan


CONTACT_CHECKS: dict[str, ClaimCheck] = {
    "C11": ClaimCheck(
        "Fig. 9",
        "x1 at the onset of stick: periodic for 0.9 <= mu_k < 1.8, "
        "non-periodic for 0.4 <= mu_k < 0.9 and 1.8 <= mu_k < 3",
        _check_sections,
    ),
    "C12": ClaimCheck(
        "Fig. 10",
        "only the equilibrium for mu_k < 0.4, only the limit cycle for mu_k > 1.5, both in [0.4, 1.5]",
        _check_coexistence,
    ),
    "C13": ClaimCheck(
        "Fig. 11a",
        "k_nl = 0: periodic for 0.9 <= mu_k < 1.8 except 1.3; also a stable periodic cycle at 0.05",
        _check_linear_contact,
    ),
    "C14": ClaimCheck(
        "Fig. 11b",
        "k_nl = 1e7 N/m^3: periodic for 0.75 <= mu_k <= 2.9 and at 0.1, nearly the same section values there",
        _check_hard_contact_with_geometry,
    ),
    "C15": ClaimCheck(
        "Fig. 12",
        "both solutions coexist in [0.4, 1.5] for k_nl 0 and 1e4, in (0, 0.6] for 1e7; L_s grows with mu_k "
        "for 0 and 1e4; for 1e7 it is lower where the motion is periodic",
        _check_intensity,
    ),
}
WITH_GEOMETRY = RESPONSE_CHECKS | CONTACT_CHECKS


def _check_unchanged(setting: Setting) -> Finding:
    """C16."""
    held, text = {}, []
    for k_nl in (0.0, 1e4):
        b = scenes.sweep_from_rest(k_nl, setting, geometry=False)
        there = in_range(b, 0.38, 2.95)
        periodic, f = is_kind(b, MotionKind.PERIODIC)[there], 1 / b.periods[there]
        held[f"periodic in [0.38, 2.95] for k_nl {k_nl:g}"] = bool(periodic.all())
        held[f"nearly unchanged for k_nl {k_nl:g}"] = bool(
            np.ptp(f) < MAX_PERIOD_VARIATION * f.mean() and np.ptp(b.onsets[there]) == 0
        )
        onsets = "/".join(map(str, np.unique(b.onsets[there])))
        text.append(
            f"k_nl {k_nl:g}: {intervals_text(b)}; periodic at {count(periodic)} values in [0.38, 2.95], "
            f"{f.max():.3f} to {f.min():.3f} Hz, {onsets} onsets a period, "
            f"L_s {b.intensities[there].min():.5g} to {b.intensities[there].max():.5g}"
        )
    return Finding("; ".join(text), held)


def _check_hard_contact(setting: Setting) -> Finding:
    """C17."""
    b = scenes.sweep_from_rest(1e7, setting, geometry=False)
    there, small = in_range(b, 0.05, 2.95), b.values < 0.05 - scenes.GRID_TOLERANCE
    held = {
        "periodic in [0.05, 2.95]": bool(is_kind(b, MotionKind.PERIODIC)[there].all()),
        "non-periodic at very small mu_k": bool(is_kind(b, MotionKind.NON_PERIODIC)[small].any()),
    }
    return Finding(intervals_text(b), held)


def _check_phase_planes(setting: Setting) -> Finding:
    """C18."""
    measures = {k: _cycle_measures(phase_plane_cycle(k, setting)) for k in scenes.CONTACT_STIFFNESSES}
    soft, usual, hard = measures.values()
    near, far = (float(np.abs(other / soft - 1).max()) for other in (usual, hard))
    rows = (f"k_nl {k:g}: {m[0]:.5f} m, {m[1]:.4f} m/s, {1 / m[2]:.3f} Hz" for k, m in measures.items())
    held = {
        "k_nl 0 and 1e4 are alike": near < MAX_CYCLE_DIFFERENCE,
        "1e7 is different": far > MAX_CYCLE_DIFFERENCE,
    }
    text = f"ranges of x1 and x1', frequency at mu_k {PHASE_PLANE_MU_K:g}: {'; '.join(rows)}"
    return Finding(f"{text}; they differ by {100 * near:.2f} % and {100 * far:.1f} %", held)


def _cycle_measures(steady: SteadyState) -> Any:
    run, period = steady.trajectory, steady.period
    length = min(2 * period if np.isfinite(period) else 1.0, run.raw.t)
    states = run(np.linspace(run.raw.t - length, run.raw.t, 4001))
    x, v = run.names.index("x1"), run.names.index("x1'")
    return np.array([np.ptp(states[:, x]), np.ptp(states[:, v]), period])


def _check_steadiness(setting: Setting) -> Finding:
    """C19."""
    held, text = {}, []
    for k_nl in scenes.CONTACT_STIFFNESSES:
        without, with_gn = (
            _roughness(scenes.sweep_from_rest(k_nl, setting, g), 0.38, 2.95) for g in (False, True)
        )
        held[f"it varies steadily for k_nl {k_nl:g}"] = without < MAX_ROUGHNESS
        held[f"more steadily than with GN for k_nl {k_nl:g}"] = without < with_gn
        text.append(f"k_nl {k_nl:g}: {without:.3f} without GN, {with_gn:.3f} with")
    about = "variation of L_s from value to value of mu_k, over the difference of its extremes (1: one way)"
    return Finding(f"{about}: {'; '.join(text)}", held)


def _roughness(b: Bifurcation, first: float, last: float) -> float:
    strong = b.intensities[is_vibration(b) & in_range(b, first, last)]
    return float(np.abs(np.diff(strong)).sum() / np.ptp(strong)) if len(strong) > 1 else np.nan


def _check_preload(setting: Setting) -> Finding:
    """C20."""
    sweeps = {name: scenes.preload_sweep(g, setting) for g, name in scenes.GEOMETRY_NAMES.items()}
    changes = {name: regime_changes(b) for name, b in sweeps.items()}
    rough = {name: _roughness(b, 0.0, np.inf) for name, b in sweeps.items()}
    with_gn, without = scenes.GEOMETRY_NAMES[True], scenes.GEOMETRY_NAMES[False]
    held = {
        "there are more changes of regime with GN": changes[with_gn] > changes[without],
        "L_s changes more with GN": rough[with_gn] > rough[without],
    }
    rows = (
        f"{name}: {intervals_text(b)}, {changes[name]} changes of regime, variation of L_s {rough[name]:.3f}"
        for name, b in sweeps.items()
    )
    return Finding("; ".join(rows), held)


WITHOUT_GEOMETRY = {
    "C16": ClaimCheck(
        "Fig. 13a, b",
        "without GN, k_nl 0 and 1e4: nearly unchanged periodic oscillation for mu_k in [0.38, 2.95]",
        _check_unchanged,
        impacts=False,
    ),
    "C17": ClaimCheck(
        "Fig. 13c",
        "without GN, k_nl 1e7: periodic in [0.05, 2.95], non-periodic at very small mu_k",
        _check_hard_contact,
        impacts=False,
    ),
    "C18": ClaimCheck(
        "Fig. 13d-f",
        "phase planes without GN at mu_k 2: k_nl 0 and 1e4 alike, 1e7 different",
        _check_phase_planes,
        impacts=False,
    ),
    "C19": ClaimCheck(
        "Fig. 14", "without GN, L_s varies steadily with mu_k, much more so than with GN", _check_steadiness
    ),
    "C20": ClaimCheck(
        "Fig. 15",
        "mu_k 2.5, k_nl 1e7, F varied: more changes of regime and of L_s with GN than without",
        _check_preload,
    ),
}

CHECKS = WITH_GEOMETRY | WITHOUT_GEOMETRY
