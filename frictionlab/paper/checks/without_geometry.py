"""Claims C16 to C20, without the geometrical nonlinearity (GN): Figs 13 to 15."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.paper import scenes, steady_states
from frictionlab.paper.figures.bifurcations import PHASE_PLANE_MU_K, phase_plane_cycle
from frictionlab.paper.scenes import Setting
from frictionlab.paper.steady_states import (
    count,
    in_range,
    intervals_text,
    is_kind,
    is_vibration,
    regime_changes,
)

from .claim import Finding, Question

MAX_PERIOD_VARIATION = 0.02  # share by which the period of a nearly unchanged oscillation may vary
MAX_CYCLE_DIFFERENCE = 0.02  # share by which cycles that are alike may differ in range or period
MAX_ROUGHNESS = 1.05  # variation along the sweep over the difference of its ends: 1 without any way back


def _check_unchanged(setting: Setting) -> Finding:
    """C16."""
    held, text = {}, []
    for k_nl in (0.0, 1e4):
        b = steady_states.sweep_from_rest(k_nl, setting, geometry=False)
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
    b = steady_states.sweep_from_rest(1e7, setting, geometry=False)
    there, small = in_range(b, 0.05, 2.95), b.values < 0.05 - 1e-9
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


def _cycle_measures(found: Any) -> Any:
    run, period = found.trajectory, found.period
    length = min(2 * period if np.isfinite(period) else 1.0, run.raw.t)
    states = run(np.linspace(run.raw.t - length, run.raw.t, 4001))
    x, v = run.names.index("x1"), run.names.index("x1'")
    return np.array([np.ptp(states[:, x]), np.ptp(states[:, v]), period])


def _check_steadiness(setting: Setting) -> Finding:
    """C19."""
    held, text = {}, []
    for k_nl in scenes.CONTACT_STIFFNESSES:
        without, with_gn = (
            _roughness(steady_states.sweep_from_rest(k_nl, setting, g), 0.38, 2.95) for g in (False, True)
        )
        held[f"it varies steadily for k_nl {k_nl:g}"] = without < MAX_ROUGHNESS
        held[f"more steadily than with GN for k_nl {k_nl:g}"] = without < with_gn
        text.append(f"k_nl {k_nl:g}: {without:.3f} without GN, {with_gn:.3f} with")
    about = "variation of L_s from value to value of mu_k, over the difference of its extremes (1: one way)"
    return Finding(f"{about}: {'; '.join(text)}", held)


def _roughness(b: Any, first: float, last: float) -> float:
    strong = b.intensities[is_vibration(b) & in_range(b, first, last)]
    return float(np.abs(np.diff(strong)).sum() / np.ptp(strong)) if len(strong) > 1 else np.nan


def _check_preload(setting: Setting) -> Finding:
    """C20."""
    sweeps = {
        name: steady_states.preload_sweep(g, setting) for g, name in steady_states.GEOMETRY_NAMES.items()
    }
    changes = {name: regime_changes(b) for name, b in sweeps.items()}
    rough = {name: _roughness(b, 0.0, np.inf) for name, b in sweeps.items()}
    with_gn, without = steady_states.GEOMETRY_NAMES[True], steady_states.GEOMETRY_NAMES[False]
    held = {
        "there are more changes of regime with GN": changes[with_gn] > changes[without],
        "L_s changes more with GN": rough[with_gn] > rough[without],
    }
    rows = (
        f"{name}: {intervals_text(b)}, {changes[name]} changes of regime, variation of L_s {rough[name]:.3f}"
        for name, b in sweeps.items()
    )
    return Finding("; ".join(rows), held)


CHECKS = {
    "C16": Question(
        "Fig. 13a, b",
        "without GN, k_nl 0 and 1e4: nearly unchanged periodic oscillation for mu_k in [0.38, 2.95]",
        _check_unchanged,
        impacts=False,
    ),
    "C17": Question(
        "Fig. 13c",
        "without GN, k_nl 1e7: periodic in [0.05, 2.95], non-periodic at very small mu_k",
        _check_hard_contact,
        impacts=False,
    ),
    "C18": Question(
        "Fig. 13d-f",
        "phase planes without GN at mu_k 2: k_nl 0 and 1e4 alike, 1e7 different",
        _check_phase_planes,
        impacts=False,
    ),
    "C19": Question(
        "Fig. 14", "without GN, L_s varies steadily with mu_k, much more so than with GN", _check_steadiness
    ),
    "C20": Question(
        "Fig. 15",
        "mu_k 2.5, k_nl 1e7, F varied: more changes of regime and of L_s with GN than without",
        _check_preload,
    ),
}
