"""The texts beside the picture: the equilibrium and its stability, errors, and why a run ended."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from frictionlab.analysis.run_comparison import defect_warning
from frictionlab.presentation import state_unit

from .result import time_of_rest

NOTHING_SLIDES = (
    "Steady sliding and its stability are not of this model: nothing in it slides on something that moves."
)
STARTS = {"rest": "from rest", "near": "from near the equilibrium"}
VERBS = {"stick": "sticks", "slip+": "slips", "slip-": "slips", "slip": "slips", "separation": "separates"}


def equilibrium_text(result: Any) -> str:
    """Whether steady sliding is stable, where it is, and what the run at hand does."""
    found = result.eigenvalues
    if found is None:
        return no_sliding_text(result)
    point = found.equilibrium
    rows = [(name, x, state_unit(name)) for name, x in zip(result.model.coordinates, point.q)]
    rows += [
        ("penetration", point.penetration, "m"),
        ("F_N", point.normal_force, "N"),
        ("F_T", point.friction_force, "N"),
    ]
    rows = [row for row in rows if not np.isnan(row[1])]
    numbers = " ".join(f"<span>{escape(n)} = {x:.5g} {u}</span>" for n, x, u in rows)
    return f"{verdict_text(result)}<br>{numbers}"


def verdict_text(result: Any) -> str:
    """Whether steady sliding is stable, and what the run at hand does, in a sentence."""
    found = result.eigenvalues
    if found is None:
        return no_sliding_text(result)
    happens = run_text(result)
    joint = "but" if found.stable else "and"
    run = f", {joint} {happens}" if happens else ""
    return f"<b>Steady sliding is {stability_text(found)}{escape(run, quote=False)}.</b>"


def no_sliding_text(result: Any) -> str:
    """That there is no steady sliding, why, and what the run does; the cure where something can slide."""
    happens = run_text(result)
    run = f" {happens[0].upper()}{happens[1:]}." if happens else ""
    if not can_slide_steadily(result.model):
        text = f"<b>{escape(NOTHING_SLIDES + run, quote=False)}</b>"
    else:
        reason = escape(result.no_equilibrium_reason + run, quote=False)
        text = f"<b>No steady sliding</b>: {reason}"
    return text


def can_slide_steadily(model: Any) -> bool:
    """Whether something in a model slides while all coordinates are at rest: on a belt, say."""
    mode = next(iter(model.automaton().modes))
    found = [e for name, e in mode.outputs.items() if name.startswith("relative_velocity")]
    return any(e.subs({s: 0 for s in e.free_symbols if s.name.endswith("'")}) != 0 for e in found)


def run_text(result: Any) -> str:
    """What the run at hand does at its end, in a clause; empty where it settles to the equilibrium."""
    if not result.has_run or not result.run.status.ok:
        return ""
    start = STARTS.get(result.settings.x0, "from your own state")
    if not result.is_moving:
        stops = "slip" not in result.run.mode[-1]  # in slip it is the equilibrium that it came to
        return f"{start} this run is over after {time_of_rest(result.run):.3g} s" if stops else ""
    what = _motion(result)
    if not what and result.decays:
        return ""
    spectrum = result.spectrum if result.has_spectrum else None  # computed where a panel shows it
    strongest = 0.0 if spectrum is None else spectrum.strongest
    pitch = f" at {strongest:.3g} Hz" if strongest > 0 else ""
    return f"{start} this run {what or 'vibrates'}{pitch}"


def _motion(result: Any) -> str:
    """What the modes of the part that is shown say; empty where there is one only."""
    modes, times = set(result.modes), result.times()
    regimes = {regime for mode in modes for regime in mode.split(" | ")}
    struck = bool(np.any(result.run.events.t > times[0]))
    if regimes == {"flight"}:
        return "hits its stop" if struck else ""
    verbs = list(dict.fromkeys(verb for regime, verb in VERBS.items() if regime in regimes))
    if len(verbs) > 1:
        return f"{', '.join(verbs[:-1])} and {verbs[-1]}"
    return "slips to and fro" if {"slip+", "slip-"} <= regimes else ""


def stability_text(found: Any) -> str:
    """Stable, or which mode grows, how fast and at what frequency."""
    upper = found.values[found.values.imag >= 0]
    growing = upper[upper.real > 0]
    if not len(growing):
        slowest = upper.real.max()
        return "stable" if slowest < 0 else "neither stable nor unstable: a mode neither grows nor decays"
    worst = growing[np.argmax(growing.real)]
    modes = "1 mode grows" if len(growing) == 1 else f"{len(growing)} modes grow"
    return f"unstable: {modes}, at {worst.real:.4g} 1/s and {worst.imag / (2 * np.pi):.4g} Hz"


def error_text(error: Exception) -> str:
    """The message of an error; that of other errors than bad values begins with their class."""
    kind = "" if isinstance(error, (ValueError, TypeError)) else f"{type(error).__name__}: "
    return (
        f"<b>{escape(kind + (str(error) or type(error).__name__), quote=False)}</b><br>"
        "The picture is that of the last values that worked."
    )


def run_end_text(result: Any) -> str:
    """A sentence where the run did not reach its end, or its steps are not as exact as they should be."""
    if not result.has_run:
        return ""
    if result.run.status.ok:
        warning = defect_warning(result.run)
        return "" if warning is None else escape(f"Do not trust this picture: {warning}.")
    return escape(f"The run ended at {result.run.raw.t:.4g} s: {result.run.status}.")
