"""The texts beside the picture: the equilibrium and its stability, errors, and why a run ended."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from frictionlab.analysis.verification.run_comparison import defect_warning
from frictionlab.presentation import state_unit


def equilibrium_text(result: Any) -> str:
    """Whether steady sliding is stable, and where it is."""
    found = result.eigenvalues
    if found is None:
        return f"<b>No steady sliding.</b> {escape(result.no_equilibrium_reason, quote=False)}"
    point = found.equilibrium
    rows = [(name, x, state_unit(name)) for name, x in zip(result.model.coordinates, point.q)]
    rows += [
        ("penetration", point.penetration, "m"),
        ("F_N", point.normal_force, "N"),
        ("F_T", point.friction_force, "N"),
    ]
    rows = [row for row in rows if not np.isnan(row[1])]
    numbers = " ".join(f"<span>{escape(n)} = {x:.5g} {u}</span>" for n, x, u in rows)
    return f"<b>Steady sliding is {stability_text(found)}</b><br>{numbers}"


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
