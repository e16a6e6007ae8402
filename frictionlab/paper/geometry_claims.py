"""Claims C16 to C20, without the geometrical nonlinearity (GN): Figs 13 to 15."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import motions, scenes
from .branches import PLANES, cycle
from .compare import Finding, Question
from .setting import Setting
from .wording import NON_PERIODIC, PERIODIC, are, count, moving, regime_changes, stretches, within

UNCHANGED = 0.02  # share by which the period of a nearly unchanged oscillation may vary
ALIKE = 0.02  # share by which cycles that are alike may differ in range or period
STEADY = 1.05  # variation along the sweep over the difference of its ends: 1 without any way back


def _unchanged(setting: Setting) -> Finding:
    """C16."""
    held, text = {}, []
    for k_nl in (0.0, 1e4):
        b = motions.from_rest(k_nl, setting, geometry=False)
        there = within(b, 0.38, 2.95)
        periodic, f = are(b, PERIODIC)[there], 1 / b.periods[there]
        held[f"periodic in [0.38, 2.95] for k_nl {k_nl:g}"] = bool(periodic.all())
        held[f"nearly unchanged for k_nl {k_nl:g}"] = bool(
            np.ptp(f) < UNCHANGED * f.mean() and np.ptp(b.onsets[there]) == 0
        )
        onsets = "/".join(map(str, np.unique(b.onsets[there])))
        text.append(
            f"k_nl {k_nl:g}: {stretches(b)}; periodic at {count(periodic)} values in [0.38, 2.95], "
            f"{f.max():.3f} to {f.min():.3f} Hz, {onsets} onsets a period, "
            f"L_s {b.intensities[there].min():.5g} to {b.intensities[there].max():.5g}"
        )
    return Finding("; ".join(text), held)


def _hard(setting: Setting) -> Finding:
    """C17."""
    b = motions.from_rest(1e7, setting, geometry=False)
    there, small = within(b, 0.05, 2.95), b.values < 0.05 - 1e-9
    held = {
        "periodic in [0.05, 2.95]": bool(are(b, PERIODIC)[there].all()),
        "non-periodic at very small mu_k": bool(are(b, NON_PERIODIC)[small].any()),
    }
    return Finding(stretches(b), held)


def _planes(setting: Setting) -> Finding:
    """C18."""
    measures = {k: _measures(cycle(k, setting)) for k in scenes.SOFT_AND_HARD}
    soft, usual, hard = measures.values()
    near, far = (float(np.abs(other / soft - 1).max()) for other in (usual, hard))
    rows = (f"k_nl {k:g}: {m[0]:.5f} m, {m[1]:.4f} m/s, {1 / m[2]:.3f} Hz" for k, m in measures.items())
    held = {"k_nl 0 and 1e4 are alike": near < ALIKE, "1e7 is different": far > ALIKE}
    text = f"ranges of x1 and x1', frequency at mu_k {PLANES:g}: {'; '.join(rows)}"
    return Finding(f"{text}; they differ by {100 * near:.2f} % and {100 * far:.1f} %", held)


def _measures(found: Any) -> Any:
    run, period = found.trajectory, found.period
    length = min(2 * period if np.isfinite(period) else 1.0, run.raw.t)
    states = run(np.linspace(run.raw.t - length, run.raw.t, 4001))
    x, v = run.names.index("x1"), run.names.index("x1'")
    return np.array([np.ptp(states[:, x]), np.ptp(states[:, v]), period])


def _steadily(setting: Setting) -> Finding:
    """C19."""
    held, text = {}, []
    for k_nl in scenes.SOFT_AND_HARD:
        without, with_gn = (
            _roughness(motions.from_rest(k_nl, setting, g), 0.38, 2.95) for g in (False, True)
        )
        held[f"it varies steadily for k_nl {k_nl:g}"] = without < STEADY
        held[f"more steadily than with GN for k_nl {k_nl:g}"] = without < with_gn
        text.append(f"k_nl {k_nl:g}: {without:.3f} without GN, {with_gn:.3f} with")
    about = "variation of L_s from value to value of mu_k, over the difference of its extremes (1: one way)"
    return Finding(f"{about}: {'; '.join(text)}", held)


def _roughness(b: Any, first: float, last: float) -> float:
    strong = b.intensities[moving(b) & within(b, first, last)]
    return float(np.abs(np.diff(strong)).sum() / np.ptp(strong)) if len(strong) > 1 else np.nan


def _preload(setting: Setting) -> Finding:
    """C20."""
    sweeps = {name: motions.over_preload(g, setting) for g, name in motions.GN.items()}
    changes = {name: regime_changes(b) for name, b in sweeps.items()}
    rough = {name: _roughness(b, 0.0, np.inf) for name, b in sweeps.items()}
    with_gn, without = motions.GN[True], motions.GN[False]
    held = {
        "there are more changes of regime with GN": changes[with_gn] > changes[without],
        "L_s changes more with GN": rough[with_gn] > rough[without],
    }
    rows = (
        f"{name}: {stretches(b)}, {changes[name]} changes of regime, variation of L_s {rough[name]:.3f}"
        for name, b in sweeps.items()
    )
    return Finding("; ".join(rows), held)


CHECKS = {
    "C16": Question(
        "Fig. 13a, b",
        "without GN, k_nl 0 and 1e4: nearly unchanged periodic oscillation for mu_k in [0.38, 2.95]",
        _unchanged,
        impacts=False,
    ),
    "C17": Question(
        "Fig. 13c",
        "without GN, k_nl 1e7: periodic in [0.05, 2.95], non-periodic at very small mu_k",
        _hard,
        impacts=False,
    ),
    "C18": Question(
        "Fig. 13d-f",
        "phase planes without GN at mu_k 2: k_nl 0 and 1e4 alike, 1e7 different",
        _planes,
        impacts=False,
    ),
    "C19": Question(
        "Fig. 14", "without GN, L_s varies steadily with mu_k, much more so than with GN", _steadily
    ),
    "C20": Question(
        "Fig. 15",
        "mu_k 2.5, k_nl 1e7, F varied: more changes of regime and of L_s with GN than without",
        _preload,
    ),
}
